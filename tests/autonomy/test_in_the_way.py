"""Who is in the way and what closes the lane, on a straight road: the answers are read off a sketch."""

from math import inf

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.perception.prediction import OnRoad, deviation_after, on_road
from autonomy.planning.blockage import closed_by, in_lane, lateral_room
from autonomy.planning.occupancy import occupancy
from autonomy.planning.route import own_lane
from tests.autonomy.seen import seen
from wire.configuration import shipped
from wire.road import Road
from wire.scenario import read_map

ROAD = Road(read_map(shipped("maps", "bend.toml")))  # straight for 60 m, own lane from -3.5 to 0
LANE = own_lane(ROAD)
LOW, HIGH = -1.75 - 1.38, -1.75 + 1.38
HALF = 0.88


def thing(
    x: float, y: float, vx: float = 0.0, vy: float = 0.0, radius: float = 0.3, kind: str = "person", number: int = 1
) -> OnRoad:
    return on_road(seen(x, y, vx, vy, kind, number, radius_m=radius), ROAD, 20.0)


@given(speed=st.floats(-1.6, 1.6), side=st.sampled_from([-4.8, 4.7]), drift=st.floats(-0.25, 0.25))
def test_whoever_walks_along_the_sidewalk_is_not_in_the_way(speed: float, side: float, drift: float) -> None:
    assert occupancy(thing(30.0, side, speed, drift), LOW, HIGH, ROAD.half_width_m) is None


@pytest.mark.parametrize(("y", "vy"), [(-4.8, 1.4), (-4.8, 0.8), (3.0, -1.4), (4.0, -2.5)])
def test_whoever_turns_towards_the_lane_is_in_it_when_they_get_there(y: float, vy: float) -> None:
    stay = occupancy(thing(30.0, y, 0.0, vy), LOW, HIGH, ROAD.half_width_m)
    gap = (LOW - 0.3 - y) if y < 0 else (y - HIGH - 0.3)
    assert stay is not None
    assert gap / abs(vy) - 1.0 < stay.from_s <= gap / abs(vy)  # a little early, for the doubt about where and how fast
    assert stay.until_s == pytest.approx((gap + HIGH - LOW + 0.6) / abs(vy))


def test_whoever_stands_in_the_lane_stays_and_whoever_leaves_is_soon_gone() -> None:
    standing = occupancy(thing(30.0, -1.75), LOW, HIGH, ROAD.half_width_m)
    leaving = occupancy(thing(30.0, -3.2, 0.0, -1.4), LOW, HIGH, ROAD.half_width_m)
    left = occupancy(thing(30.0, -3.8, 0.0, -1.4), LOW, HIGH, ROAD.half_width_m)
    assert standing is not None and standing.from_s == 0.0 and standing.until_s == inf
    assert leaving is not None and leaving.until_s == pytest.approx((LOW - 0.3 + 3.2) / -1.4)
    assert left is None


def test_a_prediction_follows_the_bend() -> None:
    x, y, heading = ROAD.to_world(80.0, -4.8)  # radius 45 m to the left
    walker = on_road(thing(x, y).track, ROAD, 80.0)
    assert walker.station_m == pytest.approx(80.0)
    assert walker.offset_m == pytest.approx(-4.8)
    assert heading > 0.4
    assert deviation_after(walker.track, 4.0) > 3 * deviation_after(walker.track, 1.0) > 0.0


def cone(x: float, y: float, number: int = 1) -> OnRoad:
    return thing(x, y, radius=0.2, kind="cone", number=number)


def test_a_cone_at_the_kerb_leaves_room_and_a_row_across_does_not() -> None:
    assert lateral_room([cone(30.0, -3.3)], LANE, HALF, 0.3) == 0.0
    beside = lateral_room([cone(30.0, -2.7)], LANE, HALF, 0.3)
    assert beside is not None and beside == pytest.approx(0.5)  # -2.7 + 0.2 + 0.3 + 0.88 = -1.32; the step is 0.1
    assert lateral_room([cone(30.0, -1.75)], LANE, HALF, 0.3) is None
    row = [cone(30.0, -3.0, 1), cone(33.0, -2.0, 2), cone(36.0, -1.0, 3)]
    closed = closed_by(row, LANE, HALF, 0.3)
    assert closed is not None
    assert closed.station_m == pytest.approx(29.8) and closed.numbers == (1, 2, 3)


def test_a_far_group_behind_a_passable_cone_is_what_closes_the_lane() -> None:
    row = [cone(20.0, -3.3, 1), cone(40.0, -1.75, 2)]
    closed = closed_by(row, LANE, HALF, 0.3)
    assert closed is not None and closed.numbers == (2,)


def test_things_beside_the_lane_or_behind_the_car_are_not_in_it() -> None:
    things = [cone(30.0, 1.0), cone(30.0, -4.0), cone(5.0, -1.0), cone(30.0, -1.0)]
    assert [found.offset_m for found in in_lane(things, LANE, 10.0, 100.0)] == [pytest.approx(-1.0)]
