from math import pi, radians

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.devices.gamepad import profile_of
from tower.devices.known import KNOWN, button_code, through_evdev, through_sdl
from tower.devices.profile import (
    Pedal,
    Profile,
    Steering,
    held,
    meant,
    noticed,
    problems,
    steering_share,
    travel,
    wheel_angle_rad,
)
from tower.devices.switches import Control

G920 = through_evdev(KNOWN["046d:c262"])
# A pad as SDL 2.28 maps its virtual controllers, and an Xbox pad on Linux with triggers on axes 2 and 5 and a hat.
VIRTUAL = {
    "leftx": "a0",
    "lefttrigger": "a4",
    "righttrigger": "a5",
    "leftshoulder": "b9",
    "rightshoulder": "b10",
    "a": "b0",
    "b": "b1",
    "dpleft": "b13",
}
XBOX = {
    "leftx": "a0",
    "lefttrigger": "a2",
    "righttrigger": "a5",
    "leftshoulder": "b4",
    "a": "b0",
    "b": "b1",
    "dpup": "h0.1",
    "dpleft": "h0.8",
}


def test_a_pedal_of_a_g920_rests_at_255_and_is_down_at_0():
    assert travel({"axis 1": 255.0}, G920.throttle) == 0.0
    assert travel({"axis 1": 0.0}, G920.throttle) == 1.0
    assert travel({"axis 2": 51.0}, G920.brake) == pytest.approx(0.8)


def test_a_pedal_that_has_not_reported_has_no_position_at_all():
    assert travel({}, G920.throttle) is None
    assert wheel_angle_rad({}, G920.steering) is None


def test_the_wheel_turns_left_positive_and_450_degrees_either_way():
    assert wheel_angle_rad({"axis 0": 0.0}, G920.steering) == pytest.approx(2.5 * pi)
    assert wheel_angle_rad({"axis 0": 65535.0}, G920.steering) == pytest.approx(-2.5 * pi)
    assert wheel_angle_rad({"axis 0": 32767.5}, G920.steering) == pytest.approx(0.0)
    assert wheel_angle_rad({"axis 0": 32767.5 + 65535 / 10}, G920.steering) == pytest.approx(radians(-90))


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_no_reading_leaves_the_range_of_a_pedal(value: float, released: float, pressed: float):
    if abs(released - pressed) > 1e-3:
        share = travel({"axis 1": value}, Pedal(axis="axis 1", released=released, pressed=pressed))
        assert share is not None and 0.0 <= share <= 1.0


@given(st.floats(-2.0, 2.0))
def test_a_stick_gives_nothing_in_its_dead_zone_all_at_its_end_and_keeps_the_side(value: float):
    stick = Steering(axis="axis 0", left=-1.0, right=1.0, dead_zone=0.1, exponent=1.8)
    share = steering_share({"axis 0": value}, stick)
    assert share is not None and abs(share) <= 1.0
    if abs(value) <= 0.1:
        assert share == 0.0
    elif abs(value) >= 1.0:
        assert share == pytest.approx(-1.0 if value > 0 else 1.0)
    else:
        assert (share > 0) == (value < 0)


def test_the_g29_has_its_pedals_on_other_axes_than_the_g920():
    g29 = through_evdev(KNOWN["046d:c24f"])
    assert (G920.throttle.axis, G920.brake.axis) == ("axis 1", "axis 2")
    assert (g29.throttle.axis, g29.brake.axis) == ("axis 2", "axis 5")


def test_the_ends_that_the_device_names_count_more_than_the_table():
    wide = through_evdev(KNOWN["046d:c262"], {1: (0.0, 1023.0), 0: (0.0, 65535.0)})
    assert (wide.throttle.released, wide.throttle.pressed) == (1023.0, 0.0)
    assert (wide.brake.released, wide.brake.pressed) == (255.0, 0.0)


def test_without_evdev_the_axes_are_counted_in_the_order_of_their_codes():
    g29, g920 = through_sdl(KNOWN["046d:c24f"]), through_sdl(KNOWN["046d:c262"])
    # reference: G920 wheel, throttle, brake, clutch; the G29's codes are X, Y clutch, Z throttle, RZ brake
    assert [g920.steering.axis, g920.throttle.axis, g920.brake.axis] == ["axis 0", "axis 1", "axis 2"]
    assert [g29.steering.axis, g29.throttle.axis, g29.brake.axis] == ["axis 0", "axis 2", "axis 3"]
    assert (g920.throttle.released, g920.throttle.pressed) == (1.0, -1.0)


def test_buttons_go_on_at_704_after_303():
    assert [button_code(number) for number in (0, 15, 16, 24)] == [288, 303, 704, 712]


@pytest.mark.parametrize("wheel", sorted(KNOWN))
def test_every_wheel_of_the_table_can_be_driven_with(wheel: str):
    for profile in (through_evdev(KNOWN[wheel]), through_sdl(KNOWN[wheel])):
        assert problems(profile) == ()
        assert set(profile.buttons.values()) >= {
            "dead_man",
            "stop",
            "accept",
            "hand_back",
            "return",
            "clear",
            "engage",
            "gear",
            "left",
            "right",
            "hazard",
            "horn",
            "lights",
            "wipers",
        }
        assert len(set(profile.buttons.values())) == len(profile.buttons)


def test_only_the_way_down_of_a_button_is_a_press_and_a_repeat_is_none():
    levels, pressed = noticed({}, [("button 289", 1.0), ("button 289", 1.0), ("button 289", 0.0), ("axis 1", 3.0)])
    assert pressed == ("button 289",)
    assert levels == {"button 289": 0.0, "axis 1": 3.0}
    assert meant(pressed, G920) == (Control.STOP,)
    assert meant(("button 999",), G920) == ()


def test_the_left_paddle_held_is_the_dead_man():
    assert held({"button 293": 1.0, "button 292": 0.0}, G920) == {Control.DEAD_MAN}


def test_a_profile_without_dead_man_or_stop_or_with_a_pedal_that_does_not_move_says_what_to_do():
    broken = msgspec.structs.replace(G920, buttons={"button 1": "fly"}, brake=Pedal(axis="axis 2", released=7.0, pressed=7.0))
    told = "\n".join(problems(broken))
    assert "'fly'" in told and "tower devices learn" in told and "tower devices calibrate" in told
    assert "dead_man" in told and "stop" in told


@pytest.mark.parametrize(("mapping", "throttle", "dead_man"), [(VIRTUAL, "axis 5", "button 9"), (XBOX, "axis 5", "button 4")])
def test_a_pad_that_sdl_knows_needs_no_calibration(mapping: dict[str, str], throttle: str, dead_man: str):
    profile = profile_of(mapping, "Pad", "1234:5678")
    assert profile is not None and problems(profile) == ()
    assert profile.throttle == Pedal(axis=throttle, released=-1.0, pressed=1.0)
    assert profile.buttons[dead_man] == "dead_man"


def test_halves_inversions_hats_and_buttons_of_a_mapping_are_understood():
    profile = profile_of({**XBOX, "leftx": "a0~", "righttrigger": "b7", "lefttrigger": "-a2", "x": "h0.8"}, "Pad", "1234:5678")
    assert profile is not None
    assert (profile.steering.left, profile.steering.right) == (1.0, -1.0)
    assert profile.throttle == Pedal(axis="button 7", released=0.0, pressed=1.0)
    assert profile.brake == Pedal(axis="axis 2", released=0.0, pressed=-1.0)
    assert profile.buttons["hat 0 up"] == "hazard"


def test_a_pad_without_triggers_or_bumper_is_not_guessed():
    for lacking in ("leftx", "lefttrigger", "righttrigger", "leftshoulder"):
        assert profile_of({key: value for key, value in XBOX.items() if key != lacking}, "Pad", "1234:5678") is None


@given(st.dictionaries(st.sampled_from(sorted(XBOX)), st.text("ab+-~h.0123456789", max_size=5)))
def test_no_mapping_whatever_makes_an_unusable_profile_or_raises(mapping: dict[str, str]):
    profile = profile_of(mapping, "Pad", "1234:5678")
    if profile is not None:
        assert msgspec.convert(msgspec.to_builtins(profile), Profile) == profile
