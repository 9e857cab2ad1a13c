"""Every check holds on both shipped configurations, and each one fails when the one thing that it guards is broken."""

import threading
from dataclasses import is_dataclass, replace
from pathlib import Path

import msgspec
import pytest
from rich.console import Console

from vehicle_gateway import gateway
from vehicle_gateway.actuation import ActuationLimits
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.check.facts import Facts, Surroundings, Verdict
from vehicle_gateway.check.program import INCONSISTENT, facts_of, read_every_section, run, table_of
from vehicle_gateway.check.table import check, is_consistent
from vehicle_gateway.simulation import ecu, simulate
from wire.configuration import ConfigurationError, shipped
from wire.messages.automation import ZoneKind
from wire.scenario import read_map

AROUND = Surroundings(
    can_interfaces=frozenset({"can0"}),
    certificates_folder=True,
    certificates_problem="",
    certificates_days=90.0,
    map_problem="",
    gateway_map=read_map(shipped("maps", "bend.toml")),
    gateway_map_problem="",
    scenario_problem="",
    source_problem="",
    memory_problem="",
)


def facts(name: str) -> Facts:
    file = shipped(name)
    sections, findings = read_every_section(file)
    assert all(found.verdict is Verdict.OK for found in findings), findings
    return replace(facts_of(file, sections), around=AROUND)


@pytest.fixture(scope="module")
def car() -> Facts:
    return facts("example_car.toml")


@pytest.fixture(scope="module")
def toyota() -> Facts:
    return facts("example_toyota.toml")


def changed(thing, path: str, value):
    """The struct with the value at `a.b.c` changed; a number picks an element of a tuple."""
    name, _, rest = path.partition(".")
    if name.isdigit():
        elements = list(thing)
        elements[int(name)] = changed(elements[int(name)], rest, value)
        return tuple(elements)
    inner = changed(getattr(thing, name), rest, value) if rest else value
    change = replace if is_dataclass(thing) else msgspec.structs.replace
    return change(thing, **{name: inner})


def broken(findings) -> dict[str, Verdict]:
    return {found.name: found.verdict for found in findings if found.verdict is not Verdict.OK}


@pytest.mark.parametrize("name", ["simulated.toml", "example_car.toml"])
def test_the_shipped_configurations_are_consistent(name):
    findings = check(facts(name))
    assert broken(findings) == {}
    assert len({found.name for found in findings}) == len(findings), "every line of the table has a name of its own"


# check, what is broken, the wrong value, and whether it is an error or something to look at
LIMITS = "gateway.limits"
WRONG = [
    ("length and wheelbase", "vehicle.wheelbase_m", 3.8, Verdict.ERROR),
    ("length and wheelbase", "vehicle.rear_overhang_m", 2.9, Verdict.ERROR),
    ("width and height", "vehicle.width_m", 2.6, Verdict.ERROR),
    ("width and height", "vehicle.height_m", 4.2, Verdict.ERROR),
    ("turning radius", "vehicle.road_wheel_angle_max_rad", 0.1, Verdict.ERROR),
    ("steering range", "vehicle.steering_ratio", 30.0, Verdict.ERROR),
    ("steering range", "vehicle.steering_ratio", 3.0, Verdict.ERROR),
    ("steering within the wheel's reach", "device", "wheel", Verdict.WARNING),
    ("brakes and the road", "vehicle.braking_max_m_s2", 10.01, Verdict.ERROR),
    ("brakes in order", f"{LIMITS}.safe_stop.braking_m_s2", 1.2, Verdict.ERROR),
    ("brakes in order", "vehicle.braking_max_m_s2", 3.9, Verdict.ERROR),
    ("safe stop within the corridor", "vehicle.speed_max_remote_m_s", 14.0, Verdict.ERROR),
    ("speed at the start", f"{LIMITS}.cap.speed_first_m_s", 9.0, Verdict.WARNING),
    ("silence in order", f"{LIMITS}.failsafe.command_gentle_ms", 500.0, Verdict.ERROR),
    ("silence in order", f"{LIMITS}.failsafe.command_gentle_ms", 25.0, Verdict.ERROR),
    ("hand-over on a fresh command", f"{LIMITS}.hand_over.command_fresh_ms", 121.0, Verdict.ERROR),
    ("ECU before safe stop", "gateway.simulation.ecu.command_timeout_ms", 501.0, Verdict.ERROR),
    ("ECU before safe stop", "gateway.simulation.ecu.command_timeout_ms", 30.0, Verdict.ERROR),
    ("ECU before safe stop", "gateway.simulation.demand_timeout_ms", 101.0, Verdict.ERROR),
    ("ECU brakes", "gateway.simulation.ecu.emergency_m_s2", 8.0, Verdict.ERROR),
    ("loop age in order", f"{LIMITS}.cap.loop_age_slow_ms", 501.0, Verdict.ERROR),
    ("loop age in order", f"{LIMITS}.cap.loop_age_free_ms", 400.0, Verdict.ERROR),
    ("room for the car in the loop age", f"{LIMITS}.actuation.in_loop_age", True, Verdict.ERROR),
    ("cameras", "around.source_problem", "this car has no such camera", Verdict.ERROR),
    ("cameras", "vehicle.cameras.1.name", "front", Verdict.ERROR),
    ("required cameras", "vehicle.cameras.0.required", False, Verdict.ERROR),
    ("rear camera", "vehicle.cameras.3.name", "back", Verdict.WARNING),
    ("camera front: field of view", "vehicle.cameras.0.focal_length_px", 200.0, Verdict.ERROR),
    ("camera front: field of view", "vehicle.cameras.0.width_px", 320, Verdict.ERROR),
    ("camera front: horizon in the picture", "vehicle.cameras.0.pitch_rad", 0.5, Verdict.ERROR),
    ("camera front: horizon in the picture", "vehicle.cameras.0.pitch_rad", -0.5, Verdict.ERROR),
    ("camera front: place on the car", "vehicle.cameras.0.x_m", 4.1, Verdict.ERROR),
    ("camera left: place on the car", "vehicle.cameras.1.y_m", 1.4, Verdict.ERROR),
    ("camera rear: place on the car", "vehicle.cameras.3.z_m", 0.0, Verdict.ERROR),
    ("camera front: direction", "vehicle.cameras.0.yaw_rad", 0.9, Verdict.ERROR),
    ("camera rear: direction", "vehicle.cameras.3.yaw_rad", 0.0, Verdict.ERROR),
    ("camera left: picture size", "vehicle.cameras.1.width_px", 1279, Verdict.ERROR),
    ("camera front: frame rate", "vehicle.cameras.0.frame_rate_hz", 14.0, Verdict.ERROR),
    ("camera front: near road", "vehicle.cameras.0.pitch_rad", -0.4, Verdict.ERROR),
    ("camera front: far sight", "vehicle.cameras.0.focal_length_px", 210.0, Verdict.ERROR),
    ("camera front: source", "gateway.video.sources", {}, Verdict.ERROR),
    ("camera front: source", "gateway.video.sources", {"front": "file:clip.mp4"}, Verdict.ERROR),
    ("camera left: source", "gateway.video.sources", {"front": "v4l2:/dev/video0"}, Verdict.WARNING),
    ("camera front: delay before the stamp", "vehicle.cameras.0.exposure_delay_ms", 0.0, Verdict.WARNING),
    ("CAN interface", "gateway.can.channel", "can1", Verdict.WARNING),
    ("CAN of a real car", "gateway.can.interface", "virtual", Verdict.ERROR),
    ("CAN: acceleration that can be sent", "vehicle.acceleration_max_m_s2", 5.1, Verdict.ERROR),
    ("CAN: steering that can be sent", "vehicle.road_wheel_angle_max_rad", 0.81, Verdict.ERROR),
    ("CAN: steering that is measured", "vehicle.road_wheel_angle_max_rad", 0.81, Verdict.ERROR),
    ("CAN: speed that is measured", "vehicle.speed_max_remote_m_s", 70.0, Verdict.ERROR),
    ("CAN: motion in time", f"{LIMITS}.failsafe.feedback_lost_ms", 49.0, Verdict.ERROR),
    ("CAN: a person's override in time", f"{LIMITS}.authority.override_ms", 39.0, Verdict.ERROR),
    ("CAN: commands in time", "gateway.simulation.ecu.command_timeout_ms", 49.0, Verdict.ERROR),
    ("vehicle id", "vehicle.vehicle_id", "another-1", Verdict.ERROR),
    ("ports", "wire.link.tower_hub", "127.0.0.1:7450", Verdict.ERROR),
    ("certificates", "around.certificates_problem", "vehicle-hub.pem: no such certificate", Verdict.ERROR),
    ("certificates' life", "around.certificates_days", 6.9, Verdict.WARNING),
    ("address of the link", "wire.link.listen", (), Verdict.WARNING),
    ("scripted operator refused", "wire.link.accepts_script", True, Verdict.ERROR),
    ("device", "device", "scripted", Verdict.ERROR),
    ("sets off by itself", f"{LIMITS}.authority.engage_autonomously", True, Verdict.ERROR),
    ("real time", "wire.clock.real_time_factor", 0.5, Verdict.ERROR),
    ("map", "around.map_problem", "no such map", Verdict.ERROR),
    ("zones", "around.gateway_map", None, Verdict.WARNING),
    ("zones", "around.gateway_map.zones.0.left_m", -7.0, Verdict.ERROR),
    ("zones", "around.gateway_map.zones.0.from_station_m", 300.0, Verdict.ERROR),
    ("zones", "around.gateway_map.zones.0.kind", ZoneKind.SPEED, Verdict.ERROR),
    ("zones", "around.gateway_map.zones.0.speed_m_s", 3.0, Verdict.ERROR),
    ("scenario", "around.scenario_problem", "no such file", Verdict.ERROR),
    ("memory for epochs and latches", "around.memory_problem", "may not write there", Verdict.WARNING),
]


@pytest.mark.parametrize(("name", "path", "value", "verdict"), WRONG, ids=[f"{row[0]}: {row[1]}" for row in WRONG])
def test_a_check_fails_when_what_it_guards_is_broken_and_says_what_to_do(car, name, path, value, verdict):
    findings = check(changed(car, path, value))
    found = next(found for found in findings if found.name == name)
    assert (found.verdict, found.fix != "") == (verdict, True)
    assert is_consistent(findings) is (Verdict.ERROR not in broken(findings).values())


@pytest.mark.parametrize(
    ("steering_ms", "acceleration_ms", "verdict"),
    [
        (100.0, 9.0, Verdict.OK),
        (101.0, 9.0, Verdict.WARNING),
        (9.0, 101.0, Verdict.WARNING),
        (300.0, 9.0, Verdict.WARNING),
        (301.0, 9.0, Verdict.ERROR),
    ],
)
def test_a_car_that_is_judged_by_its_own_answer_needs_room_for_it_beside_camera_screen_and_link(
    car, steering_ms, acceleration_ms, verdict
):
    """Camera 53 and screen 58 ms, as the example has them, 100 for the link: full speed to 311, a safe stop above 511 ms."""
    judged = ActuationLimits(
        in_loop_age=True,
        steering_ms=steering_ms - 4.0,
        steering_bound_ms=4.0,
        acceleration_ms=acceleration_ms - 4.0,
        acceleration_bound_ms=4.0,
    )
    there = changed(changed(car, f"{LIMITS}.cap.loop_age_free_ms", 311.0), f"{LIMITS}.failsafe.loop_age_max_ms", 511.0)
    found = next(one for one in check(changed(there, f"{LIMITS}.actuation", judged)) if one.name.startswith("room"))
    assert (found.verdict, "nobody could drive it" in found.fix) == (verdict, verdict is Verdict.ERROR)


def test_every_check_is_broken_by_some_row_above(car):
    """A check that nothing breaks would be no check. The cameras' checks count once, whatever the camera."""
    rule = {name.partition(": ")[2] if name.startswith("camera ") else name for name, *_ in WRONG}
    told = {found.name.partition(": ")[2] if found.name.startswith("camera ") else found.name for found in check(car)}
    by_the_dbc = {"CAN: frames told apart", "CAN: rest of the feedback in time"}  # below
    assert told - by_the_dbc == rule


# What a Toyota's bus cannot carry beside what its configuration asks for; its other checks are every car's.
NOT_A_TOYOTA = [
    ("CAN: steering that can be sent", "vehicle.road_wheel_angle_max_rad", 0.116),
    ("CAN: steering that can be sent", "vehicle.steering_ratio", 14.4),
    ("CAN: steering that can be followed", f"{LIMITS}.gate.road_wheel_rate_max_rad_s", 0.13),
    ("CAN: steering that can be followed", f"{LIMITS}.gate.transition_road_wheel_rate_rad_s", 0.13),
    ("CAN: acceleration that can be sent", "vehicle.braking_max_m_s2", 3.51),
    ("CAN: acceleration that can be sent", "vehicle.acceleration_max_m_s2", 2.01),
    ("CAN: steering that is measured", "vehicle.road_wheel_angle_max_rad", 0.62),
    ("CAN: speed that is measured", "vehicle.speed_max_remote_m_s", 40.0),
    ("CAN: motion in time", f"{LIMITS}.failsafe.feedback_lost_ms", 59.0),
    ("CAN: a person's override in time", f"{LIMITS}.authority.override_ms", 31.0),
    ("CAN: override before the steering gives way", f"{LIMITS}.authority.override_torque_nm", 4.51),
    ("CAN: commands in time", "gateway.simulation.ecu.command_timeout_ms", 59.0),
    ("CAN: brakes when the gateway is silent", "gateway.can.watchdog_box", False),
]


def test_the_toyota_s_example_is_consistent_and_warns_of_how_little_it_steers(toyota):
    findings = check(toyota)
    assert broken(findings) == {"turning radius": Verdict.WARNING, "steering range": Verdict.WARNING}
    assert is_consistent(findings)
    assert run(shipped("example_toyota.toml")) == 0


@pytest.mark.parametrize(("name", "path", "value"), NOT_A_TOYOTA, ids=[f"{row[0]}: {row[1]}" for row in NOT_A_TOYOTA])
def test_a_toyota_s_check_fails_when_what_it_guards_is_broken_and_says_what_to_do(toyota, name, path, value):
    found = next(found for found in check(changed(toyota, path, value)) if found.name == name)
    assert (found.verdict, found.fix != "") == (Verdict.ERROR, True)


def test_every_check_of_a_toyota_s_bus_is_broken_by_some_row_above(toyota):
    told = {found.name for found in check(toyota) if found.name.startswith("CAN: ")}
    assert told == {name for name, *_ in NOT_A_TOYOTA}


@pytest.mark.parametrize(("path", "value"), [("vehicle.wheelbase_m", 0.2), ("vehicle.steering_ratio", 200.0)])
def test_a_toyota_s_steering_may_be_little_but_not_more_than_any_car_s(toyota, path, value):
    name = {"vehicle.wheelbase_m": "turning radius", "vehicle.steering_ratio": "steering range"}[path]
    assert broken(check(changed(toyota, path, value)))[name] is Verdict.ERROR


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ('vehicle = "toyota"', 'vehicle = "toyota"\ndbc = "car.dbc"', 'dbc: vehicle = "toyota" has messages of its own'),
        ("steering_ratio = 14.3 ", "steering_ratio = 10.9 ", "a Toyota's is 10.92 and more"),
    ],
)
def test_what_no_toyota_can_be_is_one_line_in_the_table(tmp_path, before, after, said):
    text = shipped("example_toyota.toml").read_text()
    assert before in text
    (tmp_path / "car.toml").write_text(text.replace(before, after))
    _, findings = read_every_section(tmp_path / "car.toml")
    (found,) = [each for each in findings if each.verdict is Verdict.ERROR]
    assert (found.name, said in found.compared) == ("DBC", True), found.compared


def test_a_toyota_without_a_box_that_brakes_it_is_not_started(tmp_path):
    text = shipped("example_toyota.toml").read_text().replace("watchdog_box = true", "watchdog_box = false")
    (tmp_path / "car.toml").write_text(text)
    with pytest.raises(ConfigurationError, match="watchdog_box = false: without commands a Toyota rolls on"):
        gateway.run(tmp_path / "car.toml", threading.Event())


def test_the_simulated_ecu_does_not_pretend_to_be_a_toyota(tmp_path):
    text = shipped("simulated.toml").read_text() + '\n[vehicle_gateway.can]\nvehicle = "toyota"\n'
    (tmp_path / "car.toml").write_text(text)
    with pytest.raises(ConfigurationError, match='vehicle = "toyota": the simulated ECU speaks "drive_by_wire" only'):
        ecu.run(tmp_path / "car.toml", threading.Event())


def test_what_a_simulated_car_may_a_real_one_may_not(car):
    simulated = facts("simulated.toml")
    assert simulated.wire.link.accepts_script and simulated.gateway.limits.authority.engage_autonomously
    real = changed(simulated, "gateway.simulation.scenario", "")
    assert broken(check(real)).items() >= {
        ("scripted operator refused", Verdict.ERROR),
        ("device", Verdict.ERROR),
        ("sets off by itself", Verdict.ERROR),
        ("CAN of a real car", Verdict.ERROR),
        ("camera front: source", Verdict.ERROR),
    }


def test_a_folder_of_another_machine_is_looked_at_and_an_incomplete_one_is_wrong(car):
    absent = changed(changed(car, "around.certificates_problem", "no such certificate"), "around.certificates_folder", False)
    assert broken(check(absent)) == {"certificates": Verdict.WARNING}


@pytest.mark.parametrize(
    ("before", "after", "said"),
    [
        ("accepts_script = false", "accepts_script = true", "accepts_script = true: no program may operate it; set it to false"),
        ("engage_autonomously = false", "engage_autonomously = true", "engage_autonomously = true: it must not set off by itself"),
        ("[wire.link]", "[wire.clock]\nreal_time_factor = 0.5\n\n[wire.link]", "real_time_factor = 0.5: it does not wait"),
    ],
)
def test_the_gateway_itself_refuses_to_start_on_a_road_with_what_only_a_simulation_may(tmp_path, before, after, said):
    text = shipped("example_car.toml").read_text().replace("/var/lib/remote-operation-tower", str(tmp_path))
    assert before in text
    (tmp_path / "car.toml").write_text(text.replace(before, after))
    with pytest.raises(ConfigurationError, match=said):
        gateway.run(tmp_path / "car.toml", threading.Event())
    assert not (tmp_path / "memory.json").exists(), "before it touches anything"


@pytest.mark.parametrize("program", [ecu, simulate])
def test_nothing_simulated_starts_beside_a_car_that_is_really_there(program):
    with pytest.raises(ConfigurationError, match="no scenario: this car is really there"):
        program.run(shipped("example_car.toml"), threading.Event())


def dbc(folder: Path, *changes: tuple[str, str]) -> Path:
    text = shipped("drive_by_wire.dbc").read_text()
    for before, after in changes:
        assert before in text, before
        text = text.replace(before, after)
    (folder / "car.dbc").write_text(text)
    return folder / "car.dbc"


def configured(folder: Path, file: Path) -> Path:
    text = shipped("example_car.toml").read_text().replace('dbc = ""', f'dbc = "{file}"')
    (folder / "car.toml").write_text(text)
    return folder / "car.toml"


def test_a_dbc_with_slower_feedback_and_a_repeated_identity_is_found(tmp_path, car):
    slow = dbc(tmp_path, ('"GenMsgCycleTime" BO_ 528 20', '"GenMsgCycleTime" BO_ 528 60'))
    found = check(replace(car, layouts=read_layouts(str(slow))))
    assert broken(found) == {"CAN: rest of the feedback in time": Verdict.ERROR}
    frames = dict(car.layouts)
    frames["DRIVE_STATE"] = replace(frames["DRIVE_STATE"], data_id=frames["LOCAL_CONTROLS"].data_id)
    assert broken(check(replace(car, layouts=frames))) == {"CAN: frames told apart": Verdict.ERROR}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("BO_ 528 DRIVE_STATE", "BO_ 528 STATE_OF_DRIVE"), "message DRIVE_STATE is missing"),
        (("SG_ SPEED : 12", "SG_ VELOCITY : 12"), "MOTION_FEEDBACK: signal SPEED is missing"),
        (("SG_ COUNTER : 8|4@1+ (1,0) [0|14] \"\" GATEWAY\n SG_ GEAR", " SG_ GEAR"), "DRIVE_STATE: signal COUNTER is missing"),
        (('BA_ "E2EDataId" BO_ 528 8194', 'BA_ "E2EDataId" BO_ 528 8193'), "E2EDataId 8193 is used twice"),
        (('BA_ "E2EDataId" BO_ 528 8194;\n', ""), "DRIVE_STATE: no E2EDataId"),
        (('[-30|100] "m/s" GATEWAY', '[-30|100] "km/h" GATEWAY'), "MOTION_FEEDBACK: signal SPEED is in km/h, ours in m/s"),
        (('VAL_ 256 GEAR 0 "park" 1 "reverse"', 'VAL_ 256 GEAR 0 "reverse" 1 "park"'), "0 is 'reverse', ours is 'park' (VAL_)"),
        (("VERSION", "BO_ nonsense"), "not a valid DBC"),
    ],
)  # fmt: skip
def test_a_dbc_that_we_cannot_speak_is_one_line_in_the_table(tmp_path, change, said):
    _, findings = read_every_section(configured(tmp_path, dbc(tmp_path, change)))
    (found,) = [each for each in findings if each.verdict is Verdict.ERROR]
    assert (found.name, said in found.compared) == ("DBC", True), found.compared


def test_a_dbc_that_is_not_there_is_told(tmp_path):
    _, findings = read_every_section(configured(tmp_path, tmp_path / "none.dbc"))
    assert "none.dbc: cannot be read: No such file" in next(f.compared for f in findings if f.name == "DBC")


@pytest.mark.parametrize(
    ("section", "line", "said"),
    [
        ("[tower.window.colours]", "brightness = 1", "colours"),
        ("[haptics.torque]", "strong = true", "strong"),
        ("[recordings]", "flush_period_ms = 5000", "recordings.flush_period_ms"),
        ("[autonomy.ages]", "imu_ms = 'long'", "autonomy.ages.imu_ms"),
    ],
)
def test_an_unknown_key_of_any_room_is_found_here_and_nothing_else_is_checked(tmp_path, capsys, section, line, said):
    file = tmp_path / "car.toml"
    file.write_text(f"{shipped('example_car.toml').read_text()}\n{section}\n{line}\n")
    assert run(file) == INCONSISTENT
    shown = capsys.readouterr().out
    assert said in shown and "NOT consistent: " in shown and "turning radius" not in shown


def test_the_example_passes_as_a_command_and_names_what_this_machine_lacks(capsys):
    assert run(shipped("example_car.toml")) == 0
    assert "consistent: " in capsys.readouterr().out


def test_a_fix_stands_below_what_was_compared(car):
    console = Console(width=200, record=True)
    console.print(table_of(check(changed(car, "vehicle.vehicle_id", "another-1"))))
    lines = console.export_text().splitlines()
    at = next(number for number, line in enumerate(lines) if line.startswith("vehicle id"))
    assert "'another-1'" in lines[at] and "-> give both the same vehicle_id" in lines[at + 1]
