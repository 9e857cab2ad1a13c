"""The corridor in the odometry frame: where its points are seen from the car, and how a car that follows it stays on it."""

from math import cos, hypot, pi, sin, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.corridor import Corridor, Odometry, advance, keep_corridor, nearest, pursue, remaining_m, usable_from
from vehicle_gateway.place import fix_of, shift_of
from wire.configuration import read_sections, shipped
from wire.messages.automation import Scene
from wire.messages.vehicle import VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
WHEELBASE = 2.7
NOW = 10**12


def seen_from(x, y, heading, point):
    """A point in the frame of a car at this pose."""
    dx, dy = point[0] - x, point[1] - y
    return dx * cos(heading) + dy * sin(heading), -dx * sin(heading) + dy * cos(heading)


def on_circle(speed, yaw_rate, t, x=0.0, y=0.0, heading=0.0, steps=2000):
    """Where a car gets in t seconds, in many small straight steps."""
    for _ in range(steps):
        heading += yaw_rate * t / steps / 2
        x, y = x + speed * t / steps * cos(heading), y + speed * t / steps * sin(heading)
        heading += yaw_rate * t / steps / 2
    return x, y, heading


def scene(x, y, heading, corridor, stamp_ns=NOW):
    return Scene(
        stamp_ns=stamp_ns,
        x_m=x,
        y_m=y,
        heading_rad=heading,
        speed_m_s=0.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=0.0,
        offset_m=0.0,
        objects=(),
        plan=(),
        stopping_corridor=corridor,
    )


@given(speed=st.floats(0.0, 15.0), yaw_rate=st.floats(-0.8, 0.8), seconds=st.floats(0.1, 3.0))
def test_dead_reckoning_follows_a_circle(speed, yaw_rate, seconds):
    odometry = Odometry()
    for _ in range(300):
        odometry = advance(odometry, speed, yaw_rate, seconds / 300)
    x, y, heading = on_circle(speed, yaw_rate, seconds)
    assert hypot(odometry.x_m - x, odometry.y_m - y) < 0.01
    assert odometry.heading_rad == pytest.approx(heading, abs=1e-9)


@given(
    speed=st.floats(0.0, 12.0),
    yaw_rate=st.floats(-0.5, 0.5),
    age_ms=st.integers(0, 300),
    heading=st.floats(-3.1, 3.1),
    point=st.tuples(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0)),
    start=st.tuples(st.floats(-500.0, 500.0), st.floats(-3.1, 3.1)),
)
def test_a_point_of_the_scene_is_seen_from_the_car_where_it_really_is(speed, yaw_rate, age_ms, heading, point, start):
    """The scene is old by the time it arrives, and the odometry's frame has nothing to do with the map's."""
    then = (120.0, -40.0, heading)
    truth = on_circle(speed, yaw_rate, age_ms / 1000.0, *then)
    odometry = Odometry(x_m=start[0], y_m=-start[0] / 2, heading_rad=start[1])
    seen = scene(*then, (point,), NOW - age_ms * 1_000_000)
    kept = keep_corridor(seen, shift_of(fix_of(seen, odometry, speed, yaw_rate, NOW)), CAR)
    assert len(kept.points) == 1
    found = seen_from(odometry.x_m, odometry.y_m, odometry.heading_rad, kept.points[0])
    assert found == pytest.approx(seen_from(*truth, point), abs=0.02 + 0.01 * hypot(*point) * abs(yaw_rate))


def drive_along(points, speed, steps, x=0.0, y=0.0, heading=0.0, rate=0.6):
    """A bicycle with a steering rate, following the corridor; its greatest distance from the corridor's line."""
    corridor, worst, angle = Corridor(points=points, checked_ns=NOW), 0.0, 0.0
    for _ in range(steps):
        found = pursue(corridor, Odometry(x_m=x, y_m=y, heading_rad=heading), speed, WHEELBASE)
        if found is None:
            break
        angle += min(max(found.road_wheel_angle_rad - angle, -rate * 0.01), rate * 0.01)
        x, y = x + speed * 0.01 * cos(heading), y + speed * 0.01 * sin(heading)
        heading += speed * tan(angle) / WHEELBASE * 0.01
        worst = max(worst, min(hypot(x - px, y - py) for px, py in points))
    return worst


def bend(radius, straight_m=8.0, side=1.0, spacing=0.2):
    """A straight, then an arc of 90 degrees; to the left with side 1."""
    line = [(spacing * k, 0.0) for k in range(int(straight_m / spacing))]
    turns = int(radius * pi / 2 / spacing)
    return tuple(
        line + [(straight_m + radius * sin(a), side * radius * (1 - cos(a))) for a in (k * spacing / radius for k in range(turns))]
    )


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius", "speed"), [(15.0, 3.0), (45.0, 6.9), (45.0, 8.33)])
def test_a_car_that_follows_the_corridor_round_a_bend_stays_within_30_cm_of_it(radius, speed, side):
    assert drive_along(bend(radius, side=side), speed, 700) < 0.3


def test_a_car_beside_the_corridor_comes_back_to_it():
    line = tuple((0.5 * k, 0.0) for k in range(200))
    x, y, heading, angle = 0.0, 0.8, 0.0, 0.0
    for _ in range(600):
        found = pursue(Corridor(points=line, checked_ns=NOW), Odometry(x_m=x, y_m=y, heading_rad=heading), 6.0, WHEELBASE)
        assert found is not None
        angle += min(max(found.road_wheel_angle_rad - angle, -0.006), 0.006)
        x, y, heading = x + 0.06 * cos(heading), y + 0.06 * sin(heading), heading + 0.06 * tan(angle) / WHEELBASE
        assert -0.2 < y < 0.81
    assert abs(y) < 0.05


def test_what_remains_of_the_corridor_is_measured_along_it_and_ends_with_it():
    line = tuple((float(k), 0.0) for k in range(21))
    corridor = Corridor(points=line, checked_ns=NOW)
    for x, expected in ((0.0, 20.0), (7.5, 12.5), (19.9, 0.1)):
        found = pursue(corridor, Odometry(x_m=x), 5.0, WHEELBASE)
        assert found is not None
        assert found.remaining_m == pytest.approx(expected)
        assert found.road_wheel_angle_rad == 0.0
    assert pursue(corridor, Odometry(x_m=20.1), 5.0, WHEELBASE) is None
    assert pursue(Corridor(), Odometry(), 5.0, WHEELBASE) is None


@given(
    points=st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), max_size=10),
    heading=st.floats(-10.0, 10.0),
    speed=st.floats(-2.0, 30.0),
)
def test_no_corridor_asks_for_more_than_a_right_angle_or_for_no_number(points, heading, speed):
    found = pursue(Corridor(points=tuple(points), checked_ns=NOW), Odometry(heading_rad=heading), speed, WHEELBASE)
    if found is not None:
        assert abs(found.road_wheel_angle_rad) < pi / 2
        assert 0.0 < found.remaining_m < 1e5


def test_a_corridor_guides_nobody_when_it_is_old_beside_the_car_behind_its_back_or_empty():
    ahead = Corridor(points=tuple((float(x), 0.0) for x in range(30)), checked_ns=NOW)
    assert usable_from(ahead, Odometry(), 5.0, NOW + 5 * 10**9) == 0
    assert usable_from(ahead, Odometry(), 5.0, NOW + 7 * 10**9) is None
    assert usable_from(ahead, Odometry(x_m=3.6, y_m=1.4), 5.0, NOW) == 4
    assert usable_from(ahead, Odometry(x_m=3.6, y_m=1.6), 5.0, NOW) is None
    assert usable_from(ahead, Odometry(), -0.5, NOW) is None
    assert usable_from(Corridor(points=(), checked_ns=NOW), Odometry(), 5.0, NOW) is None


@given(speed=st.floats(0.0, 10.0), gone=st.floats(0.0, 35.0), beside=st.floats(-1.0, 1.0), free=st.none() | st.integers(0, 31))
def test_what_remains_is_found_about_the_car_as_it_is_by_looking_at_every_point(speed, gone, beside, free):
    seen = scene(0.0, 0.0, 0.0, bend(30.0, spacing=1.0))
    corridor = keep_corridor(seen, shift_of(fix_of(seen, Odometry(), 0.0, 0.0, NOW)), CAR)
    here = Odometry(x_m=min(gone, 8.0), y_m=beside) if gone < 8.0 else Odometry(x_m=gone, y_m=30.0 * (1 - cos((gone - 8.0) / 30.0)))
    found = pursue(corridor, here, speed, WHEELBASE, free)
    at, _ = nearest(corridor, here)
    left_m = remaining_m(corridor, here, at, free)
    assert (found is None) == (left_m is None)
    if found is not None:
        assert left_m == pytest.approx(found.remaining_m, abs=1e-6)
        assert remaining_m(replace(corridor, along_m=()), here, at, free) == left_m  # as an older recording has it
