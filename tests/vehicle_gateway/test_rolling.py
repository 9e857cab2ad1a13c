"""When a car counts as rolling away, in small numbers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import asdict

from vehicle_gateway.rolling import Rolling, RollingLimits, watch_rolling
from wire.messages.base import Gear

LIMITS = RollingLimits()


def after(cycles, gear=Gear.DRIVE, held=False, driven=True, start=Rolling()):  # noqa: B008 - frozen
    rolling = start
    for speed in cycles:
        rolling = watch_rolling(rolling, speed, gear, held, driven, 0.01, 0.05, LIMITS)
    return rolling


@pytest.mark.parametrize(("gear", "way"), [(Gear.DRIVE, -1.0), (Gear.REVERSE, 1.0)])
def test_fifteen_centimetres_against_the_gear_is_rolling_away_and_a_millimetre_less_is_not(gear, way):
    assert not after([way * 0.1] * 149, gear).hold_hard
    assert after([way * 0.1] * 149, gear).rolled_m == pytest.approx(0.149)
    assert after([way * 0.1] * 151, gear).hold_hard


@pytest.mark.parametrize(("gear", "speed"), [(Gear.DRIVE, 5.0), (Gear.REVERSE, -1.0), (Gear.NEUTRAL, -3.0), (Gear.PARK, 2.0)])
def test_a_car_that_goes_its_way_or_has_no_way_rolls_nowhere(gear, speed):
    assert after([speed] * 500, gear) == Rolling()


def test_the_last_digit_of_the_speed_is_no_motion_however_long():
    assert after([-0.049] * 10_000) == Rolling()
    assert after([0.049] * 10_000, held=True, driven=False) == Rolling(stood=True)


def test_held_brakes_allow_no_motion_once_the_car_has_stood_whatever_the_gear():
    for gear in Gear:
        assert after([0.0] + [0.1] * 151, gear, held=True, driven=False).hold_hard
    assert after([3.0] * 500, held=True, driven=False) == Rolling()  # still rolling out


def test_the_distance_begins_anew_when_the_car_stands():
    rolling = after(([-0.1] * 100 + [0.0]) * 20)
    assert (rolling.rolled_m, rolling.hold_hard) == (0.0, False)


def test_a_car_that_rolled_away_is_held_hard_until_somebody_drives_it():
    rolled = after([0.0] + [-0.1] * 160, held=True, driven=False)
    still = after([0.0] * 1000, held=True, driven=False, start=rolled)
    assert still.hold_hard and still.rolled_m == 0.0
    assert not after([0.0], driven=True, start=still).hold_hard


def test_the_limits_are_those_of_the_design():
    assert asdict(RollingLimits()) == {"rolled_m": 0.15, "hold_hard_m_s2": -6.0}


def test_at_the_speed_of_standstill_it_moves_and_at_the_limit_itself_it_has_not_rolled_away():
    assert after([-0.05] * 301).hold_hard and not after([-0.0499] * 301).hold_hard
    once = watch_rolling(Rolling(), -0.15, Gear.DRIVE, False, True, 1.0, 0.05, LIMITS)
    assert (once.rolled_m, once.hold_hard) == (0.15, False)


@given(st.lists(st.tuples(st.floats(-3.0, 3.0), st.sampled_from(Gear), st.booleans()), max_size=60))
def test_the_distance_is_never_more_than_what_was_moved(steps):
    rolling, moved = Rolling(), 0.0
    for speed, gear, held in steps:
        rolling = watch_rolling(rolling, speed, gear, held, not held, 0.01, 0.05, LIMITS)
        moved += abs(speed) * 0.01
        assert 0.0 <= rolling.rolled_m <= moved + 1e-12
        assert rolling.hold_hard >= (rolling.rolled_m > 0.15)
