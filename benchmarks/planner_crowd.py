"""People who cross an S-shaped road without looking, for the planner's benchmarks and tests: seeded, arrays only."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, CarState, Floats, Predictions, Trajectory
from autonomy.planning.mpc.problem import Problem
from autonomy.planning.reference_path import ReferencePath, through

CAR = CarShape(  # the paper's Prius, as in the benchmark of its planner
    front_m=3.8,
    rear_m=1.0,
    half_width_m=1.125,
    wheelbase_m=2.79,
    road_wheel_angle_max_rad=0.55,
    braking_max_m_s2=8.0,
)
SPEED_M_S = 2.0
RADIUS_M = 0.5  # of a person
ROOM_M = 3.5
PIECE_M = 5.0
PIECES = 8  # of the path that a problem holds: more than the horizon reaches
NOISE_M_S = 0.3  # the reference's: deviation of a prediction grows by NOISE_M_S * STEP_S * sqrt(k)
CAR_MEAN_M_S = 1.5  # about what it drives in the first ten seconds
EARLY_S = 2.5  # so much before or after it somebody may come by
SOONEST_S = 2.0
SWAY_M = 0.02  # what a person does besides, per plan


class Crowd(NamedTuple):
    places_m: Floats  # (n, 2)
    velocities_m_s: Floats  # (n, 2)


def s_curve() -> ReferencePath:
    """80 m of y = 3 sin(x / 14)."""
    x = np.arange(0.0, 80.0, PIECE_M)
    points = np.stack((x, 3.0 * np.sin(x / 14.0)), axis=1)
    room = np.full(len(x), ROOM_M)
    return through(points, np.arctan(3.0 / 14.0 * np.cos(x / 14.0)), room, room)


def part_of(path: ReferencePath, station_m: float) -> ReferencePath:
    """PIECES of it, from the one before the station."""
    first = int(np.clip(np.searchsorted(path.knots_m, station_m) - 2, 0, len(path.knots_m) - 1 - PIECES))
    pieces, knots = slice(first, first + PIECES), slice(first, first + PIECES + 1)
    return replace(
        path,
        knots_m=path.knots_m[knots],
        x_coefficients=path.x_coefficients[pieces],
        y_coefficients=path.y_coefficients[pieces],
        room_left_m=path.room_left_m[knots],
        room_right_m=path.room_right_m[knots],
    )


def crowd(random: np.random.Generator, path: ReferencePath, count: int) -> Crowd:
    """They walk across the road at 1.14 to 1.66 m/s, about square to it, and are on it about when the car comes by."""
    places, velocities = np.empty((count, 2)), np.empty((count, 2))
    for j in range(count):
        station, side = random.uniform(8.0, 24.0), random.choice((-1.0, 1.0))
        turn, speed = random.normal(0.0, 0.2), random.uniform(1.14, 1.66)
        x, y, heading = path.at(station)
        away = speed * max(station / CAR_MEAN_M_S + random.uniform(-EARLY_S, EARLY_S), SOONEST_S)
        places[j] = x - side * away * np.sin(heading), y + side * away * np.cos(heading)
        course = heading - side * np.pi / 2 + turn
        velocities[j] = speed * np.cos(course), speed * np.sin(course)
    return Crowd(places, velocities)


def predicted(people: Crowd) -> Predictions:
    """They go on as they do."""
    times = np.arange(STEPS + 1) * STEP_S
    count = len(people.places_m)
    variances = np.arange(STEPS + 1) * (NOISE_M_S * STEP_S) ** 2
    return Predictions(
        numbers=tuple(range(count)),
        positions_m=people.places_m + times[:, None, None] * people.velocities_m_s,
        covariances_m2=np.broadcast_to(variances[:, None, None, None] * np.eye(2), (STEPS + 1, count, 2, 2)).copy(),
        radii_m=np.full(count, RADIUS_M),
    )


def start_on(path: ReferencePath) -> CarState:
    x, y, heading = path.at(0.5)
    return CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=0.5, road_wheel_angle_rad=0.0, station_m=0.5)


class Drive:
    """A closed loop: the car follows each trajectory for one plan's time exactly, or brakes along when there is none."""

    def __init__(self, seed: int, count: int) -> None:
        self.random = np.random.default_rng(seed)
        self.path = s_curve()
        self.people = crowd(self.random, self.path, count)
        self.car = start_on(self.path)

    def problem(self, sides: Floats | None = None) -> Problem:
        return Problem(
            car=CAR,
            start=self.car,
            path=part_of(self.path, self.car.station_m),
            predictions=predicted(self.people),
            speed_m_s=SPEED_M_S,
            sides=sides,
        )

    def follow(self, found: Trajectory) -> None:
        passed = PLAN_PERIOD_S / STEP_S
        state = found.states[0] + passed * (found.states[1] - found.states[0])
        if not found.feasible:
            speed = max(self.car.speed_m_s - 4.0 * PLAN_PERIOD_S, 0.0)
            run = (self.car.speed_m_s + speed) / 2 * PLAN_PERIOD_S
            turn = run * np.tan(self.car.road_wheel_angle_rad) / CAR.wheelbase_m
            heading = self.car.heading_rad + turn
            x, y = self.car.x_m + run * np.cos(heading), self.car.y_m + run * np.sin(heading)
            state = np.array((x, y, heading, speed, self.car.road_wheel_angle_rad, self.car.station_m + run))
        self.car = _car(state)
        moved = self.people.places_m + self.people.velocities_m_s * PLAN_PERIOD_S
        self.people = self.people._replace(places_m=moved + self.random.normal(0.0, SWAY_M, moved.shape))


def _car(state: Floats) -> CarState:
    x, y, heading, speed, angle, station = map(float, state)
    return CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=speed, road_wheel_angle_rad=angle, station_m=station)
