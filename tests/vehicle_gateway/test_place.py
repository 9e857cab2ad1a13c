"""The car's place between two scenes, against a drive in small steps in the map frame."""

from math import cos, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.corridor import Odometry, advance
from vehicle_gateway.place import Fix, PlaceLimits, fix_of, place_of
from wire.messages.automation import Scene

LIMITS = PlaceLimits()
S = 1_000_000_000
SCENE = Scene(
    stamp_ns=50 * S,
    x_m=100.0,
    y_m=-20.0,
    heading_rad=2.0,
    speed_m_s=5.0,
    yaw_rate_rad_s=0.0,
    deviation_m=0.2,
    station_m=0.0,
    offset_m=0.0,
    objects=(),
    plan=(),
    stopping_corridor=(),
)


def moved(x, y, heading, speed, yaw_rate, seconds, steps=200):
    """The plainer rule: small steps in the map frame."""
    dt = seconds / steps
    for _ in range(steps):
        middle = heading + yaw_rate * dt / 2
        x, y, heading = x + speed * dt * cos(middle), y + speed * dt * sin(middle), heading + yaw_rate * dt
    return x, y, heading


@settings(max_examples=40, deadline=None)
@given(
    start=st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3, 3)),
    speed=st.floats(-2, 8),
    yaw_rate=st.floats(-0.5, 0.5),
    late_s=st.floats(0.0, 0.1),
    after_s=st.floats(0.0, 1.5),
)
def test_the_pose_is_carried_on_from_the_moment_it_was_valid_for(start, speed, yaw_rate, late_s, after_s):
    odometry = Odometry(x_m=start[0], y_m=start[1], heading_rad=start[2])
    arrived_ns = SCENE.stamp_ns + round(late_s * S)
    fix = fix_of(SCENE, odometry, speed, yaw_rate, arrived_ns)
    for _ in range(100):
        odometry = advance(odometry, speed, yaw_rate, after_s / 100)
    place = place_of(fix, odometry, arrived_ns + round(after_s * S), LIMITS)
    x, y, heading = moved(100.0, -20.0, 2.0, speed, yaw_rate, late_s + after_s)
    assert place is not None
    assert (place.x_m, place.y_m) == (pytest.approx(x, abs=0.01), pytest.approx(y, abs=0.01))
    assert cos(place.heading_rad - heading) == pytest.approx(1.0)
    assert place.age_s == pytest.approx(late_s + after_s, abs=1e-6)
    assert place.deviation_m >= 0.2 + 0.03 * abs(speed) * after_s * 0.7


def test_there_is_no_place_before_the_first_scene_nor_long_after_the_last():
    fix = fix_of(SCENE, Odometry(), 0.0, 0.0, SCENE.stamp_ns)
    assert place_of(Fix(), Odometry(), 50 * S, LIMITS) is None
    assert place_of(fix, Odometry(), 53 * S, LIMITS) is not None
    assert place_of(fix, Odometry(), 53 * S + 1, LIMITS) is None


def test_a_doubtful_place_is_none():
    fix = fix_of(replace(SCENE, deviation_m=0.7), Odometry(), 0.0, 0.0, SCENE.stamp_ns)
    assert place_of(fix, Odometry(x_m=9.9), 51 * S, LIMITS) is not None
    assert place_of(fix, Odometry(x_m=10.1), 51 * S, LIMITS) is None  # 0.7 m and 3 % of ten metres
    assert place_of(replace(fix, deviation_m=1.01), Odometry(), 51 * S, LIMITS) is None


def test_a_turned_frame_is_turned_back():
    fix = fix_of(replace(SCENE, heading_rad=pi / 2), Odometry(), 0.0, 0.0, SCENE.stamp_ns)
    place = place_of(fix, Odometry(x_m=3.0), 51 * S, LIMITS)
    assert place is not None
    assert (place.x_m, place.y_m) == (pytest.approx(100.0), pytest.approx(-17.0))
