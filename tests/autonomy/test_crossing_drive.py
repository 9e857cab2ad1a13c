"""A drive through a crossing: the verdict is the world's, not the planner's."""

from dataclasses import replace

import numpy as np
import pytest

from autonomy.car_shape import CarShape
from autonomy.planning.crossings.drive import LAG_S, Asked, drive, is_hidden, predictions
from autonomy.planning.crossings.people import at_start
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.horizon import STEP_S, STEPS, CarState

CAR = CarShape(front_m=3.85, rear_m=0.95, half_width_m=1.0, wheelbase_m=2.79, road_wheel_angle_max_rad=0.55, braking_max_m_s2=8.0)
START = CarState(x_m=0.0, y_m=0.0, heading_rad=0.0, speed_m_s=0.5, road_wheel_angle_rad=0.0, station_m=0.0)


def world(name: str, seed: int = 3):
    return world_of(read_crossing(find_crossing(name))[0], seed)


def towards(speed_m_s: float):
    """Straight on, or rather: keeps the speed and never steers."""
    return lambda seen: Asked(2.0 * (speed_m_s - seen.car.speed_m_s), 0.0)


def test_a_car_that_stands_times_out_and_nobody_is_hurt() -> None:
    verdict, moments = drive(world("crossers_2"), CAR, towards(0.0))
    assert verdict.timed_out and not verdict.collided
    assert verdict.duration_s == pytest.approx(40.0, abs=0.1)
    assert len(moments) == 400


def test_a_blind_car_hits_somebody_who_does_not_react() -> None:
    hits = 0
    for seed in range(6):
        there = world("occluded_4", seed)
        verdict, _ = drive(replace(there, reacts=np.zeros(len(there.reacts), bool)), CAR, towards(2.0))  # its road is straight
        hits += verdict.collided
        assert verdict.collided == (verdict.closest_m is not None and verdict.closest_m < 0.0)
    assert hits > 0


def test_a_car_that_leaves_the_road_has_collided_with_its_edge() -> None:
    verdict, _ = drive(world("crossers_0"), CAR, towards(2.0))  # the street bends, the car does not
    assert verdict.collided and verdict.off_road_m > 0.3
    assert not verdict.timed_out


def test_the_actuators_lag() -> None:
    _, moments = drive(world("crossers_0"), CAR, lambda seen: Asked(1.0, 0.0), 0.0)
    speeds = [moment.car.speed_m_s for moment in moments[:20]]
    assert speeds[10] == pytest.approx(1.0 - LAG_S, abs=0.06)  # a second of 1 m/s2, less the lag


def test_everybody_in_sight_is_told_of_at_constant_velocity_with_a_deviation_that_grows() -> None:
    there = world("meeting_8", 1)
    people = at_start(there)
    told = predictions(there, people, START, 0.0)
    near = np.flatnonzero(np.hypot(*people.places_m.T) < 40.0)
    assert told.numbers == tuple(near)
    assert told.positions_m.shape == (STEPS + 1, len(near), 2)
    walked = told.positions_m[10] - told.positions_m[0]
    assert walked == pytest.approx(10 * STEP_S * people.velocities_m_s[near])
    deviations = np.sqrt(told.covariances_m2[:, :, 0, 0])
    assert deviations[0].max() == 0.0 and (np.diff(deviations, axis=0) > 0.0).all()


def test_who_stands_behind_a_wall_is_not_told_of() -> None:
    there = world("occluded_4")
    wall = there.crossing.occluders[0]
    behind = np.array(there.road.to_world(wall.station_m, wall.offset_m + 1.0)[:2])
    before = np.array(there.road.to_world(wall.station_m, wall.offset_m - 1.0)[:2])
    assert is_hidden(there, START, behind)
    assert not is_hidden(there, START, before)
