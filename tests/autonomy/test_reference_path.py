"""The planner's line: on the road it was made of, smooth, with the room it was given; and what is no line is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.reference_path import lane_path, through
from wire.messages.automation import RoadMap
from wire.road import Road
from wire.scenario import find_scenario, read_map, read_scenario

ROAD = Road(read_map(read_scenario(find_scenario("closed_road"))[1]))
OWN_M = ROAD.own_lane_offset_m
PATH = lane_path(ROAD, lambda _: OWN_M, 20.0, 180.0, -3.5, 3.5)


@given(st.floats(0.0, 1.0))
def test_it_lies_on_the_lane_it_was_made_of(share: float) -> None:
    station = PATH.first_m + share * (PATH.last_m - PATH.first_m)
    x, y, heading = PATH.at(station)
    at = ROAD.to_road(x, y)
    assert abs(at.offset_m - OWN_M) < 0.02
    assert abs((at.heading_rad - heading + np.pi) % (2 * np.pi) - np.pi) < 0.02


@given(st.floats(-5.0, 170.0))
def test_a_metre_on_it_is_a_metre(station: float) -> None:
    (x0, y0, h0), (x1, y1, _) = PATH.at(station), PATH.at(station + 0.5)
    assert abs(np.hypot(x1 - x0, y1 - y0) - 0.5) < 0.01
    assert abs(np.arctan2(y1 - y0, x1 - x0) - h0) % (2 * np.pi) < 0.06


def test_its_room_is_that_of_the_road() -> None:
    assert np.allclose(PATH.room_left_m, 3.5 - OWN_M) and np.allclose(PATH.room_right_m, OWN_M + 3.5)


@pytest.mark.parametrize("points", [[], [[0, 0]], [[0, 0], [0, 0]], [[0, 0], [5, 0], [1, 0.1]], [[0, 0], [np.nan, 1]]])
def test_what_is_no_line_is_refused(points: list[list[float]]) -> None:
    places = np.array(points, float).reshape(-1, 2)
    room = np.ones(len(places))
    with pytest.raises(ValueError, match="a reference path"):
        through(places, np.zeros(len(places)), room, room)


def test_the_map_is_a_real_one() -> None:
    assert isinstance(ROAD.map, RoadMap) and ROAD.length_m > 180
