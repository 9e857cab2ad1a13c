import tomllib
from pathlib import Path

import pytest

from autonomy.settings import AutonomySettings
from recordings.settings import RecordingsSettings
from tower.demo.session import HOUR_NS, choose, write_session
from tower.settings import TowerSettings
from vehicle_gateway.settings import VehicleGatewaySettings
from wire.bundle import export, install
from wire.certificates import check, make
from wire.configuration import ConfigurationError, read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.scenario import find_scenario
from wire.settings import WireSettings
from wire.topics import Role

BASE = shipped("simulated.toml")
ROOMS = {
    "wire": WireSettings,
    "vehicle": VehicleDescription,
    "vehicle_gateway": VehicleGatewaySettings,
    "tower": TowerSettings,
    "autonomy": AutonomySettings,
    "recordings": RecordingsSettings,
}


def session(folder, certificates):
    folder.mkdir()
    tables = choose(BASE, "mirrored", "")
    tables["wire"]["link"]["certificates"] = str(certificates)
    return read_sections(write_session(tables, folder), ROOMS)


def test_every_room_can_read_the_session_s_configuration(tmp_path):
    rooms = session(tmp_path / "one", tmp_path / "certificates")
    assert rooms["wire"].session.folder == str(tmp_path / "one")
    assert rooms["autonomy"].map.endswith("bend_mirrored.toml")
    assert rooms["vehicle_gateway"].simulation.scenario.endswith("mirrored.toml")
    assert HOUR_NS <= rooms["wire"].clock.tower_offset_ns < 2 * HOUR_NS


@pytest.mark.parametrize(
    ("named", "scenario", "kept"),
    [
        ("bend.toml", "closed_road", "bend.toml"),
        ("crossing.toml", "closed_road", "crossing.toml"),
        ("crossing.toml", "mirrored", "bend_mirrored.toml"),
    ],
)
def test_the_gateway_keeps_its_own_zones_on_the_street_that_is_driven_and_has_another_street_s_own(tmp_path, named, scenario, kept):
    base = tmp_path / "base.toml"
    base.write_text(BASE.read_text().replace('[vehicle_gateway]\nmap = "bend.toml"', f'[vehicle_gateway]\nmap = "{named}"'))
    tables = choose(base, scenario, "")
    assert Path(tables["vehicle_gateway"]["map"]).name == kept


def test_a_map_of_the_gateway_that_is_not_there_is_told_before_anything_starts(tmp_path):
    base = tmp_path / "base.toml"
    base.write_text(BASE.read_text().replace('[vehicle_gateway]\nmap = "bend.toml"', '[vehicle_gateway]\nmap = "bent.toml"'))
    with pytest.raises(ConfigurationError, match=r"vehicle_gateway.map = 'bent.toml': no such map; looked at"):
        choose(base, "", "")


def test_two_sessions_share_neither_port_nor_bus(tmp_path):
    one, two = (session(tmp_path / name, tmp_path / "certificates") for name in ("one", "two"))
    assert {one["wire"].link.car_hub, one["wire"].link.tower_hub}.isdisjoint({two["wire"].link.car_hub, two["wire"].link.tower_hub})
    assert (one["vehicle_gateway"].can.channel, one["vehicle_gateway"].can.port) != (
        two["vehicle_gateway"].can.channel,
        two["vehicle_gateway"].can.port,
    )


def test_a_machine_that_is_one_site_of_two_still_plays_the_demo_on_its_own(tmp_path):
    make(tmp_path / "office")
    install(export(tmp_path / "office", "", (), with_simulation=False), tmp_path / "certificates", replace=False)
    tables = choose(BASE, "", "")
    tables["wire"]["link"].update(certificates=str(tmp_path / "certificates"), listen=["0.0.0.0:7451"], connect=["10.0.0.1:7450"])
    tables["wire"]["link"]["fleet"] = [{"vehicle_id": "car-1"}]
    (tmp_path / "session").mkdir()
    link = read_sections(write_session(tables, tmp_path / "session"), ROOMS)["wire"].link
    assert (link.listen, link.connect, link.fleet) == ((), (), ())
    check(Path(link.certificates), Role.VEHICLE_HUB, link.vehicle_id)
    check(Path(link.certificates), Role.TOWER_SCRIPT, link.vehicle_id)


def test_what_the_user_got_wrong_is_told_before_anything_is_written(tmp_path):
    for scenario, clip, said in (("nowhere", "", "shipped scenarios: closed_road"), ("", "no.mp4", "--front-camera no.mp4")):
        with pytest.raises(ConfigurationError, match=said):
            choose(BASE, scenario, clip)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("scenario", ["", "short"])
def test_a_car_that_is_really_there_is_not_for_the_demo_whatever_scenario_is_named(scenario):
    with pytest.raises(ConfigurationError, match=r"the demo drives a simulated one; leave --config out, .* tower drive --config"):
        choose(shipped("example_car.toml"), scenario, "")


def test_every_shipped_scenario_is_found_by_its_name_and_by_its_path():
    for path in shipped("scenarios").glob("*.toml"):
        assert find_scenario(path.stem) == find_scenario(str(path)) == path.resolve()


def test_the_shipped_configuration_lets_a_script_in_and_only_because_it_is_simulated():
    assert tomllib.loads(BASE.read_text())["wire"]["link"]["accepts_script"] is True
    assert WireSettings().link.accepts_script is False
