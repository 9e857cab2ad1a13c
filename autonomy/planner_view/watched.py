"""A drive through a crossing with every decision kept: what the pictures are made of."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autonomy.planning.crossings.drive import Asked, Moment, Seen, Verdict, drive
from autonomy.planning.crossings.driver import CAR, TUNED, Looked, topology_driver
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import Floats
from autonomy.planning.topology import Decision, TopologySettings

APART_M = 0.5  # trajectories that are never farther apart are one to the eye
METHODS = {  # of Table I those that plan among people
    "t-mpc++": TopologySettings(local=TUNED),
    "guided": TopologySettings(unguided=False, local=TUNED),
    "lmpcc": TopologySettings(guided=False, local=TUNED),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    seen: Seen
    decision: Decision
    places_m: Floats  # (n, 2) of everybody, also of those whom the planner is not told of
    took_ms: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Watched:
    world: World
    verdict: Verdict
    cycles: tuple[Cycle, ...]


def watch(world: World, settings: TopologySettings, seconds: Callable[[], float]) -> Watched:
    """seconds  a clock, for what a cycle takes; nothing else depends on it"""
    looks: list[Looked] = []
    took_ms: list[float] = []
    planner = topology_driver(world, settings, looks.append)

    def timed(seen: Seen) -> Asked:
        begun_s = seconds()
        asked = planner(seen)
        took_ms.append(1e3 * (seconds() - begun_s))
        return asked

    verdict, moments = drive(world, CAR, timed)
    return Watched(world=world, verdict=verdict, cycles=tuple(map(_cycle, looks, moments, took_ms)))


def _cycle(look: Looked, moment: Moment, took_ms: float) -> Cycle:
    return Cycle(seen=look.seen, decision=look.decision, places_m=moment.places_m, took_ms=took_ms)


def most_telling(cycles: tuple[Cycle, ...]) -> int:
    """Where the feasible trajectories differ most often; of those, with most ways, then with somebody nearest to the car."""

    def telling(number: int) -> tuple[int, int, float]:
        cycle = cycles[number]
        away = np.hypot(cycle.places_m[:, 0] - cycle.seen.car.x_m, cycle.places_m[:, 1] - cycle.seen.car.y_m)
        return different(cycle.decision), len(cycle.decision.candidates), -float(away.min(initial=np.inf))

    return max(range(len(cycles)), key=telling)


def different(decision: Decision) -> int:
    """Feasible trajectories of which no two are anywhere nearer than APART_M, greedily from the first."""
    kept: list[Floats] = []
    for found in (each.trajectory.states[:, :2] for each in decision.candidates if each.feasible):
        if all(float(np.abs(found - other).max()) > APART_M for other in kept):
            kept.append(found)
    return len(kept)


def cycle_at(cycles: tuple[Cycle, ...], time_s: float) -> int:
    """The nearest in time."""
    return min(range(len(cycles)), key=lambda number: abs(cycles[number].seen.time_s - time_s))
