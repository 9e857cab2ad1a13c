"""The minimal risk manoeuvre in simulated time: how far it goes, how hard it brakes, how it steers."""

from math import cos, hypot, sin, tan

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import asdict, replace

from vehicle_gateway.corridor import CORRIDOR_AGE_MAX_NS, Corridor, Odometry, advance
from vehicle_gateway.gate import GateLimits, gate
from vehicle_gateway.safe_stop import StopLimits, safe_stop, speed_for_distance_m_s, stopping_distance_m
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.vehicle import Actuation, VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = StopLimits()
NOW = 10**12
DT = 0.01


def straight(length_m):
    return tuple((0.5 * k, 0.0) for k in range(int(length_m * 2) + 1))


def arc(radius, length_m):
    return tuple((radius * sin(s / radius), radius * (1 - cos(s / radius))) for s in (0.25 * k for k in range(int(length_m * 4))))


def stop(points, speed, previous=None, age_ns=0, seconds=20.0):
    """(x, y, speed, actuation) every 10 ms of a kinematic bicycle from the origin until it stands; through the gate."""
    applied = previous or Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    corridor, odometry, track = Corridor(points=points, checked_ns=NOW - age_ns), Odometry(), []
    for step in range(int(seconds / DT)):
        asked = safe_stop(applied, corridor, odometry, speed, NOW + round(step * DT * 1e9), DT, CAR, LIMITS)
        applied = gate(asked, applied, speed, 100.0, False, DT, CAR, GateLimits()).actuation
        yaw_rate = speed * tan(applied.road_wheel_angle_rad) / CAR.wheelbase_m
        odometry = advance(odometry, speed, yaw_rate, DT)
        speed = max(speed + applied.acceleration_m_s2 * DT, 0.0)
        track.append((odometry.x_m, odometry.y_m, speed, applied))
        if speed == 0.0:
            return track
    raise AssertionError(f"still at {speed} m/s after {seconds} s")


def numerically(speed, reaction, braking, jerk, dt=0.0005):
    """Distance to standstill, in small steps of time."""
    distance, deceleration, t = 0.0, 0.0, 0.0
    while speed > 0.0:
        if t >= reaction:
            deceleration = min(deceleration + jerk * dt, braking)
        speed, distance, t = speed - deceleration * dt, distance + speed * dt, t + dt
    return distance


@settings(max_examples=40)
@given(speed=st.floats(0.0, 15.0), reaction=st.floats(0.0, 0.6), braking=st.floats(1.0, 4.0), jerk=st.floats(1.0, 10.0))
def test_the_formula_of_the_stopping_distance_is_what_integration_gives(speed, reaction, braking, jerk):
    assert stopping_distance_m(speed, reaction, braking, jerk) == pytest.approx(
        numerically(speed, reaction, braking, jerk), abs=0.03, rel=0.005
    )


def test_the_formula_gives_the_published_distances():
    """Reference for remote driving: 150 ms of reaction; -4 m/s2 with jerk 5: 13.1 m from 30 and 31.6 m from 50 km/h."""
    assert stopping_distance_m(30 / 3.6, 0.15, 4.0, 5.0) == pytest.approx(13.1, abs=0.1)
    assert stopping_distance_m(50 / 3.6, 0.15, 4.0, 5.0) == pytest.approx(31.6, abs=0.1)
    assert stopping_distance_m(30 / 3.6, 0.15, 2.5, 1.5) == pytest.approx(21.8, abs=0.1)


@pytest.mark.parametrize("speed", [0.3, 1.0, 4.17, 6.9, 8.33, 13.9])
def test_the_car_stands_within_the_distance_the_formula_promises(speed):
    for points, braking in ((straight(200.0), 2.5), ((), 4.0)):
        gone = hypot(*stop(points, speed)[-1][:2])
        assert gone <= stopping_distance_m(speed, 0.0, braking, 5.0) + speed * DT + 0.02


@settings(max_examples=30)
@given(speed=st.floats(0.5, 12.0), length=st.floats(0.0, 60.0), angle=st.floats(-0.3, 0.3))
def test_deceleration_and_its_jerk_stay_within_their_limits_and_the_hazard_lights_are_on(speed, length, angle):
    last = 0.0
    for _, _, _, applied in stop(straight(length), speed, Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=0.0)):
        assert -4.0 - 1e-9 <= applied.acceleration_m_s2 <= 0.0
        assert abs(applied.acceleration_m_s2 - last) <= 5.0 * DT + 1e-9
        assert applied.hazard
        last = applied.acceleration_m_s2


@given(
    before=st.floats(-8.0, 2.0),
    remaining=st.sampled_from([0.0, 5.0, 30.0, 100.0]),
    speed=st.floats(0.5, 12.0),
    age=st.sampled_from([0, 2 * 10**9]),
)
def test_the_brake_is_never_let_go_faster_than_the_jerk_allows(before, remaining, speed, age):
    """Whoever braked before: taking over his braking, the stop does not jolt the car forward."""
    previous = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=before)
    corridor = Corridor(points=straight(remaining) if remaining else (), checked_ns=NOW - age)
    asked = safe_stop(previous, corridor, Odometry(), speed, NOW, DT, CAR, LIMITS)
    assert asked.acceleration_m_s2 <= 0.0
    assert asked.acceleration_m_s2 <= min(before, 0.0) + 5.0 * DT + 1e-9


def test_a_car_that_was_driven_with_throttle_drops_it_at_once():
    asked = safe_stop(Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=2.0), Corridor(), Odometry(), 5.0, NOW, DT, CAR, LIMITS)
    assert -5.0 * DT - 1e-9 <= asked.acceleration_m_s2 <= 0.0


@pytest.mark.parametrize(("radius", "speed"), [(15.0, 3.0), (-15.0, 3.0), (45.0, 6.9), (-45.0, 8.33)])
def test_along_a_curved_corridor_the_car_stops_on_it(radius, speed):
    """From straight wheels into the bend, through the gate: never 30 cm beside the corridor's line."""
    points = arc(radius, 40.0) if radius > 0 else tuple((x, -y) for x, y in arc(-radius, 40.0))
    track = stop(points, speed)
    worst = max(min(hypot(x - px, y - py) for px, py in points) for x, y, _, _ in track)
    assert worst < 0.3


@pytest.mark.parametrize("angle", [0.05, -0.05, 0.15, -0.15])
def test_without_a_corridor_the_curvature_is_held_to_the_end_and_braking_is_firm(angle):
    track = stop((), 5.0, Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=0.0))
    assert {applied.road_wheel_angle_rad for _, _, _, applied in track} == {angle}
    assert min(applied.acceleration_m_s2 for _, _, _, applied in track) == -4.0


@pytest.mark.parametrize(("speed", "length"), [(5.0, 5.2), (6.9, 9.0), (8.33, 12.0)])
def test_a_short_corridor_is_braked_for_so_that_the_car_stands_within_it(speed, length):
    """Where 4 m/s2 is enough to stop within it, the car does."""
    assert stopping_distance_m(speed, 0.0, 4.0, 5.0) < length
    assert stop(straight(length), speed)[-1][0] <= length + 0.1


def test_where_the_corridor_ends_too_soon_the_car_brakes_with_all_it_may_and_steers_straight_on():
    track = stop(straight(2.0), 8.0)
    assert min(applied.acceleration_m_s2 for _, _, _, applied in track) == -4.0
    assert all(abs(applied.road_wheel_angle_rad) < 1e-6 for _, _, _, applied in track)


def test_an_old_corridor_is_still_followed_but_braked_for_as_if_there_were_none():
    points = arc(45.0, 40.0)
    track = stop(points, 6.9, age_ns=3 * 10**9)
    assert min(applied.acceleration_m_s2 for _, _, _, applied in track) == -4.0
    assert max(min(hypot(x - px, y - py) for px, py in points) for x, y, _, _ in track) < 0.3


def test_a_stop_in_reverse_keeps_the_gear_and_brakes():
    asked = safe_stop(
        replace(Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.3), gear=Gear.REVERSE),
        Corridor(),
        Odometry(),
        -1.0,
        NOW,
        DT,
        CAR,
        LIMITS,
    )
    assert asked.gear is Gear.REVERSE
    assert asked.acceleration_m_s2 < 0.0


def test_the_limits_are_those_of_the_design():
    assert asdict(StopLimits()) == {
        "braking_m_s2": 2.5,
        "braking_max_m_s2": 4.0,
        "jerk_m_s3": 5.0,
        "blind_speed_m_s": pytest.approx(1.389, abs=1e-3),
    }


@pytest.mark.parametrize(("older_ns", "braking"), [(0, 2.5), (1, 4.0)])
def test_the_brake_is_firmer_from_the_first_moment_on_that_the_corridor_is_older_than_its_limit(older_ns, braking):
    """It brakes with 2.5 m/s2 already: it keeps to that, or goes on from there with all the jerk it may have."""
    previous = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=-2.5)
    corridor = Corridor(points=straight(200.0), checked_ns=NOW - CORRIDOR_AGE_MAX_NS - older_ns)
    asked = safe_stop(previous, corridor, Odometry(), 5.0, NOW, DT, CAR, LIMITS)
    assert asked.acceleration_m_s2 == pytest.approx(max(-braking, -2.5 - 5.0 * DT))


def test_lights_and_wipers_stay_as_they_were_and_no_indicator_says_that_it_turns():
    lit = Actuation(
        road_wheel_angle_rad=0.0,
        acceleration_m_s2=0.0,
        gear=Gear.DRIVE,
        indicators=Indicators.LEFT,
        lights=Lights.HIGH,
        wipers=Wipers.FAST,
    )
    asked = safe_stop(lit, Corridor(), Odometry(), 5.0, NOW, DT, CAR, LIMITS)
    assert (asked.indicators, asked.lights, asked.wipers) == (Indicators.OFF, Lights.HIGH, Wipers.FAST)


def test_a_corridor_cut_short_by_what_stands_in_it_is_braked_for_like_one_that_ends_there():
    previous = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=-3.0)
    long, short = (Corridor(points=straight(metres), checked_ns=NOW) for metres in (60.0, 6.0))
    cut, whole, ends = (
        safe_stop(previous, corridor, Odometry(), 6.0, NOW, DT, CAR, LIMITS, free)
        for corridor, free in ((long, 13), (long, None), (short, None))
    )
    assert cut.acceleration_m_s2 == ends.acceleration_m_s2 < whole.acceleration_m_s2


@settings(max_examples=60)
@given(distance=st.floats(0.0, 80.0), reaction=st.floats(0.0, 0.6), braking=st.floats(1.0, 4.0), jerk=st.floats(2.0, 10.0))
def test_the_speed_for_a_distance_is_the_one_that_integration_stops_from_within_it(distance, reaction, braking, jerk):
    """But for the term it leaves out: b t_j^2 / 24, 11 cm at most with the shipped limits."""
    speed = speed_for_distance_m_s(distance, reaction, braking, jerk)
    left_out = braking * (braking / jerk) ** 2 / 24
    if speed > braking**2 / jerk / 2:  # the braking builds up whole
        assert numerically(speed, reaction, braking, jerk) == pytest.approx(distance - left_out, abs=0.03, rel=0.005)
    else:
        assert numerically(speed, reaction, braking, jerk) <= distance + 0.03


@pytest.mark.parametrize("distance", [0.0, -1.0])
def test_where_there_is_no_room_no_speed_is_right(distance):
    assert speed_for_distance_m_s(distance, 0.3, 4.0, 5.0) == pytest.approx(0.0, abs=1e-12)
