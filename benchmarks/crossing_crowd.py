"""A crowd that crosses a winding road before a car, in straight lines; whoever has crossed makes room for somebody new.

For figures and tests of the guidance planner, on its own fixed numbers. Nobody here reacts to the car, and the car only
rolls along the path at the speed it would like, and heeds nobody: how well a planner drives is not seen here (for that:
autonomy/planning/crossings). Walking speeds as the paper's simulation has them (1.4 m/s, deviation 0.26).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, CarState, Floats, Predictions
from autonomy.planning.reference_path import ReferencePath, through

SPEED_M_S = 2.0
RADIUS_M = 0.4
SIDE_M = 3.5
GONE_M = 8.0  # from the path, on the far side
JITTER_M = 0.02  # of a place from cycle to cycle
AHEAD_M = (6.0, 16.0)  # of the car's middle: where somebody new crosses the path
MIDDLE_M = 1.4  # before the rear axle
BESIDE_S = (1.4, 3.5)  # so long before or after the car will be there


@dataclass
class _Person:
    number: int
    place_m: Floats
    velocity_m_s: Floats
    gone: Floats  # the way across: unit vector
    foot_m: Floats  # where they cross the path


def winding_path() -> ReferencePath:
    """160 m long, 3 m to either side in waves of 88 m; 3.5 m of room on each side."""
    x = np.linspace(0.0, 160.0, 65)
    points = np.stack((x, 3.0 * np.sin(x / 14.0)), axis=1)
    room = np.full(len(x), SIDE_M)
    return through(points, np.arctan(3.0 / 14.0 * np.cos(x / 14.0)), room, room)


def crossing(seed: int, count: int, cycles: int) -> Iterator[tuple[CarState, Predictions]]:
    """What a planner is given in each cycle."""
    chance, path, station = np.random.default_rng(seed), winding_path(), 1.0
    people = [_somebody(chance, path, station, number) for number in range(count)]
    newest = count
    for _ in range(cycles):
        yield _car(path, station), _predictions(people)
        station += SPEED_M_S * PLAN_PERIOD_S
        for row, person in enumerate(people):
            person.place_m = person.place_m + person.velocity_m_s * PLAN_PERIOD_S + chance.normal(0.0, JITTER_M, 2)
            if (person.place_m - person.foot_m) @ person.gone > GONE_M:
                people[row] = _somebody(chance, path, station, newest)
                newest += 1


def _somebody(chance: np.random.Generator, path: ReferencePath, station_m: float, number: int) -> _Person:
    ahead = chance.uniform(*AHEAD_M)
    x, y, heading = path.at(station_m + MIDDLE_M + ahead)
    across = chance.choice([-1.0, 1.0]) * np.array([-np.sin(heading), np.cos(heading)])
    speed = np.clip(chance.normal(1.4, 0.26), 0.7, 2.1)
    until = max(ahead / SPEED_M_S + chance.choice([-1.0, 1.0]) * chance.uniform(*BESIDE_S), 1.0)
    foot = np.array([x, y])
    return _Person(number, foot - across * speed * until, across * speed, across, foot)


def _car(path: ReferencePath, station_m: float) -> CarState:
    x, y, heading = path.at(station_m)
    return CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=SPEED_M_S, road_wheel_angle_rad=0.0, station_m=station_m)


def _predictions(people: list[_Person]) -> Predictions:
    """Constant velocity; the deviation grows as the public planner has it, 0.3 m/s times a step, times the root of the steps."""
    places = np.array([person.place_m for person in people]).reshape(-1, 2)
    velocities = np.array([person.velocity_m_s for person in people]).reshape(-1, 2)
    times = STEP_S * np.arange(STEPS + 1)[:, None, None]
    variances = (0.3 * STEP_S) ** 2 * np.arange(STEPS + 1)
    return Predictions(
        numbers=tuple(person.number for person in people),
        positions_m=places + times * velocities,
        covariances_m2=variances[:, None, None, None] * np.eye(2) * np.ones((1, len(people), 1, 1)),
        radii_m=np.full(len(people), RADIUS_M),
    )
