"""The last check before CAN, against plain second formulas: limits, steps, braking, cap, gears and the names of the rules."""

from math import inf, isfinite, nan, sqrt, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.gate import Bound, GateLimits, gate
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear, Indicators
from wire.messages.vehicle import Actuation, VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = GateLimits()
FREE = 100.0  # m/s: no cap
TINY = 1e-9


def ask(angle=0.0, acceleration=0.0, gear=Gear.DRIVE):
    return Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration, gear=gear)


def sent(requested, previous=None, speed=5.0, cap=FREE, moving_hands=False, dt=0.01, car=CAR, bounds=()):
    return gate(requested, previous or ask(), speed, cap, moving_hands, dt, car, LIMITS, bounds)


ANGLES = st.floats(-0.8, 0.8)
ACCELERATIONS = st.floats(-10.0, 5.0)
SPEEDS = st.floats(-5.0, 40.0)
TIMES = st.floats(0.0, 0.1)
CAPS = st.floats(0.0, 40.0)
ANY = {
    "requested": st.builds(ask, ANGLES, ACCELERATIONS),
    "previous": st.builds(ask, st.floats(-0.6, 0.6), st.floats(-8.0, 2.0)),
    "speed": SPEEDS,
    "cap": CAPS,
    "moving_hands": st.booleans(),
    "dt": TIMES,
}


def lateral_acceleration(angle, speed):
    """Of a car on a circle: v^2 / R with R = wheelbase / tan(angle)."""
    return speed**2 * abs(tan(angle)) / CAR.wheelbase_m


@given(**ANY)
def test_steering_never_steps_more_than_the_rate_allows(requested, previous, speed, cap, moving_hands, dt):
    step = abs(
        sent(requested, previous, speed, cap, moving_hands, dt).actuation.road_wheel_angle_rad - previous.road_wheel_angle_rad
    )
    rate = 0.3 if moving_hands else 0.6  # rad/s at the road wheels
    assert step <= rate * dt + TINY
    # ISO 11270: 5 m/s3 of lateral jerk; on a straight, d(v^2 angle / wheelbase)/dt
    assert step * max(abs(speed), 1.0) ** 2 / CAR.wheelbase_m <= 5.0 * dt + TINY


@given(**ANY)
def test_steering_beyond_a_limit_only_ever_comes_back(requested, previous, speed, cap, moving_hands, dt):
    angle = sent(requested, previous, speed, cap, moving_hands, dt).actuation.road_wheel_angle_rad
    beyond = abs(angle) > CAR.road_wheel_angle_max_rad + TINY or lateral_acceleration(angle, max(abs(speed), 1.0)) > 3.0 + 1e-6
    assert not beyond or abs(angle) < abs(previous.road_wheel_angle_rad) + TINY


@given(requested=ANY["requested"], speed=SPEEDS)
def test_from_straight_ahead_steering_settles_within_three_m_s2_of_lateral_acceleration(requested, speed):
    now = ask()
    for _ in range(400):
        now = sent(requested, now, speed, dt=0.1).actuation
    assert lateral_acceleration(now.road_wheel_angle_rad, max(abs(speed), 1.0)) <= 3.0 + 1e-6
    assert abs(now.road_wheel_angle_rad) <= 0.6 + TINY


@given(**ANY)
def test_nothing_drives_harder_than_asked_than_the_car_can_or_than_the_jerk_allows(
    requested, previous, speed, cap, moving_hands, dt
):
    applied = sent(requested, previous, speed, cap, moving_hands, dt).actuation.acceleration_m_s2
    jerk, most = (0.5, 1.0) if moving_hands else (3.0, 2.0)
    assert applied <= max(requested.acceleration_m_s2, -8.0) + TINY
    assert applied <= most
    assert applied <= max(previous.acceleration_m_s2, 0.0) + jerk * dt + TINY


@given(**ANY)
def test_braking_passes_at_once_and_whole_whoever_drives(requested, previous, speed, cap, moving_hands, dt):
    asked = requested.acceleration_m_s2
    applied = sent(requested, previous, speed, cap, moving_hands, dt).actuation.acceleration_m_s2
    if asked <= 0.0:
        assert applied <= max(asked, -8.0)
    assert applied >= -8.0


@given(**ANY)
def test_a_transition_never_brakes_less_nor_steers_more(requested, previous, speed, cap, moving_hands, dt):
    calm = sent(requested, previous, speed, cap, False, dt).actuation
    handing = sent(requested, previous, speed, cap, True, dt).actuation
    held = {"curve speed"} & set(sent(requested, previous, speed, cap, False, dt).rules)  # it steers more, so it may drive less
    assert handing.acceleration_m_s2 <= calm.acceleration_m_s2 or held
    if requested.acceleration_m_s2 <= 0.0:
        assert handing.acceleration_m_s2 == calm.acceleration_m_s2
    moved = [abs(each.road_wheel_angle_rad - previous.road_wheel_angle_rad) for each in (handing, calm)]
    assert moved[0] <= moved[1] + TINY


@given(**{**ANY, "dt": st.floats(0.001, 0.1)})
def test_rules_are_named_exactly_when_something_was_changed(requested, previous, speed, cap, moving_hands, dt):
    result = sent(requested, previous, speed, cap, moving_hands, dt)
    assert (result.rules == ()) == (result.actuation == requested)
    steering = {"steering angle", "lateral acceleration", "steering rate", "lateral jerk"} & set(result.rules)
    assert bool(steering) == (result.actuation.road_wheel_angle_rad != requested.road_wheel_angle_rad)
    assert len(set(result.rules)) == len(result.rules)


@given(speed=st.floats(0.0, 40.0), cap=CAPS, previous=ANY["previous"], dt=TIMES, moving_hands=st.booleans())
def test_above_the_cap_there_is_no_traction_and_no_more_than_its_own_braking(speed, cap, previous, dt, moving_hands):
    applied = sent(ask(acceleration=2.0), previous, speed, cap, moving_hands, dt).actuation.acceleration_m_s2
    assert applied >= -2.5
    if speed >= cap:
        assert applied <= 0.0


@given(start=st.floats(0.0, 12.0), cap=st.floats(0.5, 8.33))
def test_full_throttle_settles_on_the_cap_and_does_not_pass_it(start, cap):
    speed, now = start, ask()
    for _ in range(1500):
        now = sent(ask(acceleration=2.0), now, speed, cap, dt=0.01).actuation
        speed = max(speed + now.acceleration_m_s2 * 0.01, 0.0)
        assert speed <= max(start, cap) + TINY
    assert abs(speed - cap) < 0.05


def test_the_cap_holds_in_reverse_as_well():
    assert (
        sent(ask(acceleration=2.0, gear=Gear.REVERSE), ask(gear=Gear.REVERSE), speed=-2.0, cap=1.0).actuation.acceleration_m_s2
        < 0.0
    )


@given(previous=st.sampled_from(Gear), requested=st.sampled_from(Gear), speed=SPEEDS | st.sampled_from([0.3, -0.3, 0.299]))
def test_gears_change_only_below_three_tenths_of_a_metre_per_second(previous, requested, speed):
    gear = sent(ask(gear=requested), ask(gear=previous), speed).actuation.gear
    assert gear == (requested if abs(speed) < 0.3 else previous)


@pytest.mark.parametrize(("engaged", "asked"), [(Gear.REVERSE, Gear.DRIVE), (Gear.DRIVE, Gear.REVERSE)])
def test_traction_for_a_gear_that_is_refused_never_drives_the_car_the_other_way(engaged, asked):
    speed = -1.0 if engaged is Gear.REVERSE else 1.0
    result = sent(ask(acceleration=1.5, gear=asked), ask(acceleration=1.0, gear=engaged), speed)
    assert result.actuation.gear is engaged
    assert result.actuation.acceleration_m_s2 <= 0.0


PAUSES = st.lists(st.one_of(st.floats(0.0, 0.02), st.floats(0.0, 5.0)), min_size=1, max_size=60)


@settings(max_examples=40, deadline=None)
@given(times=PAUSES, speed=SPEEDS, moving_hands=st.booleans(), wild=st.randoms(use_true_random=False))
def test_over_any_times_nothing_moves_faster_than_in_real_time_nor_leaps_after_a_pause(times, speed, moving_hands, wild):
    """opendbc checks both: a step per frame, and the sum of the steps in real time."""
    now, passed_s, rate, jerk = ask(), 0.0, 0.3 if moving_hands else 0.6, 0.5 if moving_hands else 3.0
    for dt in times:
        after = sent(ask(wild.uniform(-0.8, 0.8), wild.uniform(-10, 5)), now, speed, FREE, moving_hands, dt).actuation
        assert abs(after.road_wheel_angle_rad - now.road_wheel_angle_rad) <= rate * 0.02 + TINY
        assert after.acceleration_m_s2 <= max(now.acceleration_m_s2, 0.0) + jerk * 0.02 + TINY
        now, passed_s = after, passed_s + dt
        assert abs(now.road_wheel_angle_rad) <= rate * passed_s + TINY
        assert abs(tan(now.road_wheel_angle_rad)) * max(abs(speed), 1.0) ** 2 / CAR.wheelbase_m <= 5.0 * passed_s + TINY
        assert now.acceleration_m_s2 <= jerk * passed_s + TINY


@given(requested=ANY["requested"], speed=st.floats(0.0, 12.0), total=st.floats(0.005, 0.02), calls=st.integers(2, 10))
def test_a_gateway_that_is_called_more_often_moves_nothing_faster(requested, speed, total, calls):
    once, often = sent(requested, ask(), speed, dt=total).actuation, ask()
    for _ in range(calls):
        often = sent(requested, often, speed, dt=total / calls).actuation
    assert often.road_wheel_angle_rad == pytest.approx(once.road_wheel_angle_rad, abs=1e-9)
    assert often.acceleration_m_s2 == pytest.approx(once.acceleration_m_s2, abs=1e-9)


@settings(max_examples=40, deadline=None)
@given(requested=ANY["requested"], speed=SPEEDS, dt=TIMES)
def test_what_the_gate_let_pass_and_reached_passes_again_unchanged(requested, speed, dt):
    now = ask()
    for _ in range(500):
        now = sent(requested, now, speed, dt=0.02).actuation
    again = sent(now, now, speed, dt=dt)
    assert again.actuation == now and again.rules == ()


@settings(max_examples=40, deadline=None)
@given(
    wishes=st.lists(st.tuples(ANGLES, st.floats(0.0, 5.0), st.booleans()), min_size=1, max_size=8),
    dt=st.floats(0.004, 0.02),
)
def test_a_car_that_speeds_up_in_a_curve_never_exceeds_three_m_s2_of_lateral_acceleration(wishes, dt):
    """The limit shrinks with the square of the speed, faster than the wheel may turn while control changes hands."""
    speed, now = 0.0, ask()
    for angle, acceleration, moving_hands in wishes:
        for _ in range(round(1.5 / dt)):
            now = sent(ask(angle, acceleration), now, speed, FREE, moving_hands, dt).actuation
            assert lateral_acceleration(now.road_wheel_angle_rad, max(speed, 1.0)) <= 3.0 + 1e-6
            speed = max(speed + now.acceleration_m_s2 * dt, 0.0)


def test_traction_waits_for_a_wheel_that_is_still_too_far_in_and_nothing_brakes_for_it():
    """At lock 3.44 m/s is the end; a push from outside (a slope) to 6 m/s leaves the wheel coming back at its rate."""
    result = sent(ask(0.6, 2.0), ask(0.6, 0.0), speed=6.0)
    assert result.actuation.acceleration_m_s2 == 0.0
    assert "curve speed" in result.rules
    assert 0.6 - 0.006 - TINY <= result.actuation.road_wheel_angle_rad < 0.6


def test_a_stronger_car_gets_no_more_traction_than_iso_15622_allows():
    strong, now = replace(CAR, acceleration_max_m_s2=5.0), ask()
    for _ in range(300):
        now = sent(ask(acceleration=5.0), now, car=strong).actuation
    assert now.acceleration_m_s2 == 2.0


@given(**ANY, extra=st.floats(-12.0, 3.0))
def test_a_bound_from_outside_only_takes_away_and_is_named_when_it_did(requested, previous, speed, cap, moving_hands, dt, extra):
    free = sent(requested, previous, speed, cap, moving_hands, dt).actuation
    held = sent(requested, previous, speed, cap, moving_hands, dt, bounds=(Bound("fence", extra),))
    assert held.actuation.acceleration_m_s2 == min(free.acceleration_m_s2, max(extra, -8.0))
    assert held.actuation.road_wheel_angle_rad == free.road_wheel_angle_rad
    if held.actuation.acceleration_m_s2 < free.acceleration_m_s2:
        assert "fence" in held.rules


def test_lights_and_horn_pass_untouched():
    asked = replace(ask(0.7, 4.0), indicators=Indicators.LEFT, hazard=True, horn=True)
    passed = sent(asked).actuation
    assert (passed.indicators, passed.hazard, passed.horn) == (Indicators.LEFT, True, True)


@pytest.mark.parametrize("bad", [nan, inf, -inf])
def test_a_number_that_is_none_never_reaches_the_car_and_does_not_stay(bad):
    now = ask(0.1, 0.5)
    for requested in (ask(bad, 0.5), ask(0.1, bad), ask(bad, bad)):
        passed = sent(requested, now).actuation
        assert isfinite(passed.road_wheel_angle_rad) and isfinite(passed.acceleration_m_s2)
        assert abs(passed.road_wheel_angle_rad - 0.1) <= 0.006 + TINY
        assert passed.acceleration_m_s2 <= 0.5 + 0.03 + TINY


def test_a_known_case_by_hand():
    """At 5 m/s the limit of 3 m/s2 is atan(2.7 * 3 / 25) = 0.3133 rad; the jerk allows 2.7 * 5 / 25 * 0.01 = 0.0054 rad a step."""
    result = sent(ask(0.5, 2.0), ask(0.0, 0.0), speed=5.0)
    assert result.actuation.road_wheel_angle_rad == pytest.approx(0.0054, abs=1e-6)
    assert result.actuation.acceleration_m_s2 == pytest.approx(0.03)
    assert result.rules == ("lateral acceleration", "steering rate", "lateral jerk", "jerk")
    assert lateral_acceleration(0.3133, 5.0) == pytest.approx(3.0, rel=1e-3)
    assert sqrt(3.0 * CAR.wheelbase_m / tan(0.6)) == pytest.approx(3.44, abs=0.01)  # below this speed the rack is the limit
