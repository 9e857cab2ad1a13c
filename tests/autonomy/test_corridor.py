"""The stopping corridor: every point is checked again here, corner by corner and thing by thing."""

from math import atan, cos, hypot, sin

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.car_shape import car_shape
from autonomy.localization.ekf import Pose
from autonomy.planning.corridor import Circle, stopping_corridor
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.road import Road
from wire.scenario import read_map

SHAPE = car_shape(read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"])
ROAD = Road(read_map(shipped("maps", "bend.toml")))


def at(station: float, offset: float, turn: float = 0.0, speed: float = 5.0) -> Pose:
    x, y, heading = ROAD.to_world(station, offset)
    return Pose(stamp_ns=0, x_m=x, y_m=y, heading_rad=heading + turn, speed_m_s=speed, yaw_rate_rad_s=0.0)


def corners(point: tuple[float, float], ahead: tuple[float, float]) -> list[tuple[float, float]]:
    dx, dy = ahead[0] - point[0], ahead[1] - point[1]
    c, s = dx / hypot(dx, dy), dy / hypot(dx, dy)
    return [(point[0] + c * along - s * side, point[1] + s * along + c * side) for along in (3.6, -0.9) for side in (0.88, -0.88)]


@settings(max_examples=60, deadline=None)
@given(station=st.floats(10.0, 180.0), offset=st.floats(-2.3, 2.3), turn=st.floats(-0.3, 0.3), angle=st.floats(-0.3, 0.3))
def test_the_whole_car_stays_on_the_road(station: float, offset: float, turn: float, angle: float) -> None:
    points = stopping_corridor(at(station, offset, turn), angle, ROAD, SHAPE, [], station)
    for point, after in zip(points, points[1:], strict=False):
        assert hypot(after[0] - point[0], after[1] - point[1]) == pytest.approx(1.0, abs=0.01)
        for corner in corners(point, after):
            assert abs(ROAD.to_road(*corner, station).offset_m) < 3.5


@pytest.mark.parametrize("offset", [-1.75, 1.75])
def test_in_either_lane_it_runs_on_along_the_bend(offset: float) -> None:
    bend = atan(2.7 * 0.0222 / (1 - 0.0222 * offset))
    points = stopping_corridor(at(70.0, offset), bend, ROAD, SHAPE, [], 70.0)
    assert len(points) == 31
    assert all(abs(ROAD.to_road(*point, 70.0).offset_m - offset) < 0.4 for point in points)


def test_it_ends_before_a_thing_in_its_way() -> None:
    x, y, _ = ROAD.to_world(30.0, -1.75)
    points = stopping_corridor(at(10.0, -1.75), 0.0, ROAD, SHAPE, [Circle(x, y, 0.3)], 10.0)
    last = ROAD.to_road(*points[-1]).station_m
    assert 30.0 - 0.3 - 3.6 - 0.7 - 1.0 <= last <= 30.0 - 0.3 - 3.6 - 0.7


def test_beside_a_site_in_the_own_lane_the_oncoming_lane_is_free_to_stop_in() -> None:
    cones = [Circle(*ROAD.to_world(150.0 + 3 * i, -0.35)[:2], 0.2) for i in range(7)]
    assert len(stopping_corridor(at(145.0, 1.75), 0.0, ROAD, SHAPE, cones, 145.0)) == 31
    assert len(stopping_corridor(at(145.0, -1.0), 0.0, ROAD, SHAPE, cones, 145.0)) < 12


def test_a_car_against_a_thing_has_no_corridor() -> None:
    pose = at(20.0, -1.75)
    touching = Circle(pose.x_m + 3.7 * cos(pose.heading_rad), pose.y_m + 3.7 * sin(pose.heading_rad), 0.3)
    assert stopping_corridor(pose, 0.0, ROAD, SHAPE, [touching], 20.0) == ()
