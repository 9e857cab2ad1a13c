"""Road geometry against a path walked in small steps, and there and back between road and world."""

from math import atan2, cos, hypot, pi, sin

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from wire.configuration import shipped
from wire.messages.automation import RoadMap, RoadSegment
from wire.road import Road, wrap_angle
from wire.scenario import read_map

CURVATURES = st.one_of(st.just(0.0), st.floats(-0.05, 0.05))
SEGMENTS = st.lists(st.builds(RoadSegment, length_m=st.floats(1.0, 40.0), curvature_1_m=CURVATURES), min_size=1, max_size=4)


def road_of(segments, start=(0.0, 0.0), heading=0.0, side="right") -> Road:
    return Road(
        RoadMap(
            name="r",
            start=start,
            start_heading_rad=heading,
            segments=tuple(segments),
            lane_width_m=3.5,
            sidewalk_width_m=2.0,
            drives_on=side,
            speed_limit_m_s=7.0,
            goal_station_m=1.0,
        )
    )


def walked(road: Road, station: float, steps: int = 4000) -> tuple[float, float, float]:
    """The centre line by turning a little and going a little, over and over."""
    (x, y), heading, left = road.map.start, road.map.start_heading_rad, station
    for segment in road.map.segments:
        length = min(segment.length_m, left)
        step = length / steps
        for _ in range(steps):
            heading += segment.curvature_1_m * step / 2
            x, y = x + step * cos(heading), y + step * sin(heading)
            heading += segment.curvature_1_m * step / 2
        left -= length
    return x, y, heading


@settings(max_examples=15, deadline=None)
@given(
    segments=SEGMENTS,
    part=st.floats(0.0, 1.0),
    start=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)),
    heading=st.floats(-3.0, 3.0),
)
def test_the_centre_line_is_where_small_steps_lead(segments, part, start, heading):
    road = road_of(segments, start, heading)
    station = part * road.length_m
    x, y, direction = road.to_world(station)
    wx, wy, wdirection = walked(road, station, 1000)
    assert hypot(x - wx, y - wy) < 1e-3
    assert abs(wrap_angle(direction - wdirection)) < 1e-6


@given(segments=SEGMENTS, part=st.floats(0.0, 1.0), offset=st.floats(-8.0, 8.0))
def test_from_the_road_to_the_world_and_back(segments, part, offset):
    turn = sum(abs(each.length_m * each.curvature_1_m) for each in segments)
    assume(turn < 1.5)  # a road that comes back to itself has no one answer
    road = road_of(segments)
    station = part * road.length_m
    x, y, heading = road.to_world(station, offset)
    back = road.to_road(x, y)
    assert back.station_m == pytest.approx(station, abs=1e-4)
    assert back.offset_m == pytest.approx(offset, abs=1e-4)
    assert abs(wrap_angle(back.heading_rad - heading)) < 1e-5


def test_every_metre_of_long_pieces_beside_short_ones_is_found_again():
    bends = ((100.0, 0.0), (2.0, 0.1), (90.0, 0.01), (3.0, 0.0), (100.0, -0.01))
    road = road_of([RoadSegment(length_m=length, curvature_1_m=curvature) for length, curvature in bends], (5e3, -5e3), 1.0)
    for station in range(296):
        x, y, _ = road.to_world(station, 1.0 - station % 3)
        assert road.to_road(x, y)[:2] == pytest.approx((station, 1.0 - station % 3), abs=1e-6)


@example(
    segments=[RoadSegment(length_m=22.0), RoadSegment(length_m=32.0, curvature_1_m=0.05)], x=21.0, y=21.0
)  # near a bend's centre
@given(segments=SEGMENTS, x=st.floats(-100.0, 150.0), y=st.floats(-100.0, 100.0))
def test_no_point_of_the_centre_line_is_closer_than_the_one_that_is_given(segments, x, y):
    road = road_of(segments)
    found = road.to_road(x, y)
    px, py, _ = road.to_world(min(max(found.station_m, 0.0), road.length_m))
    closest = min(hypot(x - cx, y - cy) for cx, cy, _ in (road.to_world(road.length_m * k / 300) for k in range(301)))
    assert hypot(x - px, y - py) <= closest + 1e-6


@given(beyond=st.floats(0.1, 50.0), offset=st.floats(-5.0, 5.0))
def test_beyond_its_ends_the_road_goes_straight_on(beyond, offset):
    road = road_of([RoadSegment(length_m=20.0), RoadSegment(length_m=20.0, curvature_1_m=0.03)])
    ex, ey, heading = road.to_world(40.0)
    x, y, end_heading = road.to_world(40.0 + beyond, offset)
    assert end_heading == heading
    assert (x, y) == pytest.approx(
        (ex + beyond * cos(heading) - offset * sin(heading), ey + beyond * sin(heading) + offset * cos(heading))
    )
    assert road.to_road(x, y).station_m == pytest.approx(40.0 + beyond)
    x, y, _ = road.to_world(-beyond, offset)
    assert (x, y) == pytest.approx((-beyond, offset))
    assert road.to_road(x, y) == pytest.approx((-beyond, offset, 0.0))


def test_left_is_positive_and_the_own_lane_lies_on_the_side_that_is_driven_on():
    right, left = (road_of([RoadSegment(length_m=50.0)], side=side) for side in ("right", "left"))
    assert right.to_world(10.0, 1.0)[:2] == pytest.approx((10.0, 1.0))
    assert (right.own_lane_offset_m, left.own_lane_offset_m) == (-1.75, 1.75)
    assert right.half_width_m == 3.5


def test_the_bend_of_the_map_we_ship_turns_60_degrees_to_the_left_and_its_mirror_to_the_right():
    bend, mirror = (Road(read_map(shipped("maps", f"{name}.toml"))) for name in ("bend", "bend_mirrored"))
    for station in range(0, 261, 10):
        x, y, heading = bend.to_world(station, 1.0)
        mx, my, mirrored = mirror.to_world(station, -1.0)
        assert (mx, my, mirrored) == pytest.approx((x, -y, -heading))
        assert bend.curvature_1_m(station) == -mirror.curvature_1_m(station)
    assert bend.to_world(200.0)[2] == pytest.approx(47.0 * 0.0222)
    assert bend.length_m == 260.0


def test_a_hint_finds_the_right_part_of_a_road_that_comes_near_itself():
    """A hairpin: out, half a circle of 10 m radius, and back 20 m beside itself."""
    road = road_of([RoadSegment(length_m=200.0), RoadSegment(length_m=pi * 10.0, curvature_1_m=0.1), RoadSegment(length_m=200.0)])
    x, y, _ = road.to_world(20.0, 11.0)
    assert road.to_road(x, y).station_m > 200.0  # the way back is nearer
    assert road.to_road(x, y, near_station_m=20.0) == pytest.approx((20.0, 11.0, 0.0))


@given(st.floats(-100.0, 100.0))
def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn(angle):
    wrapped = wrap_angle(angle)
    assert -pi - 1e-9 <= wrapped <= pi + 1e-9
    assert (cos(wrapped), sin(wrapped)) == pytest.approx((cos(angle), sin(angle)), abs=1e-9)
    assert abs(atan2(sin(angle), cos(angle)) - wrapped) % (2 * pi) == pytest.approx(0.0, abs=1e-6) or abs(wrapped) > pi - 1e-6


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_three_quarters_of_a_roundabout_are_found_all_the_way_round(side):
    radius = 20.0
    road = road_of([RoadSegment(length_m=1.5 * pi * radius, curvature_1_m=side / radius)])
    for station in (0.0, 10.0, pi * radius - 1.0, pi * radius + 1.0, 80.0, 94.0):
        for offset in (-3.0, 0.0, 3.0):
            point = road.to_road(*road.to_world(station, offset)[:2])
            assert (point.station_m, point.offset_m) == pytest.approx((station, offset), abs=1e-6)
