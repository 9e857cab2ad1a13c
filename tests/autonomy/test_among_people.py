"""What the topology planner is asked for a car on a road, and what its answer may not exceed: read off a straight lane."""

from dataclasses import replace

import numpy as np
import pytest

from autonomy.car_shape import car_shape
from autonomy.localization.ekf import Pose
from autonomy.perception.tracking import Track
from autonomy.planning.among_people import OUT_M, around, capped, counting, is_in_lane, lane_of, predicted, rolled, with_room_for
from autonomy.planning.among_people import car_on as placed
from autonomy.planning.braking_planner import Plan, PlanningSettings, Situation, plan
from autonomy.planning.horizon import STEP_S, STEPS, Trajectory
from tests.autonomy.seen import seen
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.road import Road
from wire.scenario import read_map

ROAD = Road(read_map(shipped("maps", "bend.toml")))  # straight for 60 m, own lane from -3.5 to 0
SHAPE = car_shape(read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"])
LANE, SETTINGS, LOW_M = lane_of(ROAD), PlanningSettings(), -3.5
NOW_NS = 1_000_000_000


def pose(x: float = 20.0, y: float = -1.75, heading: float = 0.0, speed: float = 6.0) -> Pose:
    return Pose(stamp_ns=NOW_NS, x_m=x, y_m=y, heading_rad=heading, speed_m_s=speed, yaw_rate_rad_s=0.0)


def person(x: float, y: float, vx: float = 0.0, vy: float = 0.0, number: int = 1) -> Track:
    return seen(x, y, vx, vy, number=number, stamp_ns=NOW_NS, position_variance=0.01, cross_variance=0.0)


def situation(*tracks: Track, speed: float = 6.0) -> Situation:
    return Situation(now_ns=NOW_NS, road=ROAD, shape=SHAPE, station_m=20.0, speed_m_s=speed, tracks=tracks)


def made(*tracks: Track, speed: float = 6.0) -> Plan:
    """The braking planner's second plan: only then it brakes firmly."""
    asked = situation(*tracks, speed=speed)
    return plan(asked, plan(asked, None, SETTINGS), SETTINGS)


def straight(speed: float = 6.0, acceleration: float = 0.0) -> Trajectory:
    """Along the lane from x = 20."""
    times = np.arange(STEPS + 1) * STEP_S
    states = np.zeros((STEPS + 1, 6))
    states[:, 0] = 20.0 + speed * times
    states[:, 1], states[:, 3], states[:, 5] = -1.75, speed, 20.0 + speed * times
    return Trajectory(states=states, inputs=np.zeros((STEPS, 2)), cost=1.0, feasible=True, violation=0.0)


def test_a_car_in_its_lane_gets_no_room_however_it_points() -> None:
    for heading in (-0.1, 0.0, 0.1):
        assert with_room_for(placed(LANE, pose(heading=heading), 0.0), SHAPE, LANE) is LANE


def test_a_car_that_reaches_out_of_its_lane_may_be_where_it_is_and_less_and_less_ahead() -> None:
    """Its right side is 0.63 m beyond the lane's edge; 15 m before its bumper the lane is as wide as ever."""
    car = placed(LANE, pose(y=-3.25), 0.0)
    out = with_room_for(car, SHAPE, LANE)
    more = out.room_right_m - LANE.room_right_m
    beyond = 3.25 + SHAPE.half_width_m - 3.5
    ahead_m = np.array([0.0, SHAPE.front_m + 7.5, SHAPE.front_m + 20.0])
    at = np.interp(car.station_m + ahead_m, LANE.knots_m, more)  # between knots 5 m apart it is linear
    assert at == pytest.approx([beyond + 0.05, (beyond + 0.05) / 2, 0.0], abs=0.02)
    assert (np.diff(more) <= 1e-12).all() and (out.room_left_m == LANE.room_left_m).all()


@pytest.mark.parametrize(
    ("y", "heading", "wheels", "in_lane"),
    [
        (-1.75, 0.0, 0.0, True),
        (-1.75, 0.15, 0.0, False),  # four metres on its left front corner would be 0.27 m beyond the middle of the road
        (-1.75, 0.15, -0.1, True),  # its wheels lead it back by then
        (-1.75, 0.0, 0.3, False),
        (-0.8, 0.0, 0.0, False),  # 0.08 m out
    ],
)
def test_a_car_is_in_its_lane_when_it_will_be_so_as_its_wheels_stand(
    y: float, heading: float, wheels: float, in_lane: bool
) -> None:
    assert is_in_lane(placed(LANE, pose(y=y, heading=heading), wheels), SHAPE, LANE, was=False) is in_lane
    assert is_in_lane(placed(LANE, pose(y=y, heading=heading), wheels), SHAPE, LANE, was=True)


def test_once_in_its_lane_it_may_be_a_little_beside_it() -> None:
    edge = -SHAPE.half_width_m + OUT_M
    for beyond, kept in ((-0.01, True), (0.01, False)):
        assert is_in_lane(placed(LANE, pose(y=edge + beyond), 0.0), SHAPE, LANE, was=True) is kept


@pytest.mark.parametrize("wheels", [-0.4, -1e-9, 0.0, 0.2])
def test_a_car_rolls_on_an_arc_of_its_wheels_radius(wheels: float) -> None:
    """The second rule: a thousand straight pieces."""
    start = placed(LANE, pose(heading=0.1), wheels)
    x, y, heading, piece = start.x_m, start.y_m, start.heading_rad, 4.0 / 1000
    for _ in range(1000):
        x, y, heading = (
            x + piece * np.cos(heading),
            y + piece * np.sin(heading),
            heading + piece * np.tan(wheels) / SHAPE.wheelbase_m,
        )
    end = rolled(start, SHAPE, 4.0)
    assert (end.x_m, end.y_m, end.heading_rad) == pytest.approx((x, y, heading), abs=0.005)


def test_beside_its_lane_nothing_is_asked() -> None:
    assert around(made(), situation(), pose(y=-0.6), 0.0, LANE, SETTINGS) is None
    assert around(made(), situation(), pose(y=-0.6), 0.0, LANE, SETTINGS, straight()) is None


def test_people_who_walk_go_on_to_the_end_of_the_horizon_and_grow_less_certain() -> None:
    """Tracks are predicted for 4 s, plans reach 7 s: whoever was not there would be free room."""
    found = predicted(made(), situation(person(35.0, -5.0, 0.0, 0.5)))
    assert found.positions_m[-1, 0] == pytest.approx((35.0, -5.0 + 0.5 * STEPS * STEP_S))
    deviations = np.sqrt(found.covariances_m2[:, 0, 0, 0])
    assert deviations[0] == pytest.approx(0.1)
    assert deviations[-1] == pytest.approx(np.sqrt(0.01 + (0.3 * STEP_S) ** 2 * STEPS))


def test_a_cyclist_who_comes_round_the_bend_is_predicted_on_his_own_line_and_not_across_the_lane() -> None:
    """From 82 m on the road, 1 m left of its middle, at 4 m/s: 28 m farther down when the horizon ends."""
    x, y, heading = ROAD.to_world(82.0, 1.0)
    cyclist = person(x, y, -4.0 * np.cos(heading), -4.0 * np.sin(heading))
    asked = around(made(), situation(cyclist), pose(), 0.0, LANE, SETTINGS)
    assert asked is not None and asked.predictions is not None and asked.predictions.numbers == (1,)
    at = [ROAD.to_road(px, py) for px, py in asked.predictions.positions_m[:, 0].tolist()]
    assert [place.offset_m for place in at] == pytest.approx([1.0] * (STEPS + 1), abs=0.02)
    assert at[-1].station_m == pytest.approx(60.0 - (28.0 - 22.0 * (1.0 - 1.0 * 0.0222)), abs=0.1)
    straight_on = predicted(made(), situation(cyclist)).positions_m[-1, 0]
    assert ROAD.to_road(*straight_on.tolist()).offset_m < LOW_M  # through the lane and out of it at the kerb


def test_whoever_stands_in_the_way_has_a_stop_instead_and_whoever_is_far_from_it_is_left_out() -> None:
    standing, walking, far = person(40.0, -1.75), person(45.0, -4.5, 0.0, 0.8, number=2), person(45.0, 9.0, number=3)
    asked = made(standing, walking, far)
    assert predicted(asked, situation(standing, walking, far)).numbers == (2,)
    assert [stop.cause for stop in counting(asked, SETTINGS)] == ["goal", "standing"]


def test_who_walks_counts_as_a_stop_only_when_firm_braking_alone_avoids_them() -> None:
    far, near = person(50.0, -3.0, 0.0, 0.5), person(33.0, -3.0, 0.0, 0.5)
    assert [stop.cause for stop in counting(made(far), SETTINGS)] == ["goal"]
    assert [stop.cause for stop in counting(made(near), SETTINGS)] == ["goal", "person"]


@pytest.mark.parametrize(
    ("x", "speed", "wheels", "expected"),
    [(20.7, 6.1, 0.02, 20.6), (20.55, 5.9, 0.02, 20.6), (20.9, 6.1, 0.02, 20.9), (20.6, 6.5, 0.02, 20.6), (20.7, 6.1, 0.06, 20.7)],
)
def test_a_plan_begins_where_the_last_one_expected_the_car_unless_it_is_elsewhere(
    x: float, speed: float, wheels: float, expected: float
) -> None:
    """A tenth of a second at 6 m/s after 20 m."""
    asked = around(made(), situation(), pose(x=x, speed=speed), wheels, LANE, SETTINGS, straight())
    assert asked.car.x_m == pytest.approx(expected)
    near = abs(x - 20.6) < 0.15 and abs(speed - 6.0) < 0.3 and abs(wheels) < 0.05
    assert (asked.car.speed_m_s, asked.car.road_wheel_angle_rad) == pytest.approx((6.0, 0.0) if near else (speed, wheels))


@pytest.mark.parametrize(("passed_s", "expected"), [(0.1, 20.6), (0.25, 21.5), (0.3, 21.8)])
def test_after_a_plan_that_came_late_the_car_is_expected_farther_on(passed_s: float, expected: float) -> None:
    asked = around(made(), situation(), pose(x=expected + 0.1, speed=6.1), 0.0, LANE, SETTINGS, straight(), passed_s)
    assert asked.car.x_m == pytest.approx(expected)


def test_without_a_last_plan_or_after_one_that_was_not_feasible_it_begins_as_measured() -> None:
    for before in (None, replace(straight(), feasible=False)):
        assert around(made(), situation(), pose(x=20.55), 0.02, LANE, SETTINGS, before).car.x_m == 20.55


def test_no_planned_speed_is_above_the_ceiling_of_its_place() -> None:
    """Who stands at 40 m: bumper 2.5 m before them, so the rear axle stops at 37.2 m less the car's front."""
    asked = made(person(40.0, -1.75))
    states = capped(straight(), asked, ROAD, SETTINGS).states
    stop_m = 40.0 - 0.3 - SETTINGS.person_gap_m - SHAPE.front_m
    assert (states[states[:, 0] >= stop_m, 3] == 0.0).all()
    before = states[states[:, 0] < stop_m]
    assert (before[:, 3] <= np.sqrt(2 * SETTINGS.moderate_m_s2 * (stop_m - before[:, 0])) + 1e-9).all()
    assert before[0, 3] > 5.0
