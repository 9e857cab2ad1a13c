"""The real programs of a car and a cockpit, told everything that is wrong: counted where the driver can see it, and all live on.

Two sessions run beside each other on this machine; the second is what every figure of the first is compared with.
"""

import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from threading import Event
from typing import Any

import msgspec
import pytest

from benchmarks.examples import wrong
from tests.messages import drive_command
from tower.demo.session import choose, write_session
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.ecu_codec import Controls, Motion, encode_controls, encode_motion
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.settings import VehicleGatewaySettings
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.identity import signer_of
from wire.link import Link, open_link
from wire.messages.base import Gear
from wire.messages.operating import ClockPing, DriveCommand
from wire.messages.session import LeaseReply, LeaseRequest
from wire.messages.vehicle import Mode
from wire.ports import free_addresses
from wire.settings import WireSettings
from wire.signature import sign
from wire.topics import COCKPITS, TOPICS, Role
from wire.topics import PROGRAMS as PROGRAMS_OF

PROGRAMS = {
    "gateway": ("vehicle-gateway", "run"),
    "simulate": ("vehicle-gateway", "simulate"),
    "ecu": ("vehicle-gateway", "ecu"),
    "recorder": ("recordings", "record"),
    "autonomy": ("autonomy", "run"),
    "cockpit": ("tower", "cockpit"),
}
TIMES = 3  # each wrong message: a best-effort one may be lost on its way
SPOKEN = [name for name, topic in TOPICS.items() if topic.type and topic.publishers != {Role.VEHICLE_HUB}]  # the hub is the gateway


class Session:
    """One session's configuration, its processes, and links of this test's own: a tower and whoever else speaks in the car."""

    def __init__(self, stack: ExitStack, folder: Path, programs: tuple[str, ...]) -> None:
        folder.mkdir()
        tables = choose(shipped("simulated.toml"), "short", "")
        tables["wire"]["link"]["certificates"] = str(folder.parent / "certificates")
        tables["wire"]["pace"] = {"fifo_priority": 0}
        self.folder, self.config = folder, write_session(tables, folder)
        sections = read_sections(self.config, {"wire": WireSettings, "vehicle_gateway": VehicleGatewaySettings})
        self.settings, self.can = sections["wire"].link, sections["vehicle_gateway"].can
        self.processes = {name: self.start(name) for name in programs}
        stack.callback(self.kill)
        self.links = stack.enter_context(ExitStack())
        self._links: dict[Role, Link] = {}
        own_hub = msgspec.structs.replace(self.settings, tower_hub=free_addresses(1)[0])
        self.tower = self.links.enter_context(open_link(own_hub, Role.TOWER_HUB, Clock(), Event(), hub=True))
        self.signer = signer_of(Path(self.settings.certificates), Role.TOWER_HUB)
        self.status, self.state = self.tower.level("gateway_status"), self.tower.level("vehicle_state")
        self.dropped: dict[str, dict[str, int]] = {}  # by process, as each tells it
        for health in ("car_health", "tower_health"):
            self.link(Role.RECORDER).on(health, self._healthy)

    def _healthy(self, message: Any, _: int) -> None:
        self.dropped[message.process] = message.dropped

    def start(self, name: str) -> subprocess.Popen[bytes]:
        program, command = PROGRAMS[name]
        with (self.folder / f"{name}.log").open("wb") as log:
            return subprocess.Popen(
                [str(Path(sys.executable).parent / program), command, "--config", str(self.config)], stdout=log, stderr=log
            )

    def kill(self) -> None:
        for process in self.processes.values():
            with suppress(ProcessLookupError):
                process.kill()
            process.wait()

    def link(self, role: Role) -> Link:
        if role in COCKPITS:
            return self.tower
        if role not in self._links:
            self._links[role] = self.links.enter_context(open_link(self.settings, role, Clock(), Event()))
        return self._links[role]

    def told(self) -> dict[str, int]:
        """What the gateway has dropped, as it tells."""
        received = self.status.get()
        return received.message.dropped if received else {}

    def logs(self) -> str:
        return "\n".join(path.read_text(errors="replace") for path in sorted(self.folder.glob("*.log")))


@pytest.fixture(scope="module")
def sessions(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Session, Session]]:
    folder = tmp_path_factory.mktemp("sessions")
    with ExitStack() as stack:
        first = Session(stack, folder / "first", ("gateway", "simulate", "ecu", "recorder", "autonomy"))
        yield first, Session(stack, folder / "second", ("gateway", "simulate", "ecu"))


@pytest.fixture(scope="module")
def drive(sessions, until) -> Session:
    return sessions[0]


def ask_lease(drive: Session, operator: str, session: str, timeout_s: float) -> LeaseReply | None:
    """Signed, as a cockpit asks."""
    heard = drive.status.get()
    if heard is None:
        return None
    told = {"echoed_vehicle_ns": heard.message.stamp_ns, "echoed_boot_id": heard.message.boot_id}
    return drive.tower.ask(
        "lease", drive.signer.sign(LeaseRequest(operator=operator, session=session, sent_ns=1, **told)), timeout_s
    )


@pytest.fixture(scope="module")
def lease(drive: Session, until) -> LeaseReply:
    """Held by this test's tower before the cockpit comes: the cockpit is the second operator."""

    def answered() -> LeaseReply | None:
        reply = ask_lease(drive, "ann", "s1", 0.5)
        return reply if reply is not None and reply.granted else None

    held: LeaseReply = until(answered)
    drive.processes["cockpit"] = drive.start("cockpit")
    return held


def test_two_sessions_on_one_machine_both_run_and_neither_hears_the_other(sessions, until):
    for session in sessions:
        until(lambda session=session: session.state.get() and session.state.get().message.gear is Gear.DRIVE)  # its ECU speaks
    boots = {session.state.get().message.boot_id for session in sessions}
    assert len(boots) == 2
    for session in sessions:
        assert until(session.status.get).message.mode is Mode.STANDBY
        on_the_bus = sum(count for reason, count in session.told().items() if reason.startswith("can"))
        assert on_the_bus < 20, "somebody else speaks there: two ECUs would disturb each other 200 times a second"


def test_a_second_operator_is_told_who_holds_the_lease(drive: Session, lease: LeaseReply, until):
    refused = ask_lease(drive, "eve", "s2", 1.0)
    assert not refused.granted and "ann" in refused.rule and refused.key_hex == ""
    told = drive.link(Role.RECORDER).level("operator_status")  # of the cockpit, a real one
    until(lambda: told.get() and "ann" in told.get().message.lease_note, lambda: renew(drive))
    assert told.get().message.lease_epoch == 0


def renew(drive: Session) -> None:
    """As often as a cockpit does: who asks more is refused, and with it whoever asks beside it."""
    if drive.status.get().message.lease_silent_s > 1.0:
        ask_lease(drive, "ann", "s1", 0.2)


def command_of(drive: Session, lease: LeaseReply, sequence: int) -> DriveCommand:
    newest = drive.state.get().message
    return drive_command(
        lease_epoch=lease.epoch,
        sequence=sequence,
        sent_ns=1,
        event_ns=1,
        echoed_vehicle_ns=newest.stamp_ns,
        echoed_boot_id=newest.boot_id,
        indicators="off",
    )


WRONG_COMMANDS = {  # what is wrong -> how the command differs from the good one
    "command epoch": {"lease_epoch": 0},
    "command boot id": {"echoed_boot_id": "another"},
    "command echo age": {"echoed_vehicle_ns": 0},
    "command from the future": {"echoed_vehicle_ns": 2**62},
}


def test_commands_repeated_overtaken_forged_or_of_an_old_epoch_are_counted_by_what_is_wrong(
    drive: Session, lease: LeaseReply, until
):
    key, numbers = bytes.fromhex(lease.key_hex), iter(range(1, 10_000))

    def say(sequence: int, key: bytes = key, **changes: Any) -> None:
        drive.tower.publish("drive_command", sign(msgspec.structs.replace(command_of(drive, lease, sequence), **changes), key))

    def taken() -> bool:
        return drive.state.get().message.command_age_ms < 50.0

    until(taken, lambda: say(next(numbers)))
    for reason, changes in WRONG_COMMANDS.items():
        until(lambda reason=reason: drive.told().get(reason), lambda changes=changes: say(next(numbers), **changes))
    until(lambda: drive.told().get("command signature"), lambda: say(next(numbers), key=bytes(32)))
    until(lambda: drive.told().get("command sequence"), lambda: say(1))
    until(taken, lambda: say(next(numbers)))


def test_frames_with_a_wrong_checksum_counter_or_name_are_counted_and_the_car_is_heard_on(drive: Session, until):
    good = encode_motion(Motion(0.0, 0.0, 0.0, 0.0), 3)
    frames = (
        Frame(good.arbitration_id, bytes((good.data[0] ^ 0xFF,)) + good.data[1:]),  # checksum
        good,
        good,  # the same counter again
        Frame(good.arbitration_id, good.data[:5]),  # cut off
        Frame(0x7AB, good.data),  # nobody's
        encode_controls(Controls(), 15),  # a counter that is never sent
    )
    with (
        open_bus(drive.can, "vehicle", lambda *_: None, Clock()) as bus,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as raw,
    ):
        raw.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))

        def speak() -> None:
            for frame in frames:
                bus.send(frame)
            raw.sendto(b"\xc1 no frame at all", (drive.can.channel, drive.can.port))

        wanted = {"can crc", "can counter", "can id", "can unreadable"}
        until(lambda: wanted <= drive.told().keys(), speak)
    before = drive.state.get().message.stamp_ns
    until(lambda: drive.state.get().message.stamp_ns > before and drive.state.get().message.gear is Gear.DRIVE)


READERS = {PROGRAMS_OF[role]: role for role in (Role.VEHICLE_HUB, Role.RECORDER, Role.AUTONOMY, Role.TOWER_HUB)}


def read_by(role: Role) -> set[str]:
    """The topics this process has to have heard something wrong on."""
    return {f"{name} undecodable" for name in SPOKEN if role in TOPICS[name].readers and role not in TOPICS[name].publishers}


def test_garbage_on_every_key_is_counted_by_every_process_that_reads_it_and_all_live_on(drive: Session, lease: LeaseReply, until):
    until(lambda: READERS.keys() <= drive.dropped.keys())

    def speak() -> None:
        for name in SPOKEN:
            for payload in wrong(name).values():
                drive.link(min(TOPICS[name].publishers)).publish(name, payload)

    for _ in range(TIMES):
        speak()
    for process, role in READERS.items():
        until(lambda process=process, role=role: read_by(role) <= drive.dropped[process].keys(), patience_s=4.0)
    assert drive.tower.ask("lease", ClockPing(number=1, sent_ns=1), 0.5) is None
    until(lambda: drive.told().get("lease undecodable"))
    assert {name: process.poll() for name, process in drive.processes.items()} == dict.fromkeys(drive.processes)


def test_asked_to_end_by_either_signal_all_end_well_and_none_left_a_traceback(sessions, lease):
    """Last: after everything above."""
    for session in sessions:
        session.links.close()  # first: a farewell to a hub that is gone takes its time
        hubs = [name for name in ("gateway", "cockpit") if name in session.processes]
        for names in ([name for name in session.processes if name not in hubs], hubs):
            for number, name in enumerate(names):
                session.processes[name].send_signal(signal.SIGINT if number % 2 else signal.SIGTERM)
            assert {name: session.processes[name].wait(10.0) for name in names} == dict.fromkeys(names, 0)
        assert "Traceback" not in session.logs(), session.logs()
