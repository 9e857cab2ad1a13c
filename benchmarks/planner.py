"""The local planner: CPU time of a trajectory, whether ipopt finds the same, and how often people are really met.

One core, CPU time of the thread (the machine may be shared), problem and checks included for ours, the solver's call alone for
the peers; ours the best of three, as two cores disturb each other, the peers once: ratios are beyond what that makes. Three seeds
of a hundred plans each among 4 and 12 people who cross when the car comes (`planner_crowd.py`), a closed loop: warm from the last
trajectory, which also tells the half-spaces of its class. ipopt (mumps, tol 1e-6) and fatrop get the same problem and the same
guess, in the same run. The problem has valleys: ipopt is started once more where ours ended, and tells whether that was the
bottom of its own. The car is never driven by one start alone: ours is started as well from every trajectory of a cycle of the
topology planner that remembers nothing (six starts at most), and the best of that is set beside the best that ipopt finds, from
that guess and from where ours ended, and beside what it finds from a guess of its own: along the path, as who knows nothing.
Guided and cold: from places that a plain search finds clear (`clear_places`), not by the guidance planner; `guess` has those of
the guidance. Joint risk: the trajectories that come nearest to people, against rollouts that walk as predicted.
"""

import gc
from collections.abc import Callable, Iterator, Sequence
from functools import cache
from time import thread_time_ns
from typing import NamedTuple, TypeVar

import numpy as np

from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, Floats, Predictions, Trajectory
from autonomy.planning.mpc.guess import Guess, along, later
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.outline import outline
from autonomy.planning.mpc.planner import solve, start_of
from autonomy.planning.mpc.problem import Problem, arrays
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.mpc.warm_up import warm_up
from autonomy.planning.topology import Around, TopologySettings, TopologyState, plan
from benchmarks.figures import Figure, figure, percentile
from benchmarks.planner_crowd import CAR, SPEED_M_S, Drive
from benchmarks.planner_oracle import Answer, Oracle, oracle, shape_of

NAME = "planner"
SEEDS, PLANS = 3, 100
REACH_MS = {4: 0.6, 12: 1.0}  # warm, p95
GUIDED_REACH_MS = 3.0  # cold, p99
SAME_COST = 1e-3
ROLLOUTS = 10_000
TRIES = 3
NEAREST = 20  # trajectories of a crowd size that are tried by rollouts
SETTINGS = MpcSettings()


T = TypeVar("T")


class Case(NamedTuple):
    problem: Problem
    guess: Guess | Floats | None
    found: Trajectory
    ms: float


Answered = tuple[Case, Answer, float]  # and its milliseconds


def figures() -> Iterator[Figure]:
    warm_up()
    gc.collect()
    gc.disable()
    try:
        for people in REACH_MS:
            cases = driven(people)
            warm = [case for case in cases if case.guess is not None]
            beside = peers(warm)
            yield from times(f"{people} people, warm", warm, beside, REACH_MS[people])
            yield from accuracy(f"{people} people, warm", warm, beside["ipopt"])
            yield from guided(people, cases)
            yield from risk(people, cases)
    finally:
        gc.enable()


def driven(people: int) -> list[Case]:
    """Every plan of the closed loops."""
    cases = []
    for seed in range(SEEDS):
        drive = Drive(seed, people)
        last: Trajectory | None = None
        for _ in range(PLANS):
            guess = later(last, PLAN_PERIOD_S) if last is not None and last.feasible else None
            asked = drive.problem()
            places = guess.states[:, :2] if guess is not None else along(arrays(asked, SETTINGS)).states[:, :2]
            asked = drive.problem(half_spaces(places, _people(asked)))
            cases.append(timed(asked, guess))
            last = cases[-1].found
            drive.follow(last)
    return cases


def timed(asked: Problem, guess: Guess | Floats | None) -> Case:
    passed_ms = []
    for _ in range(TRIES):
        begin_ns = thread_time_ns()
        found = solve(asked, SETTINGS, guess)
        passed_ms.append((thread_time_ns() - begin_ns) / 1e6)
    return Case(asked, guess, found, min(passed_ms))


def peers(cases: list[Case]) -> dict[str, list[Answered]]:
    """Each peer's answer to every case, from the same guess, and its milliseconds."""
    return {name: answered(name, cases) for name in ("ipopt", "fatrop")}


def answered(name: str, cases: list[Case], *, own: bool = False) -> list[Answered]:
    """own: not from ours, but from along the path at a gentle speed."""
    built: dict[object, Oracle] = {}
    told: list[Answered] = []
    for case in cases:
        p = arrays(case.problem, SETTINGS)
        states, inputs = start_of(p, None if own else case.guess)
        if shape_of(p) not in built:
            built[shape_of(p)] = oracle(name, p)
        begin_ns = thread_time_ns()
        answer = built[shape_of(p)](p, states, inputs[:STEPS, :2])
        told.append((case, answer, (thread_time_ns() - begin_ns) / 1e6))
    return told


def times(what: str, cases: list[Case], told: dict[str, list[Answered]], reach_ms: float) -> Iterator[Figure]:
    for name, answers in told.items():
        for figure_name, share in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99)):
            beside = (f"{name}, same guess", percentile([ms for _, _, ms in answers], share))
            most = reach_ms if figure_name == "p95" else None
            yield figure(NAME, what, figure_name, "ms", percentile([case.ms for case in cases], share), peer=beside, at_most=most)


def accuracy(what: str, cases: list[Case], answers: list[Answered]) -> Iterator[Figure]:
    """Feasible sets and costs beside ipopt's: from the same guess, from where ours ended, from a guess of its own."""
    yield figure(NAME, what, "feasible", "share", _share(cases, lambda case: case.found.feasible))
    alike = [(case, answer) for case, answer, _ in answers if case.found.feasible == _is_feasible(answer)]
    yield figure(NAME, what, "feasible for one of ours and ipopt only", "share", 1.0 - len(alike) / len(answers), at_most=0.0)
    both = [(case, answer) for case, answer in alike if case.found.feasible]
    apart = [_above(case.found.cost, answer) for case, answer in both]
    yield figure(
        NAME, what, "cost not within 1e-3 of ipopt's", "share", _share(apart, lambda by: abs(by) > SAME_COST), at_most=0.01
    )
    yield figure(NAME, what, "cost more than 1e-3 above ipopt's", "share", _share(apart, lambda by: by > SAME_COST))
    lower = _share(both, lambda one: _below(one[0], one[0].found) > SAME_COST)
    yield figure(NAME, what, "lowered by more than 1e-3 by ipopt from where ours ends", "share", lower, at_most=0.01)
    best = {id(case): _best(case) for case in cases}
    met = [(case, answer, best[id(case)]) for case, answer in both]
    dearer = _share(met, lambda one: _above(one[2].cost, one[1]) > SAME_COST)
    yield figure(NAME, what, "with the starts of a planning cycle: more than 1e-3 above ipopt's", "share", dearer, at_most=0.01)
    worse = _share(met, lambda one: max(_above(one[2].cost, one[1]), _below(one[0], one[2])) > SAME_COST)
    yield figure(NAME, what, "likewise: not within 1e-3 of the best that ipopt finds", "share", worse, at_most=0.01)
    own = [(best[id(case)], answer) for case, answer, _ in answered("ipopt", cases, own=True)]
    ends = [(found.feasible, _is_feasible(answer)) for found, answer in own]
    ours, theirs = (ends.count(alone) / max(len(ends), 1) for alone in ((True, False), (False, True)))
    yield figure(NAME, what, "likewise, ipopt from a guess of its own: feasible for ours only", "share", ours)
    yield figure(NAME, what, "likewise, ipopt from a guess of its own: feasible for ipopt only", "share", theirs, at_most=0.0)
    shared = [(found, answer) for found, answer in own if found.feasible and _is_feasible(answer)]
    above = _share(shared, lambda one: _above(one[0].cost, one[1]) > SAME_COST)
    yield figure(NAME, what, "likewise, ipopt from a guess of its own: more than 1e-3 above it", "share", above, at_most=0.01)


def guided(people: int, cases: list[Case]) -> Iterator[Figure]:
    """Cold, from clear places of every other plan's problem, each in its class."""
    tried = []
    for case in cases[::2]:
        for places in clear_places(case.problem):
            sides = half_spaces(places, _people(case.problem))
            asked = Problem(
                car=CAR,
                start=case.problem.start,
                path=case.problem.path,
                predictions=case.problem.predictions,
                speed_m_s=SPEED_M_S,
                sides=sides,
            )
            tried.append(timed(asked, places))
    for what, share in (("p50", 0.5), ("p95", 0.95), ("p99", 0.99)):
        most = GUIDED_REACH_MS if what == "p99" else None
        yield figure(
            NAME, f"{people} people, guided, cold", what, "ms", percentile([case.ms for case in tried], share), at_most=most
        )
    lost = _share(tried, lambda case: not case.found.feasible)
    yield figure(NAME, f"{people} people, guided, cold", f"infeasible of {len(tried)}", "share", lost, at_most=0.02)


def clear_places(asked: Problem) -> list[Floats]:
    """Beside the path by so much, at so much of the speed: those (STEPS + 1, 2) on which the car's discs touch nobody's mean."""
    people, discs, start = _people(asked), outline(CAR), asked.start
    at = asked.path.at(start.station_m)
    beside = (start.y_m - at[1]) * np.cos(at[2]) - (start.x_m - at[0]) * np.sin(at[2])
    ramp = 1.0 - np.exp(-np.arange(STEPS + 1) * STEP_S / 2.0)
    found = []
    for share in (1.0, 0.6, 0.2):
        speeds = start.speed_m_s + (share * SPEED_M_S - start.speed_m_s) * ramp
        stations = start.station_m + np.concatenate(([0.0], np.cumsum(speeds[1:] * STEP_S)))
        line = np.array([asked.path.at(float(station)) for station in stations])
        for offset in (0.0, 1.2, -1.2):
            offsets = beside + (offset - beside) * ramp
            heading = line[:, 2]
            places = line[:, :2] + offsets[:, None] * np.stack((-np.sin(heading), np.cos(heading)), axis=1)
            along_m = [places + d * np.stack((np.cos(heading), np.sin(heading)), axis=1) for d in np.linspace(*discs[:2], 5)]
            gaps = [np.hypot(*(people.positions_m - middle[:, None]).transpose(2, 0, 1)) - people.radii_m for middle in along_m]
            if people.count == 0 or min(gap[1:].min() for gap in gaps) > discs.radius_m:
                found.append(places)
    return found


def risk(people: int, cases: list[Case]) -> Iterator[Figure]:
    """Worst and mean of the trajectories that come nearest, in deviations."""
    near = sorted((case for case in cases if case.found.feasible), key=_nearest)[:NEAREST]
    random = np.random.default_rng(0)
    for what, is_walk in (("walks", True), ("errors of stages independent", False)):
        met = [_met(case, random, is_walk) for case in near]
        asked = ("requested", SETTINGS.risk)
        name = f"{people} people, {ROLLOUTS} rollouts, {what}"
        yield figure(NAME, name, f"met, worst of {len(near)}", "share", max(met), peer=asked, ratio_at_most=1.0)
        yield figure(NAME, name, f"met, mean of {len(near)}", "share", float(np.mean(met)), peer=asked)


def _nearest(case: Case) -> float:
    people = _people(case.problem)
    deviations = np.sqrt(people.covariances_m2[1:, :, 0, 0])
    gaps = outside_the_car(case.found.states[1:], people.positions_m[1:]) - people.radii_m
    return float((gaps / deviations).min(initial=np.inf))


def _met(case: Case, random: np.random.Generator, is_walk: bool) -> float:
    """Share of rollouts in which anybody touches the car's rectangle at any stage."""
    people, hits = _people(case.problem), 0
    variances = people.covariances_m2[:, 0, 0, 0]
    for _ in range(ROLLOUTS // 1000):
        normal = random.normal(size=(1000, STEPS, people.count, 2))
        grown = np.sqrt(np.diff(variances))[:, None, None] * normal
        errors = grown.cumsum(axis=1) if is_walk else np.sqrt(variances[1:])[:, None, None] * normal
        gaps = outside_the_car(case.found.states[1:], people.positions_m[1:] + errors) - people.radii_m
        hits += int((gaps < 0.0).any(axis=(1, 2)).sum())
    return hits / ROLLOUTS


def outside_the_car(states: Floats, places: Floats) -> Floats:
    """(..., K, n) distance of places (..., K, n, 2) to the car's rectangle at states (K, 6)."""
    c, s = np.cos(states[:, 2])[:, None], np.sin(states[:, 2])[:, None]
    x, y = places[..., 0] - states[:, None, 0], places[..., 1] - states[:, None, 1]
    ahead, aside = x * c + y * s, np.abs(y * c - x * s)
    beyond = np.maximum(np.maximum(-CAR.rear_m - ahead, ahead - CAR.front_m), 0.0)
    distances: Floats = np.hypot(beyond, np.maximum(aside - CAR.half_width_m, 0.0))
    return distances


def _above(cost: float, answer: Answer) -> float:
    """By what share of the peer's cost."""
    return (cost - answer.cost) / answer.cost


def _best(case: Case) -> Trajectory:
    """Ours from the last trajectory, and from each that a cycle of the topology planner finds, kept on the same sides."""
    asked = case.problem
    around = Around(car=asked.start, path=asked.path, predictions=asked.predictions, speed_m_s=asked.speed_m_s)
    _, decision = plan(TopologyState(), around, CAR, TopologySettings(local=SETTINGS))
    others = (solve(asked, SETTINGS, later(each.trajectory, 0.0)) for each in decision.candidates)
    return min((case.found, *others), key=lambda found: (not found.feasible, found.cost))


@cache
def _near(people: int) -> Oracle:
    return oracle("ipopt, near", arrays(Drive(0, people).problem(np.zeros((STEPS + 1, people, 3))), SETTINGS))


def _below(case: Case, found: Trajectory) -> float:
    """By what share of its own cost ipopt ends below ours from there: 0 at a valley's bottom, infinite if it ends nowhere."""
    answer = _near(_people(case.problem).count)(arrays(case.problem, SETTINGS), found.states, found.inputs)
    return _above(found.cost, answer) if _is_feasible(answer) else np.inf


def _is_feasible(answer: Answer) -> bool:
    return answer.converged and answer.slack <= SETTINGS.tolerance_m


def _share(values: Sequence[T], holds: Callable[[T], bool]) -> float:
    return sum(map(holds, values)) / max(len(values), 1)


def _people(asked: Problem) -> Predictions:
    if asked.predictions is None:
        raise ValueError("a benchmark's problem has predictions")
    return asked.predictions
