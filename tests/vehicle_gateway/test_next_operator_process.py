"""A change of operators with the real gateway, ECU and plant, two towers with hubs and keys of their own, and `tower supervise`.

The towers are this test's: their commands tell of pictures that nobody filmed, which is all that is made up. With real cockpits,
windows and cameras: tests/long_drives/test_two_operators.py, which wants two quiet cores.
"""

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest
from msgspec.structs import replace

from tests.vehicle_gateway.test_gateway_process import Tower, until
from tower.demo.session import choose, write_session
from wire.clock import Clock
from wire.configuration import read_sections, shipped
from wire.identity import signer_of
from wire.link import Link, open_link
from wire.messages.session import Action, HandOverReply, LeaseReply
from wire.messages.vehicle import Mode
from wire.ports import free_addresses
from wire.settings import LinkSettings, WireSettings
from wire.topics import Role

BIN = Path(sys.executable).parent
PROGRAMS = (("vehicle-gateway", "run"), ("vehicle-gateway", "simulate"), ("vehicle-gateway", "ecu"))


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

    def tower(self, operator: str, video: Link | None = None) -> Tower:
        """A hub of its own with a cockpit's certificate, sending."""
        own, stop = replace(self.settings, tower_hub=free_addresses(1)[0]), threading.Event()
        link = self._stack.enter_context(open_link(own, Role.TOWER_HUB, Clock(), stop, hub=True))
        tower = Tower(link, video, signer_of(Path(own.certificates), Role.TOWER_HUB), operator)
        sending = threading.Thread(target=tower.send, args=(stop,))
        sending.start()
        self._stack.callback(sending.join)
        self._stack.callback(stop.set)
        until(lambda: tower.status is not None)
        return tower

    def cameras(self) -> Link:
        return self._stack.enter_context(open_link(self.settings, Role.VIDEO, Clock(), threading.Event()))

    def supervise(self, *arguments: str) -> str:
        command = [BIN / "tower", "supervise", *arguments, "--reason", "end of her shift", "--config", str(self.config)]
        return subprocess.run(command, capture_output=True, text=True, timeout=30.0, check=False).stdout


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with ExitStack() as stack:
        yield Site(stack, tmp_path)


def rule(reply: LeaseReply | HandOverReply | None) -> str:
    return "no answer" if reply is None else reply.rule


def test_the_next_operator_takes_over_from_the_one_who_drives_and_the_car_rolls_on(site: Site) -> None:
    ann, ben, car = site.tower("ann", site.cameras()), site.tower("ben"), site.settings.vehicle_id
    ann.ask_lease()
    until(lambda: ann.mode() is Mode.REMOTE or ann.ask(Action.TAKE) is None)
    ann.throttle = 1.0
    until(lambda: ann.state.get().message.speed_m_s > 0.5)
    ann.throttle = 0.0
    assert "held by ann" in rule(ben.ask_lease_once())
    assert f"{car}: done" in site.supervise("revoke", car, "--to", "ben")
    ben.ask_lease()
    assert rule(ben.ask(Action.TAKE)) == "ann has not passed the car on"
    assert rule(ann.ask(Action.PASS_ON)) == ""
    until(lambda: ben.status.lease_holder == "ben" or ben.ask(Action.TAKE) is None)
    assert (ben.mode(), ben.status.cause) == (Mode.REMOTE, "ben took over from ann")
    driven = ben.state.get().message
    assert driven.speed_m_s > 0.2 and driven.command_age_ms < 500.0
    before = ben.status.dropped.get("command epoch", 0)
    until(lambda: ben.status.dropped.get("command epoch", 0) > before)  # ann's
    assert "a supervisor took the lease away" in rule(ann.ask_lease_once())
    assert f"{car}: refused" in site.supervise("revoke", car)
    assert f"{car}: done" in site.supervise("revoke", car, "--stop")
    until(lambda: ben.mode() is Mode.STOPPED)
    assert "took the lease from ben: end of her shift" in ben.status.cause
