"""The checklist: what makes an item pass, what makes it fail, and that it stands in nobody's way."""

from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.messages import operator_status
from tower.window.checks import Check, Checks, CheckState, Measured, Turn, checked, items, told
from tower.window.forecast import Minute
from tower.window.picture_age import PictureState
from tower.window.sounds import Trial
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription

CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
S = 1_000_000_000
STILL = operator_status(device="G29", stop_number=4, round_trip_ms=40.0)


def after(*words: dict[str, Any]) -> Checks:
    """The cockpit says STILL, then each of these."""
    checks = checked(Checks(), STILL)
    for word in words:
        checks = checked(checks, msgspec.structs.replace(STILL, **word))
    return checks


def item(name: str, checks: Checks, **changes: Any) -> Check:
    known: dict[str, Any] = {
        "standing": True,
        "pictures": {"front": PictureState.LIVE},
        "description": CAR,
        "minute": Minute(tuple((second, 110) for second in range(40, 60))),
        "now_ns": 60 * S,
        "trial": Trial.PLAYED,
    }
    return next(check for check in items(checks, Measured(**(known | changes))) if check.name == name)


LEFT, MIDDLE, RIGHT = ({"steering_wheel_angle_rad": angle} for angle in (0.5, 0.02, -0.5))


def test_a_wheel_passes_when_left_and_then_right_came_back_as_asked() -> None:
    assert item("wheel", after()) == Check("wheel", "turn it left", CheckState.PENDING)
    assert item("wheel", after(LEFT)).text == "let it go back"
    assert item("wheel", after(LEFT, MIDDLE)) == Check("wheel", "turn it right", CheckState.PENDING)
    assert item("wheel", after(LEFT, MIDDLE, RIGHT)) == Check("wheel", "works", CheckState.PASSED)


def test_a_wheel_that_is_wired_the_wrong_way_fails_for_whoever_does_as_asked() -> None:
    """He turns left as asked and right comes back; letting go, the same is asked again."""
    checks = after(RIGHT)
    assert item("wheel", checks) == Check("wheel", "came right!", CheckState.FAILED)
    assert item("wheel", after(RIGHT, LEFT)).state is CheckState.FAILED  # straight through the middle counts for nothing
    assert item("wheel", after(RIGHT, MIDDLE)).text == "turn it left"
    assert item("wheel", after(LEFT, MIDDLE, LEFT)) == Check("wheel", "came left!", CheckState.FAILED)


def test_keys_and_sticks_are_measured_by_what_the_cockpit_heard_of_them() -> None:
    left, right = {"device": "keyboard", "steer_asked": 1.0}, {"device": "keyboard", "steer_asked": -1.0}
    assert item("wheel", after({"device": "keyboard"}, left, {"device": "keyboard"}, right)).state is CheckState.PASSED


def test_what_the_torque_does_to_a_wheel_is_not_what_the_hands_do() -> None:
    aligning = {"wheel_phase": "align", "steering_wheel_angle_rad": 1.0}
    assert after(aligning).turn is Turn.LEFT


def test_the_brake_passes_when_it_was_pressed_and_let_go() -> None:
    assert item("brake", after()).text == "press it"
    assert item("brake", after({"brake": 0.8})) == Check("brake", "let it go", CheckState.PENDING)
    assert item("brake", after({"brake": 0.8}, {"brake": 0.3})).state is CheckState.PENDING
    assert item("brake", after({"brake": 0.8}, {"brake": 0.01})).state is CheckState.PASSED


def test_another_device_is_measured_anew() -> None:
    checks = after(LEFT, MIDDLE, RIGHT, {"brake": 1.0}, {})
    assert item("brake", checks).state is CheckState.PASSED
    other = checked(checks, msgspec.structs.replace(STILL, device="keyboard"))
    assert item("wheel", other).state is item("brake", other).state is CheckState.PENDING


def test_stop_passes_only_on_the_cars_own_confirmation_of_a_press_since_the_window_opened() -> None:
    old = {"stop_number": 4, "stop_state": "confirmed"}
    assert item("STOP", after(old)).state is CheckState.PENDING
    sent, lost = {"stop_number": 5, "stop_state": "sent"}, {"stop_number": 5, "stop_state": "unconfirmed"}
    done = {"stop_number": 5, "stop_state": "confirmed"}
    assert item("STOP", after(sent)).state is CheckState.PENDING
    assert item("STOP", after(sent, lost)) == Check("STOP", "no answer!", CheckState.FAILED)
    assert item("STOP", after(sent, lost, done)).state is CheckState.PASSED
    assert item("STOP", after(sent, done, {"stop_number": 5, "stop_state": ""})).state is CheckState.PASSED  # cleared afterwards


def test_stop_is_asked_for_only_while_the_car_stands() -> None:
    assert item("STOP", after(), standing=False).text == "at standstill"
    assert item("STOP", after()).text == "press it"


@pytest.mark.parametrize(
    ("trial", "state"),
    [
        (Trial.WAITING, CheckState.PENDING),
        (Trial.PLAYING, CheckState.PENDING),
        (Trial.PLAYED, CheckState.PASSED),
        (Trial.FILED, CheckState.PASSED),
        (Trial.SILENT, CheckState.FAILED),
    ],
)
def test_sound_passes_when_the_alarm_was_played_to_its_end(trial: Trial, state: CheckState) -> None:
    assert item("sound", after(), trial=trial).state is state


@pytest.mark.parametrize("state", list(PictureState))
def test_every_required_camera_has_to_be_live(state: PictureState) -> None:
    good = state is PictureState.LIVE
    assert item("cameras", after(), pictures={"front": state}).state is (CheckState.PASSED if good else CheckState.FAILED)
    assert item("cameras", after(), pictures={}).text == "front: none!"
    assert item("cameras", after(), pictures={"front": PictureState.FROZEN}).text == "front: old!"
    assert item("cameras", after(), description=None).state is CheckState.PENDING


def test_latency_is_the_worst_of_the_last_five_seconds_against_the_age_that_caps_the_speed() -> None:
    def ages(*values: int) -> Minute:
        return Minute(tuple((60 - len(values) + 1 + i, value) for i, value in enumerate(values)))

    assert item("latency", after(), minute=ages(100, 100)).state is CheckState.PENDING
    assert item("latency", after(), minute=ages(900, 100, 100, 200, 100, 100, 100)) == Check("latency", "200 ms", CheckState.PASSED)
    assert item("latency", after(), minute=ages(100, 100, 201, 100, 100)) == Check("latency", "201 ms!", CheckState.FAILED)
    assert item("latency", after(), minute=ages(100, 100, 100, 100, 100), now_ns=90 * S).state is CheckState.PENDING  # long ago


def test_what_is_told_are_names_and_states() -> None:
    nothing = Measured(standing=True, pictures={}, description=None, minute=Minute(), now_ns=0, trial=Trial.SILENT)
    known = items(after(LEFT), nothing)
    assert told(known) == {
        "wheel": "pending",
        "brake": "pending",
        "STOP": "pending",
        "sound": "failed",
        "cameras": "pending",
        "latency": "pending",
    }


@given(
    st.lists(st.fixed_dictionaries({"steer_asked": st.floats(-1, 1), "steering_wheel_angle_rad": st.floats(-8, 8)}), max_size=40)
)
def test_no_wheel_passes_that_never_came_back_on_both_sides(words: list[dict[str, float]]) -> None:
    passed = after(*words).turn is Turn.DONE
    came = [w["steer_asked"] if abs(w["steer_asked"]) >= 0.3 else w["steering_wheel_angle_rad"] for w in words]
    left = next((i for i, value in enumerate(came) if value > 0), None)
    assert not passed or (left is not None and any(value < 0 for value in came[left:]))
