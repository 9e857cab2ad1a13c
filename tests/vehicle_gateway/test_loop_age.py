"""Loop age and motion to motion with what cameras, screens and the car add; each expected value is a sum done by hand."""

from math import isfinite

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import CAR, LIMITS, MS, REAR, remote
from vehicle_gateway.actuation import ActuationDelay, Lag
from vehicle_gateway.loop_age import loop_age_ms, motion_to_motion
from vehicle_gateway.reports import vehicle_state_of
from vehicle_gateway.state import Picture
from wire.messages.base import decoder, encode
from wire.messages.vehicle import VehicleState

FRONT = CAR.cameras[0]
LENS = replace(FRONT, exposure_delay_ms=30.0, exposure_bound_ms=10.0)
SIDE = replace(FRONT, name="side", exposure_delay_ms=70.0, exposure_bound_ms=20.0)
JUDGING = replace(LIMITS, actuation=replace(LIMITS.actuation, in_loop_age=True))
SLOW = ActuationDelay(steering=Lag(delay_ms=120.0, bound_ms=40.0), acceleration=Lag(delay_ms=100.0, bound_ms=90.0))


def car(*cameras):
    return replace(CAR, cameras=cameras)


def seen(ages_ms, scan_out=(0.0, 0.0), actuation=SLOW):
    """The state after a command that was given on pictures so old."""
    state = remote().state
    command = replace(state.command, scan_out_delay_ms=scan_out[0], scan_out_bound_ms=scan_out[1])
    at_ns = state.command_ns
    pictures = {name: Picture(capture_ns=at_ns - round(age * MS), advanced_ns=at_ns) for name, age in ages_ms.items()}
    return replace(state, command=command, pictures=pictures, actuation=actuation)


def test_the_loop_age_counts_camera_and_screen_at_the_upper_end_of_their_bounds():
    state = seen({"front": 80.0}, (25.0, 5.0))
    assert loop_age_ms(state, car(FRONT), LIMITS) == pytest.approx(80 + 25 + 5)
    assert loop_age_ms(state, car(LENS), LIMITS) == pytest.approx(80 + 30 + 10 + 25 + 5)


def test_the_worst_camera_is_the_oldest_with_its_own_delay_and_one_that_nobody_requires_counts_nothing():
    state = seen({"front": 80.0, "side": 60.0, "rear": 900.0})
    assert loop_age_ms(state, car(LENS, SIDE, REAR), LIMITS) == pytest.approx(60 + 70 + 20)  # not 80 + 30 + 10
    assert loop_age_ms(state, car(replace(LENS, required=False), REAR), LIMITS) == 0.0


def test_motion_to_motion_is_the_middle_of_every_part_and_the_slower_actuator():
    said = motion_to_motion(seen({"front": 80.0}, (25.0, 5.0)), car(LENS), LIMITS)
    assert (said.picture_ms, said.camera_ms, said.scan_out_ms, said.steering_ms, said.acceleration_ms) == (80, 30, 25, 120, 100)
    assert said.total_ms == pytest.approx(80 + 30 + 25 + 120)
    assert said.bound_ms == pytest.approx(10 + 5 + (100 + 90 - 120))  # the acceleration may be the slower one
    assert said.steering_measured and said.acceleration_measured


def test_where_the_owner_wants_it_the_loop_age_counts_the_car_by_the_later_end_of_both_bounds():
    state, vehicle = seen({"front": 80.0}, (25.0, 5.0)), car(LENS)
    assert loop_age_ms(state, vehicle, JUDGING) == pytest.approx(80 + 30 + 10 + 25 + 5 + (100 + 90))  # not the steering's 120 + 40
    unknown = replace(state, actuation=ActuationDelay())
    assert loop_age_ms(unknown, vehicle, JUDGING) == pytest.approx(80 + 30 + 10 + 25 + 5 + (300 + 300))
    assert motion_to_motion(state, vehicle, JUDGING) == motion_to_motion(state, vehicle, LIMITS)
    assert loop_age_ms(seen({}), vehicle, JUDGING) == 0.0


def test_until_it_is_measured_the_configured_actuation_is_told_as_such():
    said = motion_to_motion(seen({"front": 80.0}, actuation=ActuationDelay()), car(FRONT), LIMITS)
    assert not said.steering_measured and not said.acceleration_measured
    assert (said.total_ms, said.bound_ms) == (pytest.approx(80 + LIMITS.actuation.acceleration_ms), 300.0)


def test_without_a_picture_nothing_is_claimed():
    state = seen({})
    assert (loop_age_ms(state, car(LENS), LIMITS), motion_to_motion(state, car(LENS), LIMITS)) == (0.0, None)


def test_a_slow_camera_lowers_the_speed_cap_and_a_slow_actuator_does_not():
    """80 ms old at the arrival, less the 2 ms before the cycle, and 170 ms of the camera: v * 200 / 248, and it never rises."""
    slow = remote(car(replace(FRONT, exposure_delay_ms=150.0, exposure_bound_ms=20.0))).run(12.0)
    assert slow.state.loop_age_ms == pytest.approx(78 + 170)
    assert slow.state.cap.cap_m_s == pytest.approx(LIMITS.cap.speed_first_m_s * 200 / 248)
    late = remote()
    late.state = replace(late.state, actuation=ActuationDelay(steering=Lag(delay_ms=600.0, bound_ms=100.0)))
    late.run(16.0)
    assert late.state.cap.cap_m_s == pytest.approx(CAR.speed_max_remote_m_s)
    told = vehicle_state_of(late.state, late.out, 1, late.now, CAR, LIMITS)
    assert told.motion_to_motion.total_ms == pytest.approx(told.loop_age_ms + 600.0)
    assert decoder(VehicleState).decode(encode(told)) == told


delays = st.floats(0.0, 500.0)


@given(st.floats(0.0, 1e6), delays, delays, delays, delays, st.floats(0.0, 600.0), st.floats(0.0, 150.0))
def test_the_ages_are_numbers_that_are_never_negative_and_never_less_than_a_part(
    age_ms, lens_ms, lens_bound_ms, screen_ms, screen_bound_ms, slow_ms, slow_bound_ms
):
    lag = Lag(delay_ms=slow_ms, bound_ms=slow_bound_ms)
    state = seen({"front": age_ms}, (screen_ms, screen_bound_ms), ActuationDelay(steering=lag, acceleration=lag))
    vehicle = car(replace(FRONT, exposure_delay_ms=lens_ms, exposure_bound_ms=lens_bound_ms))
    said, age = motion_to_motion(state, vehicle, LIMITS), loop_age_ms(state, vehicle, LIMITS)
    assert isfinite(said.total_ms) and isfinite(said.bound_ms) and isfinite(age)
    assert said.total_ms >= max(said.picture_ms, said.camera_ms, said.scan_out_ms, said.steering_ms) >= 0.0 <= said.bound_ms
    assert age + slow_ms <= said.total_ms + said.bound_ms + 1e-6  # the law's age is within what is told
    assert loop_age_ms(state, vehicle, JUDGING) == pytest.approx(said.total_ms + said.bound_ms)  # and with the car its upper end
