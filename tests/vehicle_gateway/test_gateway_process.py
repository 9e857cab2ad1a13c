"""The gateway as it runs in the car: its own process, a real link and a real bus; a tower and an ECU of this test's own.

What the drive-by-wire does is only as much as is needed here: it follows every acceleration at once and never steers.
"""

import os
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from pathlib import Path
from typing import Any

import msgspec
import pytest
from cryptography import x509

from recordings.audit.drives import remote_drives
from recordings.audit.source import read_lines, readable
from recordings.audit.verify import verify
from tests.messages import drive_command
from vehicle_gateway.audit.file import audit_file
from vehicle_gateway.authority import Event
from vehicle_gateway.can.bus import Bus, open_bus
from vehicle_gateway.can.codec import FOLLOWING
from vehicle_gateway.can.ecu_codec import (
    Command,
    CommandState,
    Controls,
    Motion,
    decode_command,
    encode_controls,
    encode_drive_state,
    encode_motion,
)
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.failsafe import RULES
from vehicle_gateway.memory import Remembered
from wire import certificates
from wire.authority import issue
from wire.clock import Clock
from wire.configuration import shipped
from wire.identity import Signer, signer_of
from wire.link import open_link
from wire.messages.audit import AuditEntry, AuditKind
from wire.messages.base import Gear
from wire.messages.operating import TowerStop
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.messages.vehicle import GatewayStatus, Mode
from wire.ports import free_udp_ports
from wire.settings import LinkSettings
from wire.signature import sign
from wire.topics import Role

PROGRAM = [sys.executable, "-c", "from vehicle_gateway.program import main; main()", "run", "--config"]
PATIENCE_S = 10.0


def until(done: Callable[[], Any], seconds: float = PATIENCE_S) -> Any:
    """What `done` says as soon as it is true."""
    pause = threading.Event()
    for _ in range(round(seconds / 0.005)):
        found = done()
        if found:
            return found
        pause.wait(0.005)
    raise AssertionError("it did not come in time")


class Site:
    """One car's configuration in a folder of its own, and everybody around the gateway."""

    def __init__(self, folder: Path) -> None:
        certificates.ensure(folder / "certificates")
        self.memory = folder / "memory.json"
        car_port, tower_port, can_port = free_udp_ports(3)
        self.link = LinkSettings(
            certificates=str(folder / "certificates"),
            car_hub=f"127.0.0.1:{car_port}",
            tower_hub=f"127.0.0.1:{tower_port}",
            accepts_script=False,
            dials="tower",
        )
        self.can = CanSettings(port=can_port)
        self.config = folder / "car.toml"
        vehicle = shipped("simulated.toml").read_text(encoding="utf-8").split("[vehicle]")[1].split("[vehicle_gateway")[0]
        lines = (
            "[wire.pace]\nfifo_priority = 0",
            f'[wire.link]\ncertificates = "{self.link.certificates}"',
            f'car_hub = "{self.link.car_hub}"\ntower_hub = "{self.link.tower_hub}"',
            f"[vehicle]{vehicle}",
            f'[vehicle_gateway]\nmemory = "{self.memory}"',
            f"[vehicle_gateway.can]\nport = {self.can.port}",
        )
        self.config.write_text("\n".join(lines), encoding="utf-8")

    def remembered(self) -> Remembered:
        return msgspec.json.decode(self.memory.read_bytes(), type=Remembered)

    def told(self) -> list[AuditEntry]:
        return [each.entry for each in readable(read_lines(audit_file(self.memory)))]

    def ended_drives(self) -> int:
        return sum(bool(drive.end_cause) for drive in remote_drives(self.told()))

    def start(self) -> subprocess.Popen[str]:
        return subprocess.Popen([*PROGRAM, str(self.config)], stderr=subprocess.PIPE, text=True)


class Ecu:
    """Feedback every 10 ms; the newest command."""

    def __init__(self) -> None:
        self.state = CommandState()
        self.commands: list[Command] = []
        self.speed_m_s = 0.0
        self.controls = Controls()

    def on_frame(self, frame: Frame, _: int) -> None:
        before = self.state
        self.state, _reason = decode_command(before, frame)
        if self.state.command is not None and self.state.command is not before.command:
            self.commands.append(self.state.command)

    def send(self, bus: Bus, stop: threading.Event) -> None:
        counter = 0
        while not stop.wait(0.01):
            counter += 1
            command = self.state.command
            self.speed_m_s = max(self.speed_m_s + (command.acceleration_m_s2 * 0.01 if command else 0.0), 0.0)
            bus.send(encode_drive_state(Gear.DRIVE, FOLLOWING, self.speed_m_s == 0.0, counter))
            bus.send(encode_controls(self.controls, counter))
            bus.send(encode_motion(Motion(self.speed_m_s, 0.0, 0.0, 0.0), counter))


class Tower:
    """A cockpit of 100 Hz with a picture that is always new, on the same machine and so on the same clock."""

    def __init__(self, link: Any, video: Any, signer: Signer, operator: str = "ann") -> None:
        """video: speaks for the front camera; None where another tower's does."""
        self.link, self.video, self.signer, self.operator = link, video, signer, operator
        self.status: GatewayStatus | None = None
        self.state = link.level("vehicle_state")
        link.on("gateway_status", self._told)
        self.lease: LeaseReply | None = None
        self.sequence = self.number = 0
        self.silent = False
        self.throttle, self.forge = 0.0, False

    def _told(self, status: GatewayStatus, _: int) -> None:
        self.status = status

    def mode(self) -> Mode | None:
        return None if self.status is None else self.status.mode

    def ask_lease(self) -> LeaseReply:
        self.lease = until(lambda: reply if (reply := self.ask_lease_once()) and reply.granted else None)
        return self.lease

    def ask_lease_once(self) -> LeaseReply | None:
        if self.status is None:
            return None
        heard = {"echoed_vehicle_ns": self.status.stamp_ns, "echoed_boot_id": self.status.boot_id}
        question = LeaseRequest(operator=self.operator, session=f"{self.operator} 1", sent_ns=1, **heard)
        return self.link.ask("lease", self.signer.sign(question), 0.5)

    def ask(self, action: Action) -> Any:
        assert self.lease is not None
        self.number += 1
        request = HandOverRequest(
            lease_epoch=self.lease.epoch,
            number=self.number,
            action=action,
            sent_ns=1,
            echoed_vehicle_ns=self.status.stamp_ns,
            echoed_boot_id=self.status.boot_id,
        )
        reply = self.link.ask("hand_over", sign(request, bytes.fromhex(self.lease.key_hex)), 1.0)
        if reply is not None and reply.outcome is Outcome.GRANTED:
            self.lease = msgspec.structs.replace(self.lease, epoch=reply.lease_epoch)
        return reply

    def send(self, stop: threading.Event) -> None:
        while not stop.wait(0.01):
            now_ns = Clock().now_ns()
            if self.sequence % 20 == 0 and self.video is not None:
                self.video.publish(
                    "camera_status",
                    CameraStatus(
                        stamp_ns=now_ns,
                        camera="front",
                        source="simulated",
                        live=True,
                        newest_capture_ns=now_ns,
                        frames=1,
                        repeated=0,
                        bitrate_kbps=1.0,
                        encode_ms=1.0,
                        watching=1,
                    ),
                )
            self.sequence += 1
            newest = self.state.get()
            if self.silent or self.lease is None or newest is None:
                continue
            command = drive_command(
                lease_epoch=self.lease.epoch,
                sequence=self.sequence,
                sent_ns=now_ns,
                event_ns=now_ns,
                echoed_vehicle_ns=newest.message.stamp_ns,
                echoed_boot_id=newest.message.boot_id,
                displayed_capture_ns={"front": max(now_ns - 60_000_000, 0)},
                acceleration_m_s2=self.throttle,
            )
            key = bytes(32) if self.forge else bytes.fromhex(self.lease.key_hex)
            self.link.publish("drive_command", sign(command, key))


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Site:
    return Site(tmp_path_factory.mktemp("car"))


Around = tuple[Tower, Ecu, Callable[[], subprocess.Popen[str]]]


@pytest.fixture
def around(site: Site) -> Iterator[Around]:
    with surroundings(site) as they:
        yield they


@contextmanager
def surroundings(site: Site) -> Iterator[Around]:
    """A tower and an ECU around the gateway, which the test starts, and starts again, itself."""
    stop = threading.Event()
    site.memory.unlink(missing_ok=True)
    started: list[subprocess.Popen[str]] = []

    def start() -> subprocess.Popen[str]:
        started.append(site.start())
        return started[-1]

    with ExitStack() as stack:
        stack.callback(lambda: [process.kill() for process in started])
        ecu = Ecu()
        bus = stack.enter_context(open_bus(site.can, "vehicle", ecu.on_frame, Clock()))
        process = start()
        video = stack.enter_context(open_link(site.link, Role.VIDEO, Clock(), stop))
        link = stack.enter_context(open_link(site.link, Role.TOWER_HUB, Clock(), stop, hub=True))
        tower = Tower(link, video, signer_of(Path(site.link.certificates), Role.TOWER_HUB))
        threads = [threading.Thread(target=ecu.send, args=(bus, stop)), threading.Thread(target=tower.send, args=(stop,))]
        for thread in threads:
            thread.start()
        stack.callback(lambda: [thread.join() for thread in threads])
        stack.callback(stop.set)
        yield tower, ecu, lambda: process if process.poll() is None else start()
    for process in started:
        process.wait()
        if process.stderr is not None:
            process.stderr.close()


def silent(ecu: Ecu) -> bool:
    """Whether no command comes for 0.2 s, twenty cycles, after what was on its way when the signal was sent."""
    pause = threading.Event()
    pause.wait(0.1)
    heard = len(ecu.commands)
    pause.wait(0.2)
    return len(ecu.commands) == heard


def test_a_drive_from_standby_to_remote_a_forger_a_silence_and_a_kill(around, site: Site):
    """One story for one start of everything: a real link and a real bus take a second to come up."""
    tower, ecu, start = around
    process = start()
    until(lambda: tower.mode() is Mode.STANDBY)
    until(lambda: ecu.commands)
    assert all(command.acceleration_m_s2 < 0.0 for command in ecu.commands), "it drove in STANDBY"
    first = tower.ask_lease()
    until(lambda: tower.status.take_refused == "")
    assert tower.ask(Action.TAKE).outcome is Outcome.GRANTED
    until(lambda: tower.mode() is Mode.REMOTE)
    tower.throttle = 1.0
    until(lambda: ecu.speed_m_s > 0.2)
    assert ecu.state.command.mode is Mode.REMOTE

    tower.forge = True  # everything right but the key
    until(lambda: tower.mode() in (Mode.SAFE_STOP, Mode.STOPPED))
    until(lambda: tower.status.dropped.get("command signature", 0) > 10)
    until(lambda: ecu.speed_m_s == 0.0 and tower.mode() is Mode.STOPPED)

    tower.forge, tower.throttle = False, 0.0
    until(lambda: tower.status.take_refused == "")
    assert tower.ask(Action.TAKE).outcome is Outcome.GRANTED
    until(lambda: tower.mode() is Mode.REMOTE)
    tower.silent = True  # and now the same with silence
    until(lambda: tower.mode() is Mode.STOPPED)
    tower.silent = False
    until(lambda: site.remembered().stop_latched and site.ended_drives() == 2)  # kept by threads of their own

    used, boot_id = tower.lease.epoch, tower.status.boot_id
    process.send_signal(signal.SIGSTOP)  # hung: nothing goes on for it, neither the kernel nor a thread of its own
    assert silent(ecu), "frames went on when the gateway hung"
    process.send_signal(signal.SIGCONT)
    heard = len(ecu.commands)
    until(lambda: len(ecu.commands) > heard)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert silent(ecu), "frames went on when the gateway was dead"
    start()
    until(lambda: tower.status.boot_id != boot_id)
    assert tower.mode() in (Mode.STOPPED, Mode.SAFE_STOP), "the stop was forgotten"
    refused = until(lambda: tower.ask(Action.TAKE))
    assert refused.outcome is Outcome.REFUSED, "the key of the dead gateway's lease still opens"
    second = tower.ask_lease()
    assert second.epoch > used > first.epoch
    assert second.key_hex != first.key_hex


def test_the_audit_trail_of_that_story_is_whole_and_numbers_its_drives(site: Site):
    """Two drives, both ended by a safe stop; a kill, and a start behind it. Runs on what the story before it left."""
    lines = read_lines(audit_file(site.memory))
    authority = x509.load_pem_x509_certificate((Path(site.link.certificates) / "authority.pem").read_bytes())
    assert verify(lines, authority).problems == ()
    entries = site.told()
    drives = remote_drives(entries)
    assert [(drive.number, drive.operator) for drive in drives] == [(1, "ann"), (2, "ann")]
    operator_lost = {rule.text for rule in RULES.values() if rule.event is Event.OPERATOR_LOST}
    assert {drive.end_cause.removeprefix("stands: ") for drive in drives} <= operator_lost
    assert all(drive.failsafes for drive in drives)
    starts = [entry for entry in entries if entry.kind is AuditKind.START]
    assert len({entry.boot_id for entry in starts}) == 2
    assert {entry.configuration_sha256 for entry in starts} == {sha256(site.config.read_bytes()).hexdigest()}


def test_stop_needs_no_lease_and_a_gateway_asked_to_end_ends_soon_and_well(around, site: Site):
    tower, ecu, start = around
    process = start()
    until(lambda: tower.mode() is Mode.STANDBY)
    until(lambda: ecu.commands)

    def pressed() -> bool:
        tower.link.publish("tower_stop", TowerStop(number=17, sent_ns=1, operator="nobody"))
        return tower.status.stop_number == 17

    until(pressed)
    until(lambda: tower.mode() is Mode.STOPPED)
    tower.ask_lease()
    tower.forge = True
    until(lambda: tower.status.dropped.get("command signature", 0) > 0)
    process.send_signal(signal.SIGTERM)
    assert process.wait(timeout=5.0) == 0
    last = len(ecu.commands)
    threading.Event().wait(0.05)
    assert len(ecu.commands) == last, "somebody went on commanding the car"
    told = site.told()
    assert [entry.kind for entry in told[-2:]] == [AuditKind.END, AuditKind.HEAD]
    assert any(entry.kind is AuditKind.STOP and entry.question == 17 for entry in told)
    assert any((entry.kind, entry.subject) == (AuditKind.DROPPED, "command signature") for entry in told)


@pytest.mark.long
def test_a_certificate_that_expires_while_driving_is_a_safe_stop_that_says_so_before_the_link_is_cut(tmp_path: Path):
    """The certificate lives 16 s; the car, set to take it all the same, stops ten seconds before its end."""
    site = Site(tmp_path)
    site.config.write_text(site.config.read_text() + "\n[vehicle_gateway.limits.hand_over]\ncertificate_left_s = 0.0\n")
    folder = Path(site.link.certificates)
    brief = issue(Role.TOWER_HUB, (), certificates.authority_of(folder), timedelta(seconds=16))
    certificates.write_pem(folder, Role.TOWER_HUB, brief.key_pem, brief.certificate_pem)
    ends = brief.certificate.not_valid_after_utc
    with surroundings(site) as (tower, ecu, start):
        start()
        until(lambda: ecu.commands)
        tower.ask_lease()
        until(lambda: tower.status.take_refused == "")
        assert tower.ask(Action.TAKE).outcome is Outcome.GRANTED
        until(lambda: tower.mode() is Mode.REMOTE)
        tower.throttle = 1.0
        until(lambda: tower.mode() is not Mode.REMOTE)
        assert timedelta(seconds=8) < ends - datetime.now(UTC) < timedelta(seconds=10.5)
        assert tower.status.cause == "the certificate of ann expires, or the car's"
        until(lambda: tower.mode() is Mode.STOPPED)
        assert tower.status.lease_holder == ""
        assert datetime.now(UTC) < ends, "the tower heard it all before the link was cut"
        heard = tower.status.stamp_ns
        until(lambda: datetime.now(UTC) > ends + timedelta(seconds=1.5), 20.0)
        last = tower.status.stamp_ns
        threading.Event().wait(0.3)
        assert tower.status.stamp_ns == last > heard, "the link of an expired certificate goes on"


def ended(site: Site) -> tuple[int, str]:
    done = subprocess.run(
        [*PROGRAM, str(site.config)], capture_output=True, text=True, timeout=20, check=False, env=dict(os.environ)
    )
    return done.returncode, done.stderr


def test_what_the_user_can_fix_is_one_line_that_says_how(site: Site):
    site.memory.write_bytes(b"{")
    code, text = ended(site)
    assert code == 2
    assert str(site.memory) in text and "damaged" in text and "Traceback" not in text
    site.memory.unlink()
    host, port = site.link.car_hub.split(":")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind((host, int(port)))
        code, text = ended(site)
    assert code == 2
    assert site.link.car_hub in text and "car_hub" in text and "Traceback" not in text
