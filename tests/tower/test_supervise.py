"""`tower supervise` beside a real gateway and a real link: what it shows, what the car does, and who else may not ask for it."""

import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest
from msgspec.structs import replace

from tests.messages import gateway_status
from tower.fleet import Seen
from tower.supervise import Order, cells, give, look, request_of
from wire import certificates
from wire.clock import Clock
from wire.configuration import ConfigurationError, shipped
from wire.identity import signer_of
from wire.latest import Received
from wire.link import Link, open_link
from wire.messages.session import LeaseReply, LeaseRequest, Supervision
from wire.messages.vehicle import GatewayStatus, Mode, Succession
from wire.ports import free_addresses, free_udp_ports
from wire.settings import LinkSettings
from wire.topics import Role

GATEWAY = [sys.executable, "-c", "from vehicle_gateway.program import main; main()", "run", "--config"]
CAR = "car-1"


def until(done: Callable[[], Any], seconds: float = 10.0) -> Any:
    """What `done` says as soon as it is true."""
    for _ in range(round(seconds / 0.01)):
        found = done()
        if found:
            return found
        threading.Event().wait(0.01)
    raise AssertionError("it did not come in time")


class Site:
    """A gateway that runs, and a tower that holds its lease."""

    def __init__(self, stack: ExitStack, folder: Path) -> None:
        self.folder = folder / "certificates"
        certificates.make(self.folder)
        car, tower = free_addresses(2)
        self.settings = LinkSettings(vehicle_id=CAR, certificates=str(self.folder), car_hub=car, tower_hub=tower)
        vehicle = shipped("simulated.toml").read_text(encoding="utf-8").split("[vehicle]")[1].split("[vehicle_gateway")[0]
        self.config = folder / "car.toml"
        self.config.write_text(
            f'[wire.pace]\nfifo_priority = 0\n[wire.link]\nvehicle_id = "{CAR}"\ncertificates = "{self.folder}"\n'
            f'car_hub = "{car}"\ntower_hub = "{tower}"\n[vehicle]{vehicle}\n[vehicle_gateway]\nmemory = "{folder}/memory.json"\n'
            f"[vehicle_gateway.can]\nport = {free_udp_ports(1)[0]}\n",
            encoding="utf-8",
        )
        process = subprocess.Popen([*GATEWAY, str(self.config)], stderr=subprocess.DEVNULL)
        stack.callback(process.wait)
        stack.callback(process.kill)
        self._stack = stack
        self.tower = self.open(Role.TOWER_HUB, hub=True)
        self._status = self.tower.level("gateway_status")

    def open(self, role: Role, hub: bool = False) -> Link:
        return self._stack.enter_context(open_link(self.settings, role, Clock(), threading.Event(), hub=hub))

    @property
    def status(self) -> GatewayStatus:
        return until(self._status.get).message

    def ask_lease(self, operator: str) -> LeaseReply:
        def answered() -> LeaseReply | None:
            told = {"echoed_vehicle_ns": self.status.stamp_ns, "echoed_boot_id": self.status.boot_id}
            question = LeaseRequest(operator=operator, session=f"of {operator}", sent_ns=1, **told)
            return self.tower.ask("lease", signer_of(self.folder, Role.TOWER_HUB).sign(question), 0.5)

        return until(answered)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Site]:
    with ExitStack() as stack:
        yield Site(stack, tmp_path_factory.mktemp("supervised"))


def order(site: Site, capsys: pytest.CaptureFixture[str], **wanted: Any) -> tuple[int, str]:
    code = give(site.config, threading.Event(), Order(vehicle_id=CAR, **wanted))
    return code, capsys.readouterr().out


def test_a_lease_is_seen_revoked_and_given_to_the_named_one_and_the_car_says_why(site: Site, capsys):
    held = site.ask_lease("ann")
    assert held.granted
    until(lambda: site.status.lease_holder == "ann")
    assert look(site.config, threading.Event()) == 0
    shown = capsys.readouterr().out
    assert site.status.lease_fingerprint[:16] in shown and "ann" in shown and "standby" in shown

    code, said = order(site, capsys, action=Supervision.REVOKE, operator="bob", reason="the shift is over")
    assert (code, said) == (0, f"{CAR}: done\n")
    until(lambda: site.status.lease_holder == "")
    assert site.status.lease_note == "a supervisor took the lease from ann: the shift is over"
    assert "a supervisor took the lease away" in site.ask_lease("ann").rule
    assert "gives the lease to bob" in site.ask_lease("eve").rule
    taken = site.ask_lease("bob")
    assert taken.granted and taken.epoch > held.epoch and taken.key_hex != held.key_hex
    until(lambda: site.status.lease_holder == "bob" and site.status.lease_note == "")

    code, said = order(site, capsys, action=Supervision.ADMIT, operator="eve")
    assert (code, said) == (1, f"{CAR}: refused: eve is not kept out\n")
    assert order(site, capsys, action=Supervision.ADMIT, operator="ann")[0] == 0
    assert "held by bob" in site.ask_lease("ann").rule
    code, said = order(site, capsys, action=Supervision.RELEASE, reason="looked at it")
    assert code == 0
    until(lambda: site.status.lease_note == "released by a supervisor: looked at it")


@pytest.mark.parametrize("role", [Role.WINDOW, Role.TOWER_OBSERVER])
def test_nobody_else_of_the_tower_can_even_ask(site: Site, role: Role):
    """The same question, signed by the supervisor himself, gets no further than the tower's hub."""
    question = order_of(site, Role.TOWER_SUPERVISOR)
    assert site.open(role).ask("supervision", question, 0.5) is None
    supervisor = site.open(Role.TOWER_SUPERVISOR)
    until(lambda: supervisor.ask("supervision", order_of(site, Role.TOWER_SUPERVISOR), 0.5))  # the same way, his own certificate


def order_of(site: Site, signer: Role) -> Any:
    bare = request_of(Order(action=Supervision.RELEASE, vehicle_id=CAR, reason="no"), site.status, 1)
    return signer_of(site.folder, signer).sign(bare)


def test_a_tower_s_hub_that_orders_in_its_own_name_is_refused_by_the_car(site: Site):
    reply = until(lambda: site.tower.ask("supervision", order_of(site, Role.TOWER_HUB), 0.5))
    assert (reply.done, reply.rule) == (False, "the certificate of tower-hub may not ask this")
    unsigned = replace(order_of(site, Role.TOWER_SUPERVISOR), certificate="", signature="")
    assert "not signed" in until(lambda: site.tower.ask("supervision", unsigned, 0.5)).rule


def test_a_supervisor_holds_no_lease_and_sends_no_command(site: Site):
    supervisor = site.open(Role.TOWER_SUPERVISOR)
    told = {"echoed_vehicle_ns": site.status.stamp_ns, "echoed_boot_id": site.status.boot_id}
    question = LeaseRequest(operator="carla", session="s", sent_ns=1, **told)
    assert supervisor.ask("lease", signer_of(site.folder, Role.TOWER_SUPERVISOR).sign(question), 0.5) is None


def test_a_car_that_is_not_configured_is_named_with_those_that_are(site: Site):
    with pytest.raises(ConfigurationError, match=f"no car car-9 .* there are: {CAR}"):
        give(site.config, threading.Event(), Order(action=Supervision.RELEASE, vehicle_id="car-9", reason="r"))


def test_a_car_that_was_not_heard_is_a_line_that_says_so():
    assert cells(Seen(CAR, None, None), 0)[:2] == (CAR, "not there")


def test_who_holds_a_car_and_who_is_next_for_it_stand_side_by_side():
    driven = gateway_status(mode=Mode.REMOTE, lease_holder="ann", succession=Succession(operator="ben"))
    assert cells(Seen(CAR, Received(driven, 5), None), 6)[1:3] == ("remote", "ann, ben is next")


def test_a_certificate_that_is_revoked_while_the_gateway_runs_loses_its_lease_within_two_looks(site: Site):
    """Last: from here on the tower's old certificate is worth nothing."""
    old = signer_of(site.folder, Role.TOWER_HUB)
    until(lambda: site.ask_lease("bob").granted)
    certificates.revoke(site.folder, "tower-hub")
    until(lambda: site.status.lease_note == "the certificate of bob was revoked")
    assert site.status.lease_holder == ""
    told = {"echoed_vehicle_ns": site.status.stamp_ns, "echoed_boot_id": site.status.boot_id}
    question = old.sign(LeaseRequest(operator="bob", session="of bob", sent_ns=1, **told))
    assert "was revoked" in until(lambda: site.tower.ask("lease", question, 0.5)).rule
    assert until(lambda: site.ask_lease("bob")).granted, "with the new certificate he may"
    assert site.status.lease_certificate in ("", "tower-hub~1")
