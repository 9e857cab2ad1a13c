"""How late the car does what it is told: known plants in closed loop by frames, and samples that hypothesis makes up."""

from math import isfinite, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import feedback
from tests.vehicle_gateway.one_gateway import MS, REMOTE, remote
from tests.vehicle_gateway.test_ecu import VEHICLE, Loop
from vehicle_gateway.actuation import (
    LAGS,
    ActuationDelay,
    ActuationLimits,
    Lag,
    acceleration_delay,
    sample,
    steering_delay,
    watch_actuation,
)
from vehicle_gateway.simulation.powertrain import ActuatorParameters, car_parameters
from vehicle_gateway.simulation.single_track import Body, ChassisParameters
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation

BUS_MS = 10.0  # the loop of frames carries a command to the ECU at the end of the gateway's cycle
DEFAULTS = ActuationLimits()


def steering(state, limits=DEFAULTS):
    return steering_delay(state.actuation, limits)


def acceleration(state, limits=DEFAULTS):
    return acceleration_delay(state.actuation, limits)


def driven(actuators, seconds, steer_rad=0.1, throttle_m_s2=0.0):
    """The operator's hands go left and right every 4 s, his foot to and fro every 5 s; the simulated car answers over frames."""
    drive, still = remote(), Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    loop = Loop(0.0, car_parameters(VEHICLE, ChassisParameters(), actuators)).run(300, still)  # the ECU follows once it has stood
    loop.car = loop.car._replace(body=Body(vx_m_s=drive.speed), brake_m_s2=0.0)
    loop.run(20, still)
    drive.state = replace(drive.state, actuation=ActuationDelay())  # what the story before it taught was another car
    for number in range(round(seconds * 100)):
        said = loop.feedback.feedback
        drive.local = {name: getattr(said, name) for name in said.__struct_fields__} | {"seat_occupied": False}
        drive.speed, drive.angle = said.speed_m_s, said.road_wheel_angle_rad
        drive.ann.steer = steer_rad * sin(2 * pi * number / 400)
        drive.ann.throttle = throttle_m_s2 * sin(2 * pi * number / 500)
        drive.tick()
        loop.run(10, drive.out.applied)
    assert drive.mode in REMOTE
    return drive


@pytest.mark.parametrize("lag_s", [0.03, 0.05, 0.15])
def test_the_steering_delay_of_the_simulated_car_is_its_lag_and_the_bus(lag_s):
    delay = steering(driven(ActuatorParameters(steering_lag_s=lag_s), 8.0).state)
    expected_ms = lag_s * 1e3 + BUS_MS
    assert delay.measured
    assert expected_ms - 15.0 <= delay.delay_ms <= expected_ms + 20.0  # heard at most a frame and a cycle late
    assert abs(delay.delay_ms - expected_ms) <= delay.bound_ms <= 100.0


def test_the_acceleration_delay_of_the_simulated_car_lies_between_its_drive_and_its_brakes():
    actuators = ActuatorParameters()
    delay = acceleration(driven(actuators, 10.0, throttle_m_s2=1.0).state)
    brakes_ms, drive_ms = actuators.brake_lag_s * 1e3 + BUS_MS, actuators.drive_lag_s * 1e3 + BUS_MS
    assert delay.measured
    assert brakes_ms - delay.bound_ms <= delay.delay_ms <= drive_ms + delay.bound_ms
    assert brakes_ms - 15.0 <= delay.delay_ms <= drive_ms + 20.0


def test_straight_on_at_a_steady_speed_nothing_is_measured_and_the_defaults_stand():
    state = driven(ActuatorParameters(), 6.0, steer_rad=0.0).state
    assert steering(state) == (DEFAULTS.steering_ms, DEFAULTS.steering_bound_ms, False)
    assert acceleration(state) == (DEFAULTS.acceleration_ms, DEFAULTS.acceleration_bound_ms, False)
    other = ActuationLimits(steering_ms=90.0, steering_bound_ms=40.0)
    assert steering(state, other) == (90.0, 40.0, False)


def delayed(steps, number, until=10**9):
    """A command of two tones, which rests from a sample on, and the same so many samples ago."""

    def command(at):
        at = min(at, until)
        return 0.08 * sin(0.05 * at) + 0.03 * sin(0.17 * at)

    return command(number), command(number - steps)


def learned(pairs, lag=None):
    lag = lag or Lag()
    for command, measured in pairs:
        lag = sample(lag, command, measured, 0.01, 100.0)
    return lag


@pytest.mark.parametrize("steps", [0, 1, 7, 20, LAGS - 2])
def test_a_pure_delay_is_found_whatever_offset_and_gain(steps):
    for gain, offset in ((1.0, 0.0), (0.8, 0.5), (1.2, -3.0)):
        lag = learned([(command, gain * then + offset) for command, then in (delayed(steps, number) for number in range(300))])
        assert lag.delay_ms == pytest.approx(20.0 * steps, abs=10.0)


def test_a_delay_longer_than_is_looked_for_is_not_told_as_measured():
    assert learned(delayed(LAGS + 20, number) for number in range(300)).delay_ms is None


def test_a_measured_delay_stays_while_nothing_moves_and_follows_the_car_when_it_changes():
    lag = learned(delayed(3, number, until=300) for number in range(340))
    calm = learned([delayed(3, 1000, until=300)] * 1000, lag)
    assert (calm.delay_ms, calm.bound_ms, calm.samples) == (lag.delay_ms, lag.bound_ms, lag.samples)
    assert calm.delay_ms == pytest.approx(60.0, abs=10.0)
    slower = learned((delayed(10, number) for number in range(2500)), calm)
    assert slower.delay_ms == pytest.approx(200.0, abs=10.0)


def test_feedback_that_has_nothing_to_do_with_the_command_is_not_told_as_a_delay():
    assert learned((delayed(0, number)[0], 0.1 * sin(0.31 * number)) for number in range(600)).delay_ms is None


def watched(before, now_ms, limits=DEFAULTS, is_driven=True, **changes):
    said = feedback(speed_m_s=5.0, **changes)
    applied = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=1.0)
    return watch_actuation(before, applied, said, is_driven, now_ms * MS, limits)


def test_a_pause_a_person_at_the_wheel_or_an_ecu_that_brakes_makes_the_commands_before_worth_nothing():
    state = ActuationDelay(sampled_ns=1000 * MS)
    for now_ms in (1020, 1040, 1060):
        state = watched(state, now_ms)
    assert len(state.steering.commands) == len(state.acceleration.commands) == 3
    assert watched(state, 1070) is state  # not before the next 20 ms
    assert watched(state, 1110).steering.commands == ()
    assert watched(state, 1080, is_driven=False).steering.commands == ()
    assert watched(state, 1080, ecu_following=False).steering.commands == ()
    backwards = watched(state, 1080, gear=Gear.REVERSE)
    assert (len(backwards.steering.commands), backwards.acceleration.commands) == (4, ())


angles = st.floats(-0.8, 0.8)


@settings(max_examples=60)
@given(st.lists(st.tuples(angles, angles), min_size=1, max_size=40), st.integers(0, 25))
def test_whatever_is_applied_and_heard_the_delay_is_a_number_within_its_range(pairs, times):
    lag = learned(pairs * (times + 1))
    state = ActuationDelay(steering=lag)
    delay = steering_delay(state, DEFAULTS)
    assert isfinite(delay.delay_ms) and 0.0 <= delay.delay_ms <= 20.0 * LAGS
    assert isfinite(delay.bound_ms) and 0.0 < delay.bound_ms <= max(DEFAULTS.bound_max_ms, DEFAULTS.steering_bound_ms)
    assert len(lag.commands) <= LAGS and all(map(isfinite, (*lag.means, *lag.squares)))
