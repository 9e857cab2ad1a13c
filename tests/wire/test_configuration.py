"""Configuration: what is wrong is named by file, key and what is allowed; what is absent has its default."""

from pathlib import Path

import pytest

from vehicle_gateway.settings import VehicleGatewaySettings
from wire.configuration import ROOMS, ConfigurationError, read_sections, read_toml, shipped
from wire.messages.automation import RoadMap
from wire.messages.vehicle import VehicleDescription
from wire.scenario import Scenario, find_scenario, read_map, read_scenario
from wire.settings import WireSettings

SECTIONS = {"wire": WireSettings, "vehicle_gateway": VehicleGatewaySettings}


def written(folder: Path, text: str) -> Path:
    file = folder / "car.toml"
    file.write_text(text, encoding="utf-8")
    return file


def told(file: Path, sections: dict[str, type] | None = None) -> str:
    with pytest.raises(ConfigurationError) as error:
        read_sections(file, sections or SECTIONS)
    assert str(file) in str(error.value)
    return str(error.value)


def test_an_empty_file_gives_every_default(tmp_path: Path):
    assert read_sections(written(tmp_path, ""), SECTIONS) == {"wire": WireSettings(), "vehicle_gateway": VehicleGatewaySettings()}


def test_an_unknown_key_is_named_with_the_keys_that_are_allowed(tmp_path: Path):
    text = told(written(tmp_path, '[wire.link]\nvehicle = "a"\n'))
    assert "wire.link" in text and "vehicle" in text
    assert "vehicle_id" in text and "car_hub" in text and "lease_ms" in text


def test_an_unknown_key_deep_in_a_room_is_named_with_its_place(tmp_path: Path):
    text = told(written(tmp_path, "[vehicle_gateway.limits.failsafe]\ncommand_gentle_s = 0.1\n"))
    assert "vehicle_gateway.limits.failsafe" in text and "command_gentle_s" in text and "command_gentle_ms" in text


def test_an_unknown_section_is_named_with_the_rooms(tmp_path: Path):
    text = told(written(tmp_path, "[towers]\n"))
    assert "towers" in text
    assert all(room in text for room in ROOMS)


@pytest.mark.parametrize(
    ("line", "allowed"),
    [
        ("command_gentle_ms = 5", "20"),
        ("command_gentle_ms = 5000", "1000"),
        ("command_gentle_ms = nan", "float"),
        ("command_gentle_ms = inf", "1000"),
        ("command_gentle_ms = true", "float"),
        ('command_gentle_ms = "120"', "float"),
    ],
)
def test_a_value_out_of_range_or_of_another_type_is_named_with_what_is_allowed(tmp_path: Path, line: str, allowed: str):
    text = told(written(tmp_path, f"[vehicle_gateway.limits.failsafe]\n{line}\n"))
    assert "vehicle_gateway.limits.failsafe.command_gentle_ms" in text
    assert allowed in text


def test_a_whole_number_is_as_good_as_one_with_a_point(tmp_path: Path):
    read = read_sections(written(tmp_path, "[vehicle_gateway.limits.failsafe]\ncommand_gentle_ms = 130\n"), SECTIONS)
    assert read["vehicle_gateway"].limits.failsafe.command_gentle_ms == 130.0


def test_a_wrong_key_in_a_list_of_tables_is_named(tmp_path: Path):
    broken = (shipped("simulated.toml").read_text(encoding="utf-8")).replace("focal_length_px", "focal_px")
    text = told(written(tmp_path, broken), {"vehicle": VehicleDescription})
    assert "vehicle.cameras" in text and "focal_px" in text and "focal_length_px" in text


def test_a_missing_required_key_is_named(tmp_path: Path):
    broken = shipped("simulated.toml").read_text(encoding="utf-8").replace("wheelbase_m = 2.7", "")
    text = told(written(tmp_path, broken), {"vehicle": VehicleDescription})
    assert "vehicle" in text and "wheelbase_m" in text


def test_rooms_a_program_may_not_import_are_left_alone(tmp_path: Path):
    read_sections(written(tmp_path, "[autonomy]\nanything = 1\n"), SECTIONS)


def test_no_file_no_toml_no_text_each_say_so(tmp_path: Path):
    assert "--config" in told(tmp_path / "absent.toml")
    assert "TOML" in told(written(tmp_path, "[wire\n"))
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    assert "read" in told(tmp_path / "binary.toml")
    assert "read" in told(tmp_path)


def test_what_we_ship_can_be_read():
    read = read_sections(shipped("simulated.toml"), {**SECTIONS, "vehicle": VehicleDescription})
    assert read["vehicle"].vehicle_id == read["wire"].link.vehicle_id
    for file in sorted(shipped("maps").glob("*.toml")):
        assert isinstance(read_map(file), RoadMap)
    scenarios = sorted(shipped("scenarios").glob("*.toml"))
    assert scenarios
    for file in scenarios:
        scenario, place = read_scenario(file)
        assert place.is_file()
        assert isinstance(scenario, Scenario)


def test_only_the_simulated_car_lets_a_scripted_operator_in():
    assert WireSettings().link.accepts_script is False
    for file in shipped().glob("*.toml"):
        accepts = read_sections(file, {"wire": WireSettings})["wire"].link.accepts_script
        assert accepts == (file.name == "simulated.toml"), file.name


def test_a_scenario_whose_map_is_nowhere_says_where_it_looked(tmp_path: Path):
    text = shipped("scenarios", "closed_road.toml").read_text(encoding="utf-8").replace("bend.toml", "nowhere.toml")
    file = written(tmp_path, text)
    with pytest.raises(ConfigurationError, match=r"nowhere\.toml") as error:
        read_scenario(file)
    assert str(tmp_path) in str(error.value)


def test_a_map_with_a_wrong_side_names_the_key(tmp_path: Path):
    text = shipped("maps", "bend.toml").read_text(encoding="utf-8").replace('"right"', '"middle"')
    with pytest.raises(ConfigurationError, match="drives_on"):
        read_toml(written(tmp_path, text), RoadMap)


def test_no_scenario_is_a_car_that_is_not_simulated_and_an_unknown_one_lists_what_there_is():
    with pytest.raises(ConfigurationError, match="of a car that is not simulated; shipped scenarios: closed_road"):
        find_scenario("")
    with pytest.raises(ConfigurationError, match="scenario 'nowhere': no such file; shipped scenarios: closed_road"):
        find_scenario("nowhere")
