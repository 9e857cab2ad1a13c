"""`tower drive`: which car, where it is, and what its programs are told."""

import threading
import tomllib
from pathlib import Path

import pytest
from rich.console import Console

from tests.messages import gateway_status
from tower.demo.drive import _take_one, may_be_left, write_drive
from tower.fleet import FRESH_NS
from wire import certificates
from wire.clock import Clock
from wire.configuration import ConfigurationError, read_sections, read_tables, shipped
from wire.latest import Received
from wire.messages.vehicle import GatewayStatus, Mode
from wire.settings import FleetVehicle, LinkSettings, WireSettings
from wire.site import override

FLEET = (FleetVehicle(vehicle_id="car-1"), FleetVehicle(vehicle_id="car-2"))


def taken(link: LinkSettings, named: bool) -> str:
    stop = threading.Event()
    stop.set()  # one look is enough: nobody is there
    return _take_one(link, Clock(), stop, Console(quiet=True), named).vehicle_id


def test_the_programs_get_the_chosen_car_and_everything_else_as_it_was_configured(tmp_path: Path):
    base = shipped("simulated.toml")
    configured: WireSettings = read_sections(base, {"wire": WireSettings})["wire"]
    link = override(configured.link, "car-7", ("10.0.0.7:7450",), ())
    written = write_drive(read_tables(base), link, tmp_path)
    wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
    assert wire.link == link
    assert wire.session.folder == str(tmp_path)
    before, after = tomllib.loads(base.read_text()), tomllib.loads(written.read_text())
    assert {name: table for name, table in before.items() if name != "wire"} == {
        name: table for name, table in after.items() if name != "wire"
    }


@pytest.mark.parametrize(
    ("link", "named", "car"),
    [
        (LinkSettings(vehicle_id="car-9"), False, "car-9"),
        (LinkSettings(vehicle_id="car-9", fleet=FLEET), True, "car-9"),
        (LinkSettings(vehicle_id="car-2", fleet=FLEET), False, "car-2"),
        (LinkSettings(vehicle_id="car-9", fleet=FLEET[:1]), False, "car-1"),
    ],
)
def test_the_named_car_is_taken_or_the_configured_or_the_only_one(link: LinkSettings, named: bool, car: str):
    assert taken(link, named) == car


def test_of_several_cars_one_has_to_be_named_where_nobody_can_be_asked(tmp_path: Path):
    certificates.make(tmp_path / "certificates")
    link = LinkSettings(vehicle_id="car-9", fleet=FLEET, certificates=str(tmp_path / "certificates"))
    with pytest.raises(ConfigurationError, match="--vehicle: car-1, car-2"):
        taken(link, False)


def status(mode: Mode, holder: str) -> GatewayStatus:
    return gateway_status(stamp_ns=1, mode=mode, mode_since_ns=1, lease_holder=holder)


@pytest.mark.parametrize("mode", list(Mode))
def test_a_car_is_left_when_it_stands_or_somebody_else_drives_it(mode: Mode):
    """Written down once more, in words: standing, or with a driver that is not us."""
    stands = mode in (Mode.STANDBY, Mode.STOPPED, Mode.EMERGENCY_STOP)
    drives_itself = mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.LOCAL_DRIVER)
    for holder, is_ours in (("ann", True), ("", True), ("bob", False)):
        heard = Received(status(mode, holder), 5 * FRESH_NS)
        assert may_be_left(heard, "ann", 6 * FRESH_NS) is (stands or drives_itself or not is_ours)
        assert may_be_left(heard, "ann", 6 * FRESH_NS + 1), "it cannot be heard any more"
    assert may_be_left(None, "ann", 0)
