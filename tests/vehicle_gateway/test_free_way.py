"""How much of a way is free, against a plainer rule: every point looked at, the car a box that a point is clamped into."""

from math import atan2, cos, hypot, pi, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from vehicle_gateway.corridor import Corridor, Odometry, Shift
from vehicle_gateway.free_way import (
    Surroundings,
    Thing,
    free_of_corridor,
    free_points,
    held_free_m,
    held_way,
    keep_surroundings,
    moved_on,
)
from vehicle_gateway.sweep import in_reach, line_of
from wire.configuration import read_sections, shipped
from wire.messages.automation import Scene, TrackedObject
from wire.messages.vehicle import VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
FRONT, REAR, HALF = CAR.length_m - CAR.rear_overhang_m, CAR.rear_overhang_m, CAR.width_m / 2
NOW, SECOND = 10**12, 10**9
STRAIGHT = tuple((float(x), 0.0) for x in range(31))


def arc(curvature, length=30, step=1.0):
    """Points on a circle by its formula."""
    if abs(curvature) < 1e-9:
        return tuple((step * k, 0.0) for k in range(length + 1))
    turned = [curvature * step * k for k in range(length + 1)]
    return tuple((sin(a) / curvature, (1 - cos(a)) / curvature) for a in turned)


def touched(points, at, thing):
    """Whether the box of the car standing at this point, along the way, meets the circle."""
    first, second = (at, at + 1) if at + 1 < len(points) else (at - 1, at)
    heading = atan2(points[second][1] - points[first][1], points[second][0] - points[first][0])
    x, y, radius = thing
    dx, dy = x - points[at][0], y - points[at][1]
    ahead, left = dx * cos(heading) + dy * sin(heading), dy * cos(heading) - dx * sin(heading)
    return hypot(ahead - min(max(ahead, -REAR), FRONT), left - min(max(left, -HALF), HALF)) < radius


def plainly(points, begin, things):
    return next((at for at in range(begin, len(points)) if any(touched(points, at, thing) for thing in things)), len(points))


places = st.tuples(st.floats(-10.0, 45.0), st.floats(-15.0, 15.0), st.floats(0.05, 3.0))


@settings(deadline=None, max_examples=150)
@given(curvature=st.floats(-0.15, 0.15), begin=st.integers(0, 30), things=st.lists(places, max_size=6))
def test_the_free_points_are_those_of_the_plain_rule_wherever_things_stand(curvature, begin, things):
    points = arc(curvature)
    assert free_points(points, begin, things, CAR) == plainly(points, begin, things)


@settings(deadline=None, max_examples=60)
@given(
    points=st.lists(st.tuples(st.floats(-30.0, 30.0), st.floats(-30.0, 30.0)), min_size=2, max_size=12, unique=True),
    things=st.lists(places, max_size=4),
)
def test_on_any_way_however_wild_no_touched_point_is_called_free(points, things):
    assert free_points(points, 0, things, CAR) == plainly(points, 0, things)


@settings(deadline=None, max_examples=200)
@given(
    curvature=st.floats(-0.2, 0.2),
    step=st.sampled_from([0.25, 0.5, 1.0, 2.0]),
    begin=st.integers(0, 29),
    things=st.lists(places, min_size=1, max_size=6),
)
def test_what_is_out_of_reach_of_the_body_s_sweep_is_never_touched(curvature, step, begin, things):
    points = arc(curvature, step=step)
    strip = line_of(points, CAR).strip
    kept = things if strip is None else in_reach(strip, things)
    assert plainly(points, begin, kept) == plainly(points, begin, things)


def test_who_walks_two_and_a_half_metres_beside_a_straight_way_is_out_of_reach_and_a_crooked_line_says_nothing():
    strip = line_of(STRAIGHT, CAR).strip
    assert strip is not None and HALF < strip.sweep_m < 2.0
    assert in_reach(strip, [(10.0, 2.5, 0.4), (33.0, 0.0, 0.4)]) == [(33.0, 0.0, 0.4)]
    assert line_of(((0.0, 0.0), (1.0, 0.0), (0.0, 0.1)), CAR).strip is None
    assert line_of(((0.0, 0.0), (0.1, 0.0), (0.2, 0.0)), CAR).strip is None
    assert line_of((), CAR) == ((), None)
    assert line_of(((4.0, 5.0),), CAR) == ((0.0,), None)


def test_how_far_each_point_lies_along_a_way_is_the_sum_of_the_steps_before_it():
    assert line_of(((0.0, 0.0), (3.0, 4.0), (3.0, 6.0)), CAR).along_m == (0.0, 5.0, 7.0)


def test_a_way_of_one_point_near_a_thing_is_not_free_whatever_way_the_car_stands():
    assert free_points(((0.0, 0.0),), 0, [(0.0, 3.0, 0.2)], CAR) == 0
    assert free_points(((0.0, 0.0),), 0, [(0.0, 5.0, 0.2)], CAR) == 1
    assert free_points((), 0, [(0.0, 5.0, 0.2)], CAR) == 0
    assert free_points(((1.0, 1.0), (1.0, 1.0)), 0, [(50.0, 0.0, 0.2)], CAR) == 2


def test_the_bumper_touches_before_the_rear_axle_is_there():
    """A thing of 0.5 m stands 20 m ahead: the bumper, 3.6 m before the axle, may get to 19.5 m."""
    assert free_points(STRAIGHT, 0, [(20.0, 0.0, 0.5)], CAR) == 16  # points 0 to 15: the bumper at 18.6 m
    assert free_points(STRAIGHT, 0, [(20.0, HALF + 0.5, 0.499)], CAR) == 31
    assert free_points(STRAIGHT, 0, [(20.0, HALF + 0.5, 0.501)], CAR) == 17


def thing(x, y, vx=0.0, vy=0.0, deviation=0.1):
    return Thing(x_m=x, y_m=y, velocity_x_m_s=vx, velocity_y_m_s=vy, radius_m=0.3, deviation_m=deviation)


def test_a_moving_thing_is_looked_for_where_it_is_by_now_and_larger_the_longer_it_was_not_seen():
    assert moved_on([thing(10.0, -4.0, 0.0, 1.4)], 0.0) == [(10.0, -4.0, pytest.approx(0.4))]
    assert moved_on([thing(10.0, -4.0, 1.0, 1.4)], 2.0) == [(12.0, pytest.approx(-1.2), pytest.approx(1.4))]
    assert moved_on([thing(10.0, -4.0, 1.0, 1.4)], -2.0) == [(10.0, -4.0, pytest.approx(0.4))]


def test_a_person_who_walks_into_the_corridor_cuts_it_and_gives_it_back_behind_him():
    """From 4 m beside at 2 m/s, 0.3 m wide: into the car's way of 0.88 m at about 1.4 s, out of it at about 2.6 s."""
    corridor = Corridor(points=STRAIGHT, checked_ns=NOW, free=31)
    around = Surroundings(moving=(thing(20.0, -4.0, 0.0, 2.0, 0.0),), seen_ns=NOW)
    free = [free_of_corridor(corridor, around, 0, NOW + round(t * SECOND), CAR) for t in (0.0, 1.0, 1.6)]
    assert free == [31, 31, plainly(STRAIGHT, 0, moved_on(around.moving, 1.6))]
    assert free[2] < 17
    later = Surroundings(moving=(thing(20.0, 3.0, 0.0, 2.0, 0.0),), seen_ns=NOW)
    assert free_of_corridor(corridor, later, 0, NOW, CAR) == 31


def test_somebody_behind_the_car_cuts_nothing_and_what_standing_things_cut_stays_cut():
    behind = Surroundings(moving=(thing(2.0, 0.0),), seen_ns=NOW)
    assert free_of_corridor(Corridor(points=STRAIGHT, checked_ns=NOW, free=31), behind, 10, NOW, CAR) == 31
    cut = Corridor(points=STRAIGHT, checked_ns=NOW, free=12)
    assert free_of_corridor(cut, behind, 10, NOW, CAR) == 12
    assert free_of_corridor(cut, Surroundings(seen_ns=NOW), 0, NOW, CAR) == 12
    assert free_of_corridor(Corridor(), behind, 0, NOW, CAR) is None
    assert free_of_corridor(cut, behind, 25, NOW, CAR) == 12


@given(curvature=st.floats(-0.2, 0.2), heading=st.floats(-pi, pi))
def test_the_held_way_is_the_circle_of_its_curvature(curvature, heading):
    c, s = cos(heading), sin(heading)
    for (x, y), (ex, ey) in zip(held_way(Odometry(x_m=5.0, y_m=-3.0, heading_rad=heading), curvature), arc(curvature), strict=True):
        assert hypot(x - (5.0 + ex * c - ey * s), y - (-3.0 + ex * s + ey * c)) < 0.06


def test_along_the_held_way_only_what_was_looked_at_lately_is_free():
    around = Surroundings(seen_ns=NOW)
    assert held_free_m(Odometry(), 0.0, around, NOW, CAR) == 30.0
    assert held_free_m(Odometry(), 0.0, around, NOW + SECOND, CAR) == 30.0
    assert held_free_m(Odometry(), 0.0, around, NOW + SECOND + 1, CAR) is None
    assert held_free_m(Odometry(), 0.0, around, NOW - 1, CAR) is None
    assert held_free_m(Odometry(), 0.0, Surroundings(), NOW, CAR) is None


def test_the_held_way_ends_before_what_stands_or_walks_on_it():
    """A thing of 0.3 m at 20 m: the axle may get to 16.1 m, and the point before it is 16; a walker is taken as larger."""
    standing = Surroundings(standing=(thing(20.0, 0.0),), seen_ns=NOW)
    assert held_free_m(Odometry(), 0.0, standing, NOW, CAR) == 16.0
    walking = Surroundings(moving=(thing(20.0, 0.0),), seen_ns=NOW)
    assert held_free_m(Odometry(), 0.0, walking, NOW + SECOND, CAR) == 15.0
    assert held_free_m(Odometry(), 0.0, replace(standing, standing=(thing(1.0, 0.0),)), NOW, CAR) == 0.0


def test_what_the_scene_shows_is_kept_in_the_odometry_frame_and_what_is_far_off_is_not():
    """The odometry's frame is turned left by 90 degrees against the map, with the car at (7, 8)."""
    seen = TrackedObject(
        number=1,
        kind="person",
        x_m=110.0,
        y_m=50.0,
        velocity_x_m_s=1.0,
        velocity_y_m_s=0.5,
        radius_m=0.3,
        deviation_m=0.2,
        static=False,
        age_s=1.0,
    )
    others = (replace(seen, static=True, y_m=52.0), replace(seen, x_m=161.0), replace(seen, x_m=161.0, radius_m=1.1))
    scene = Scene(
        stamp_ns=NOW,
        x_m=100.0,
        y_m=50.0,
        heading_rad=0.0,
        speed_m_s=0.0,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=0.0,
        offset_m=0.0,
        objects=(seen, *others),
        plan=(),
        stopping_corridor=(),
    )
    around = keep_surroundings(scene, Shift(100.0, 50.0, 7.0, 8.0, 0.0, 1.0))
    assert around.seen_ns == NOW
    assert around.moving[0] == Thing(x_m=7.0, y_m=18.0, velocity_x_m_s=-0.5, velocity_y_m_s=1.0, radius_m=0.3, deviation_m=0.2)
    assert [(round(kept.x_m), round(kept.y_m)) for kept in (*around.moving, *around.standing)] == [(7, 18), (7, 69), (5, 18)]
