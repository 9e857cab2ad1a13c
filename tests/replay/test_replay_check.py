"""Recorded steps run again: every one is the same bit for bit, and a falsified input is named by its cycle and field."""

from pathlib import Path
from typing import Any

import msgspec
import pytest
from typer.testing import CliRunner

from recordings.check import check, installed_replays
from recordings.program import app
from recordings.read import open_recording


def run(*arguments: object) -> Any:
    return CliRunner().invoke(app, [str(argument) for argument in arguments], env={"COLUMNS": "200"})


def tallies(path: Path) -> dict[str, Any]:
    with open_recording(path) as recording:
        return {tally.kind: tally for tally in check(recording, installed_replays())}


def test_every_recorded_step_of_a_drive_gives_the_same_outputs_again(whole_drive):
    found = tallies(whole_drive)
    counts = {kind: (tally.checked, tally.differing, tally.unchecked, tally.missing) for kind, tally in found.items()}
    assert counts == {"gateway cycle": (600, 0, 0, 0), "monitor step": (90, 0, 0, 0), "torque step": (700, 0, 0, 0)}
    result = run("replay", whole_drive, "--check")
    assert result.exit_code == 0, result.stdout
    assert "gateway cycle" in result.stdout and "600" in result.stdout


def test_the_drive_is_worth_checking_the_car_drives_the_monitor_asks_and_the_wheel_is_taken(whole_drive):
    with open_recording(whole_drive) as recording:
        cycles = [message for _, message in recording.messages("gateway_cycle")]
        looks = [msgspec.json.decode(message.outputs) for _, message in recording.messages("monitor_step")]
        phases = [msgspec.json.decode(message.outputs)["phase"] for _, message in recording.messages("torque_steps")]
    assert {"standby", "autonomous"} == {cycle.mode for cycle in cycles}
    assert {"nominal", "caution", "request"} == {look["doubt"] for look in looks}
    assert {"idle", "align", "active"} <= {phase for column in phases for phase in column}


def test_a_changed_input_of_a_gateway_cycle_is_named_with_its_cycle_and_field(whole_drive, make, tmp_path):
    def brake(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["number"] == 321:
            message["inputs"]["autonomy"]["acceleration_m_s2"] = -1.25

    falsified = make.rewrite(whole_drive, tmp_path / "falsified.mcap", brake)
    result = run("replay", falsified, "--check")
    assert result.exit_code == 1
    assert "gateway cycle 321: requested.acceleration_m_s2 recorded -" in result.stdout
    assert "replayed -1.25" in result.stdout
    assert "gateway cycle 320" not in result.stdout


def test_a_last_bit_changed_in_an_output_is_a_difference(whole_drive, make, tmp_path):
    def nudge(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["number"] == 400:
            applied = message["outputs"]["applied"]
            applied["road_wheel_angle_rad"] = float.fromhex(_next_up(applied["road_wheel_angle_rad"]))

    found = tallies(make.rewrite(whole_drive, tmp_path / "nudged.mcap", nudge))["gateway cycle"]
    assert found.differing == 1
    assert found.mismatches[0].startswith("gateway cycle 400: applied.road_wheel_angle_rad recorded ")


def _next_up(value: float) -> str:
    mantissa, exponent = float.hex(value).split("p")
    return f"{mantissa[:-1]}{'0' if mantissa[-1] == '1' else '1'}p{exponent}"


def test_an_input_that_changes_the_state_alone_is_found_where_the_next_recorded_start_stands(whole_drive, make, tmp_path):
    def turn(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["number"] == 260:
            message["inputs"]["feedback"]["yaw_rate_rad_s"] = 1.0  # dead reckoning: nothing follows a corridor here

    found = tallies(make.rewrite(whole_drive, tmp_path / "turned.mcap", turn))["gateway cycle"]
    assert found.differing == 1
    assert found.mismatches[0].startswith("gateway cycle 300: state.odometry.")


def test_changed_limits_in_a_start_are_a_difference(whole_drive, make, tmp_path):
    def loosen(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["start"] is not None and message["number"] == 200:
            message["start"]["vehicle"]["braking_max_m_s2"] = 7.5

    found = tallies(make.rewrite(whole_drive, tmp_path / "loosened.mcap", loosen))["gateway cycle"]
    assert found.mismatches[0] == "gateway cycle 200: vehicle.braking_max_m_s2 recorded 7.5, replayed 8.0"


@pytest.mark.parametrize(
    ("topic", "number", "path", "value", "said"),
    [
        ("monitor_step", 24, ("inputs", "levels", 0, "level"), 0.1, "monitor step 24: channels.planner.above_since_ns recorded "),
        ("torque_steps", 599, ("inputs", "angle_rad", 3), 0.9, "torque step 602: torque recorded "),
        ("torque_steps", 599, ("outputs", "lateral_m_s2", 2), 0.9, "torque step 601: lateral_m_s2 recorded 0.9, replayed "),
    ],
)
def test_a_changed_record_of_monitor_or_torque_is_named(whole_drive, make, tmp_path, topic, number, path, value, said):
    changed = []

    def falsify(name: str, message: dict[str, Any]) -> None:
        if name == topic and message.get("number", message.get("first")) == number:
            node: Any = message
            for part in path[:-1]:
                node = node[part]
            node[path[-1]] = value
            changed.append(number)

    result = run("replay", make.rewrite(whole_drive, tmp_path / "falsified.mcap", falsify), "--check")
    assert changed == [number]
    assert result.exit_code == 1
    assert said in result.stdout


def test_an_input_that_is_no_input_any_more_is_told_and_not_a_traceback(whole_drive, make, tmp_path):
    def spoil(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["number"] == 77:
            message["inputs"]["autonomy"]["acceleration_m_s2"] = 400.0

    result = run("replay", make.rewrite(whole_drive, tmp_path / "spoilt.mcap", spoil), "--check")
    assert result.exit_code == 1
    assert "gateway cycle 77: cannot be replayed: Expected `float` <= 5.0" in result.stdout


def test_a_recorder_that_came_late_begins_with_the_first_cycle_it_heard(make, tmp_path):
    path = make.write(tmp_path / "late.mcap", make.gateway(120, make.line(heard_from=37)))
    found = tallies(path)["gateway cycle"]
    assert (found.checked, found.unchecked, found.missing, found.runs) == (84, 0, 0, 1)


def test_after_a_recorder_was_killed_the_check_goes_on_with_the_first_cycle_that_is_heard_again(make, tmp_path):
    path = make.write(tmp_path / "gap.mcap", make.gateway(200, make.line(deaf=range(60, 101))))
    found = tallies(path)["gateway cycle"]
    assert (found.checked, found.differing, found.unchecked, found.missing, found.runs) == (159, 0, 0, 41, 2)


def test_a_gateway_that_was_restarted_is_a_run_of_its_own(make, tmp_path):
    first = make.gateway(90, make.line())
    second = make.gateway(50, make.line(), make.start_ns + 10**10)
    found = tallies(make.write(tmp_path / "two.mcap", first + second))["gateway cycle"]
    assert (found.checked, found.differing, found.missing, found.runs) == (140, 0, 0, 2)


def test_a_lost_batch_of_torque_steps_costs_its_own_steps_and_is_counted(make, tmp_path):
    rows = make.torque(200)
    lost = msgspec.json.decode(rows.pop(3)[2])["count"]
    found = tallies(make.write(tmp_path / "lost.mcap", rows))["torque step"]
    assert (found.checked, found.differing, found.missing, found.runs) == (200 - lost, 0, lost, 2)


def test_a_cycle_without_a_start_before_it_is_counted_as_not_checked(whole_drive, make, tmp_path):
    def forget(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle" and message["number"] < 500:
            message["start"] = None

    found = tallies(make.rewrite(whole_drive, tmp_path / "startless.mcap", forget))["gateway cycle"]
    assert (found.checked, found.unchecked, found.runs) == (101, 499, 1)


def test_a_recording_without_steps_is_one_line_and_exit_code_2(make, tmp_path):
    result = run("replay", make.write(tmp_path / "empty.mcap", []), "--check")
    assert result.exit_code == 2
    assert result.stderr.startswith(f"{tmp_path / 'empty.mcap'}: holds no recorded steps (")
    assert result.stderr.count("\n") == 1


def test_a_field_that_came_after_the_recording_counts_as_its_default(whole_drive, make, tmp_path):
    def older(topic: str, message: dict[str, Any]) -> None:
        if topic == "gateway_cycle":
            del message["outputs"]["lease_replies"]
            if message["start"] is not None:
                del message["start"]["state"]["bounces"]

    found = tallies(make.rewrite(whole_drive, tmp_path / "older.mcap", older))["gateway cycle"]
    assert (found.checked, found.differing) == (600, 0)
