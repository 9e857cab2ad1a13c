"""The guidance planner: one cycle of `guide` in CPU time of its thread, 50 samples, among people who cross right ahead.

The floor beside it, in the same cycles: only the checks of clearance that any such graph makes - each of 50 samples against
the start, and against one goal - in the planner's own kernel, nothing drawn, sorted or smoothed. There is no peer to run
beside it: the public guidance planner is C++ within ROS. Beside the time, what it finds: of the four best classes that four
graphs of 200 samples each find from nothing, those that the planner has at that moment with its 50 and its memory.
"""

import gc
from collections.abc import Iterator
from dataclasses import dataclass, field
from time import thread_time_ns

import numpy as np
from msgspec.structs import replace

from autonomy.planning.guidance.clearance import Crowd, clear
from autonomy.planning.guidance.planner import guide
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.guidance.state import Code, Guidances, initial_state
from autonomy.planning.guidance.warm_up import warm_up
from autonomy.planning.horizon import HORIZON_S, STEPS, CarState, Floats, Predictions
from autonomy.planning.kernels import kernel
from benchmarks.crossing_crowd import RADIUS_M, crossing, winding_path
from benchmarks.figures import Figure, figure, percentile

NAME = "guidance"
REACH_MS = 1.5  # p95 among 12 people
SEEDS, CYCLES = 10, 100
EVERY = 10  # cycles: what is there to be found is looked up so often
PATIENT, TRIES = 200, 4
SETTINGS = GuidanceSettings()
PATH = winding_path()


@dataclass
class Measured:
    cycles_ms: list[float] = field(default_factory=list)
    floors_ms: list[float] = field(default_factory=list)
    ways: list[int] = field(default_factory=list)
    there: int = 0  # classes that the patient ones found
    found: int = 0  # of those


def figures() -> Iterator[Figure]:
    """p50 and p95 of a cycle among 4 and 12 people, and what it finds."""
    warm_up()
    for count in (4, 12):
        case, seen = f"{count} people, 50 samples", measured(count)
        for what, share in (("p50", 0.50), ("p95", 0.95)):
            floor = ("clearance of 50 samples from start and goal", percentile(seen.floors_ms, share))
            reach = REACH_MS if count == 12 and what == "p95" else None
            yield figure(NAME, case, what, "ms CPU", percentile(seen.cycles_ms, share), peer=floor, at_most=reach)
        yield figure(NAME, case, "ways, mean", "", float(np.mean(seen.ways)))
        yield figure(NAME, case, "cycles without a way", "%", 100.0 * float(np.mean(np.array(seen.ways) == 0)))
        there = ("4 graphs of 200 samples, best four classes", 100.0)
        yield figure(NAME, case, "classes found", "%", 100.0 * seen.found / max(seen.there, 1), peer=there)


def measured(count: int) -> Measured:
    told = Measured()
    _floor(*next(crossing(0, count, 1)))
    for seed in range(SEEDS):
        state = initial_state(seed)
        gc.collect()
        for cycle, (car, predictions) in enumerate(crossing(seed, count, CYCLES)):
            begin = thread_time_ns()
            state, now = guide(state, car, PATH, predictions, SETTINGS)
            done = thread_time_ns()
            told.cycles_ms.append((done - begin) / 1e6)
            told.floors_ms.append(_floor(car, predictions))
            told.ways.append(len(now.ways))
            if cycle % EVERY == 0:
                _compare(told, now, car, predictions)
    return told


def _compare(told: Measured, now: Guidances, car: CarState, predictions: Predictions) -> None:
    """Counts the best classes that patience finds, and which of them the planner has."""
    settings, costs = replace(SETTINGS, samples=PATIENT), dict[Code, float]()
    for seed in range(TRIES):
        for way in guide(initial_state(1000 + seed), car, PATH, predictions, settings)[1].ways:
            costs[way.code] = min(costs.get(way.code, np.inf), way.cost_m)
    best = sorted(costs, key=costs.__getitem__)[: SETTINGS.trajectories]
    told.there += len(best)
    told.found += len({way.code for way in now.ways} & set(best))


def _floor(car: CarState, predictions: Predictions) -> float:
    """Milliseconds of the checks alone."""
    tracks = np.ascontiguousarray(predictions.positions_m.transpose(1, 0, 2))
    clearances = np.full(len(tracks), RADIUS_M + SETTINGS.half_width_m + SETTINGS.margin_m)
    paces = np.hypot(*np.diff(tracks, axis=1).T).max(axis=0)
    crowd = Crowd(tracks, np.zeros(tracks.shape[:2]), clearances, clearances, paces)
    start = np.array([car.x_m, car.y_m, 0.0])
    ahead = SETTINGS.speed_m_s * HORIZON_S * np.array([np.cos(car.heading_rad), np.sin(car.heading_rad)])
    goal = np.array([car.x_m + ahead[0], car.y_m + ahead[1], STEPS])
    shares = (np.arange(SETTINGS.samples) + 0.5) / SETTINGS.samples
    samples = start + shares[:, None] * (goal - start)
    begin = thread_time_ns()
    _checks(start, goal, samples, crowd)
    return (thread_time_ns() - begin) / 1e6


@kernel
def _checks(start: Floats, goal: Floats, samples: Floats, crowd: Crowd) -> int:
    seen = 0
    for sample in samples:
        seen += clear(start, sample, crowd, crowd.clearances) + clear(sample, goal, crowd, crowd.clearances)
    return seen
