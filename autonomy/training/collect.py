"""Drives through training crossings, and what the local planner made there of every guidance: what the network is to learn. Pure.

The car is driven by T-MPC++ itself, from the guidances' own places. In every third cycle each guidance is solved once more, cold,
as a class is that is new; the better of that and of what the cycle found in the class is kept, when it is feasible. Seeds and
streets are those of the training files alone: nothing that is reported or tuned on.
"""

from collections.abc import Iterator
from itertools import count
from typing import NamedTuple

import numpy as np

from autonomy.planning.crossings.drive import drive
from autonomy.planning.crossings.driver import CAR, Looked, topology_driver
from autonomy.planning.crossings.scenario import World, find_crossing, read_crossing, world_of
from autonomy.planning.guidance.state import Guidance
from autonomy.planning.horizon import STEPS, CarState, Floats, Trajectory
from autonomy.planning.learned.features import PEOPLE, PERSON, Singles, features
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve
from autonomy.planning.mpc.problem import Problem
from autonomy.planning.topology import Around, Decision, TopologySettings

CROSSINGS = ("training_bend_6", "training_narrow_3", "training_wide_10", "training_before_8")
EVERY = 3  # cycles: those between are nearly the same
SETTINGS = TopologySettings(learned_guess=False)  # nothing learns from its own guesses


class Sample(NamedTuple):
    alone: Singles  # (features.WAY + LINE + CAR,)
    people: Singles  # (PEOPLE, PERSON), zeros where there is nobody
    there: Singles  # (PEOPLE,) 1 where there is somebody
    states: Singles  # (STEPS + 1, 5) x, y, heading, speed, angle, from the car's own place and heading
    inputs: Singles  # (STEPS, 2)


def collected(drives: int) -> Iterator[list[Sample]]:
    """A list for each drive, crossing after crossing."""
    read = [read_crossing(find_crossing(name)) for name in CROSSINGS]
    for number in range(drives):
        crossing, tracks = read[number % len(read)]
        yield samples_of(world_of(crossing, crossing.first_seed + number // len(read), tracks))


def samples_of(world: World) -> list[Sample]:
    found: list[Sample] = []
    cycles = count()

    def look(looked: Looked) -> None:
        if next(cycles) % EVERY == 0:
            found.extend(samples(looked.around, looked.decision))

    drive(world, CAR, topology_driver(world, SETTINGS, look))
    return found


def samples(around: Around, decision: Decision) -> Iterator[Sample]:
    """Of every guidance of a cycle that can be made drivable."""
    ways, people = decision.guidances.ways, around.predictions
    if not ways or people is None:
        return
    told = features(ways, around.car, around.path, people, around.speed_m_s)
    told_of = told.people.shape[1]
    for row, way in enumerate(ways):
        best = _best(around, decision, way)
        if best is not None:
            padded = np.zeros((PEOPLE, PERSON), np.float32)
            padded[:told_of] = told.people[row]
            there = (np.arange(PEOPLE) < told_of).astype(np.float32)
            yield Sample(told.alone[row], padded, there, from_car(best.states, around.car), best.inputs.astype(np.float32))


def _best(around: Around, decision: Decision, way: Guidance) -> Trajectory | None:
    tried = [each.trajectory for each in decision.candidates if each.identity == way.identity] + [cold(around, way)]
    return min((each for each in tried if each.feasible), key=lambda each: each.cost, default=None)


def cold(around: Around, way: Guidance) -> Trajectory:
    return solve(guided_problem(around, way), SETTINGS.local, way.rear_axle_m)


def guided_problem(around: Around, way: Guidance) -> Problem:
    assert around.predictions is not None
    sides = half_spaces(way.rear_axle_m, around.predictions)
    return Problem(
        car=CAR, start=around.car, path=around.path, predictions=around.predictions, speed_m_s=around.speed_m_s, sides=sides
    )


def from_car(states: Floats, car: CarState) -> Singles:
    """(STEPS + 1, 5) of states (STEPS + 1, 6)."""
    c, s = np.cos(car.heading_rad), np.sin(car.heading_rad)
    x, y = states[:, 0] - car.x_m, states[:, 1] - car.y_m
    seen = np.stack((x * c + y * s, y * c - x * s, states[:, 2] - car.heading_rad, states[:, 3], states[:, 4]), axis=1)
    return np.asarray(seen, np.float32).reshape(STEPS + 1, 5)
