"""A change of operators with the real gateway, ECU and plant, two towers with hubs and keys of their own, and `tower supervise`.

The towers are this test's: their commands tell of pictures that nobody filmed, which is all that is made up. With real cockpits,
windows and cameras: tests/drives/test_two_operators.py, which wants two quiet cores.
"""

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from tests.messages import drive_command
from tower.demo.session import choose, write_session
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.identity import signer_of
from wire.link import Link, open_link
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.messages.vehicle import GatewayStatus, Mode, VehicleState
from wire.ports import free_addresses
from wire.settings import LinkSettings, WireSettings
from wire.signature import sign
from wire.topics import Role

BIN = Path(sys.executable).parent
PROGRAMS = (("vehicle-gateway", "run"), ("vehicle-gateway", "simulate"), ("vehicle-gateway", "ecu"))
PATIENCE_S = 20.0
COMMAND_S = 0.01


def until(what: str, done: Callable[[], Any], patience_s: float = PATIENCE_S) -> Any:
    pause = threading.Event()
    for _ in range(round(patience_s / 0.02)):
        found = done()
        if found:
            return found
        pause.wait(0.02)
    raise AssertionError(f"not in {patience_s:g} s: {what}")


class Tower:
    """A hub with a cockpit's certificate: asks, and sends a hundred commands a second with whatever lease it was given."""

    def __init__(self, link: Link, settings: LinkSettings, operator: str) -> None:
        self.operator, self._link = operator, link
        self._signer = signer_of(Path(settings.certificates), Role.TOWER_HUB)
        self._status, self._state = link.level("gateway_status"), link.level("vehicle_state")
        self._key, self._epoch, self._sequence, self._number = b"", 0, 0, 0
        self.acceleration_m_s2 = 0.0
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._send, name=operator)

    @property
    def status(self) -> GatewayStatus:
        received = self._status.get()
        assert received is not None
        return received.message

    @property
    def state(self) -> VehicleState:
        received = self._state.get()
        assert received is not None
        return received.message

    def hears(self) -> bool:
        return self._status.get() is not None and self._state.get() is not None

    def ask_lease(self) -> str:
        """The rule that refused it; "" when it was granted."""
        told = {"echoed_vehicle_ns": self.status.stamp_ns, "echoed_boot_id": self.status.boot_id}
        asked = self._signer.sign(LeaseRequest(operator=self.operator, session=f"{self.operator} 1", sent_ns=1, **told))
        reply = self._link.ask("lease", asked, 1.0)
        if not isinstance(reply, LeaseReply) or not reply.granted:
            return reply.rule if isinstance(reply, LeaseReply) else "no answer"
        self._key, self._epoch = bytes.fromhex(reply.key_hex), reply.epoch
        return ""

    def ask(self, action: Action) -> str:
        self._number += 1
        told = {"echoed_vehicle_ns": self.status.stamp_ns, "echoed_boot_id": self.status.boot_id}
        asked = HandOverRequest(lease_epoch=self._epoch, number=self._number, action=action, sent_ns=1, **told)
        reply = self._link.ask("hand_over", sign(asked, self._key), 1.0)
        if not isinstance(reply, HandOverReply) or reply.outcome is not Outcome.GRANTED:
            return reply.rule if isinstance(reply, HandOverReply) else "no answer"
        self._epoch = max(self._epoch, reply.lease_epoch)
        return ""

    def _send(self) -> None:
        while not self._end.wait(COMMAND_S):
            if not self._key:
                continue
            car, self._sequence = self.state, self._sequence + 1
            command = drive_command(
                lease_epoch=self._epoch,
                sequence=self._sequence,
                echoed_vehicle_ns=car.stamp_ns,
                echoed_boot_id=car.boot_id,
                displayed_capture_ns={"front": car.stamp_ns},
                road_wheel_angle_rad=car.road_wheel_angle_rad,
                acceleration_m_s2=self.acceleration_m_s2,
                dead_man=True,
            )
            self._link.publish("drive_command", sign(command, self._key))

    def __enter__(self) -> "Tower":
        until(f"{self.operator} hears the car", self.hears)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()


@contextmanager
def filming(link: Link, status: Callable[[], GatewayStatus]) -> Iterator[None]:
    """Says ten times a second that the front camera lives."""
    end = threading.Event()

    def say() -> None:
        while not end.wait(0.1):
            now_ns = status().stamp_ns
            said = {"stamp_ns": now_ns, "newest_capture_ns": now_ns, "camera": "front", "source": "simulated", "live": True}
            link.publish("camera_status", CameraStatus(frames=1, repeated=0, bitrate_kbps=1.0, encode_ms=1.0, watching=2, **said))

    thread = threading.Thread(target=say, name="camera")
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()


class Site:
    def __init__(self, stack: ExitStack, folder: Path) -> None:
        tables = choose(shipped("simulated.toml"), "short", "")
        tables["wire"]["link"]["certificates"] = str(folder / "certificates")
        tables["wire"]["pace"] = {"fifo_priority": 0}
        self._stack, self.config = stack, write_session(tables, folder)
        self.settings: LinkSettings = read_sections(self.config, {"wire": WireSettings})["wire"].link
        for program in PROGRAMS:
            process = subprocess.Popen([BIN / program[0], program[1], "--config", str(self.config)], stderr=subprocess.DEVNULL)
            stack.callback(process.wait)
            stack.callback(process.kill)

    def tower(self, operator: str) -> Tower:
        own = replace(self.settings, tower_hub=free_addresses(1)[0])
        link = self._stack.enter_context(open_link(own, Role.TOWER_HUB, Clock(), threading.Event(), hub=True))
        return self._stack.enter_context(Tower(link, own, operator))

    def supervise(self, *arguments: str) -> str:
        command = [BIN / "tower", "supervise", *arguments, "--reason", "end of her shift", "--config", str(self.config)]
        return subprocess.run(command, capture_output=True, text=True, timeout=30.0, check=False).stdout


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with ExitStack() as stack:
        yield Site(stack, tmp_path)


def test_the_next_operator_takes_over_from_the_one_who_drives_and_the_car_rolls_on(site: Site) -> None:
    ann, ben = site.tower("ann"), site.tower("ben")
    car = site.settings.vehicle_id
    with open_link(site.settings, Role.VIDEO, Clock(), threading.Event()) as cameras, filming(cameras, lambda: ann.status):
        until("ann holds the lease", lambda: ann.ask_lease() == "")
        until("ann drives", lambda: ann.status.mode is Mode.REMOTE or ann.ask(Action.TAKE) == "never")
        ann.acceleration_m_s2 = 1.0
        until("it rolls", lambda: ann.state.speed_m_s > 0.5)
        ann.acceleration_m_s2 = 0.0
        assert "held by ann" in ben.ask_lease()
        assert f"{car}: done" in site.supervise("revoke", car, "--to", "ben")
        until("ben's own lease", lambda: ben.ask_lease() == "")
        assert ben.ask(Action.TAKE) == "ann has not passed the car on"
        assert ann.ask(Action.PASS_ON) == ""
        until("ben drives", lambda: ben.status.lease_holder == "ben" or ben.ask(Action.TAKE) == "never")
        assert (ben.status.mode, ben.status.cause) == (Mode.REMOTE, "ben took over from ann")
        assert ben.state.speed_m_s > 0.2 and ben.state.command_age_ms < 500.0
        before = ben.status.dropped.get("command epoch", 0)
        until("ann's commands are dropped", lambda: ben.status.dropped.get("command epoch", 0) > before)
        assert "a supervisor took the lease away" in ann.ask_lease()
        assert f"{car}: refused" in site.supervise("revoke", car)
        assert f"{car}: done" in site.supervise("revoke", car, "--stop")
        until("it stands", lambda: ben.status.mode is Mode.STOPPED)
        assert "took the lease from ben: end of her shift" in ben.status.cause
