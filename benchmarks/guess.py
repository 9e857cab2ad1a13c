"""The learned initial guess: what it spares the local planner in a class that is new, beside the guidance's own places.

T-MPC++ drives reported crossings from seed 0 on, starting from the places as it did before anything was learned; nothing was
trained on these streets or seeds. Every guided problem of a class without a trajectory is solved from either start (`new`), and
in every third cycle that of every class, as if it were new (`all`): the same problem and half-spaces, so the figures are paired.
"From every start tried" are also the path and what the cycle itself had found in that class: such problems may have no solution.
CPU time of the thread, the better of two, problem and checks included for both; what the guess itself costs stands apart, for all
ways of a cycle together. Then whole drives, with and without: what a start spares counts only if the car drives better for it.
"""

import gc
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import count
from time import thread_time_ns
from typing import NamedTuple

import numpy as np

from autonomy.compile import WARM_UPS
from autonomy.planning.crossings.drive import Verdict, drive
from autonomy.planning.crossings.driver import CAR, TUNED, Look, Looked, topology_driver
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.horizon import Floats, Trajectory
from autonomy.planning.learned.guesses import guesses
from autonomy.planning.learned.weights import shipped_weights
from autonomy.planning.mpc.guess import Guess
from autonomy.planning.mpc.planner import solve, start_of
from autonomy.planning.mpc.problem import Problem, arrays
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.mpc.sqp import optimise
from autonomy.planning.topology import UNGUIDED, TopologySettings
from autonomy.training.collect import guided_problem
from benchmarks.figures import Figure, figure, percentile

NAME = "guess"
CASES = (  # crossing, and what the local planner weighs; trained was with its defaults only
    ("meeting_4", "meeting_4", MpcSettings()),
    ("meeting_8", "meeting_8", MpcSettings()),
    ("crossers_12", "crossers_12", MpcSettings()),
    ("narrow_4", "narrow_4", MpcSettings()),
    ("meeting_8 with Table I's weights", "meeting_8", TUNED),
)
SEEDS, EVERY, TRIES = 6, 3, 2
SOON = 3  # programmes: what a planner that is short of time could afford
SHARES = (("p50", 0.5), ("p95", 0.95), ("p99", 0.99))
SAME_COST = 1e-3
GUESS_REACH_MS = 1.0


class Try(NamedTuple):
    feasible: bool
    soon: bool  # the same after SOON programmes
    programmes: int
    ms: float
    cost: float


class Pair(NamedTuple):
    new: bool  # its class had no trajectory
    drawn: bool  # in a cycle in which every class is tried
    places: Try
    learned: Try
    otherwise: bool  # feasible from another start


@dataclass
class Heard:
    pairs: list[Pair] = field(default_factory=list)
    guess_ms: list[float] = field(default_factory=list)
    guided: list[bool] = field(default_factory=list)  # of every guided candidate of the loop itself: feasible


def figures() -> Iterator[Figure]:
    if shipped_weights() is None:
        raise FileNotFoundError("no weights beside autonomy/planning/learned; make them: autonomy train-guess")
    for make_ready in WARM_UPS.values():
        make_ready()
    gc.collect()
    gc.disable()
    try:
        for case, crossing, local in CASES:
            without, heard = driven(crossing, TopologySettings(local=local, learned_guess=False), paired=True)
            drawn = [pair for pair in heard.pairs if pair.drawn]
            for name, pairs in (("new", [pair for pair in heard.pairs if pair.new]), ("all", drawn)):
                yield from lost(f"{case}, {name}", pairs)
                yield from effort(f"{case}, {name}", pairs)
            yield from effort(f"{case}, all that can be solved", [*filter(solved, drawn)])
            yield from price(case, heard.guess_ms)
            verdicts, loop = driven(crossing, TopologySettings(local=local, learned_guess=True), paired=False)
            yield from drives(case, verdicts, loop, without, heard)
    finally:
        gc.enable()


def solved(pair: Pair) -> bool:
    return pair.places.feasible or pair.learned.feasible or pair.otherwise


def lost(what: str, pairs: Sequence[Pair]) -> Iterator[Figure]:
    ours, peer = (1.0 - float(np.mean([each.feasible for each in side])) for side in sides(pairs))
    yield figure(NAME, what, f"infeasible of {len(pairs)}", "share", ours, peer=("guidance's places", peer))
    yield figure(NAME, what, "infeasible from every start tried", "share", 1.0 - float(np.mean([*map(solved, pairs)])))
    ours, peer = (1.0 - float(np.mean([each.soon for each in side])) for side in sides(pairs))
    yield figure(NAME, what, f"infeasible after {SOON} programmes", "share", ours, peer=("guidance's places", peer))


def effort(what: str, pairs: Sequence[Pair]) -> Iterator[Figure]:
    for name, share in SHARES:
        ours, peer = (percentile([each.programmes for each in side], share) for side in sides(pairs))
        yield figure(NAME, what, f"programmes {name}", "SQP", ours, peer=("guidance's places", peer))
    for name, share in SHARES:
        ours, peer = (percentile([each.ms for each in side], share) for side in sides(pairs))
        yield figure(NAME, what, name, "ms", ours, peer=("guidance's places", peer))
    costs = [(a.cost, b.cost) for a, b in zip(*sides(pairs), strict=True) if a.feasible and b.feasible]
    lower, higher = (float(np.mean([a < (1.0 - SAME_COST) * b for a, b in each])) for each in (costs, [(b, a) for a, b in costs]))
    yield figure(NAME, what, f"cost lower by {SAME_COST:g} and more", "share", lower, peer=("guidance's places lower", higher))


def sides(pairs: Sequence[Pair]) -> tuple[list[Try], list[Try]]:
    return [pair.learned for pair in pairs], [pair.places for pair in pairs]


def price(crossing: str, guess_ms: Sequence[float]) -> Iterator[Figure]:
    for name, share in SHARES:
        most = GUESS_REACH_MS if name == "p95" else None
        yield figure(NAME, f"{crossing}, guesses of a cycle", name, "ms", percentile(guess_ms, share), at_most=most)


def drives(crossing: str, ours: Sequence[Verdict], loop: Heard, theirs: Sequence[Verdict], heard: Heard) -> Iterator[Figure]:
    what = f"{crossing}, {len(ours)} drives"
    for name, unit, of in OF_DRIVES:
        mine, peer = (float(np.mean([of(verdict) for verdict in verdicts])) for verdicts in (ours, theirs))
        yield figure(NAME, what, name, unit, mine, peer=("guidance's places", peer))
    mine, peer = (1.0 - float(np.mean(each.guided)) for each in (loop, heard))
    yield figure(NAME, what, "guided, infeasible in the loop", "share", mine, peer=("guidance's places", peer))


OF_DRIVES: tuple[tuple[str, str, Callable[[Verdict], float]], ...] = (
    ("duration", "s", lambda verdict: verdict.duration_s),
    ("cycles without a plan", "a drive", lambda verdict: verdict.braked),
    ("collisions", "a drive", lambda verdict: float(verdict.collided)),
)


def driven(crossing: str, settings: TopologySettings, *, paired: bool) -> tuple[list[Verdict], Heard]:
    (read, tracks), heard = read_crossing(find_crossing(crossing)), Heard()
    look = listening(heard, paired, settings.local)
    worlds = [world_of(read, read.first_seed + seed, tracks) for seed in range(SEEDS)]
    return [drive(world, CAR, topology_driver(world, settings, look))[0] for world in worlds], heard


def listening(heard: Heard, paired: bool, local: MpcSettings) -> Look:
    cycles = count()

    def look(looked: Looked) -> None:
        heard.guided.extend(each.feasible for each in looked.decision.candidates if each.identity != UNGUIDED)
        if paired:
            tried(looked, next(cycles) % EVERY == 0, local, heard)

    return look


def tried(looked: Looked, everyone: bool, local: MpcSettings, heard: Heard) -> None:
    """Both starts of this cycle's classes: of the new ones, or of everyone."""
    known, around, decision = looked.before.found, looked.around, looked.decision
    ways = [way for way in decision.guidances.ways if everyone or way.identity not in known]
    if not ways:
        return
    any_of_them = guided_problem(around, ways[0])
    begin_ns = thread_time_ns()
    learned = guesses(shipped_weights(), ways, any_of_them, local)
    passed_ms = (thread_time_ns() - begin_ns) / 1e6
    if learned is None:
        return
    heard.guess_ms.append(passed_ms)
    for way, guess in zip(ways, learned, strict=True):
        asked = guided_problem(around, way)
        own = [each.trajectory for each in decision.candidates if each.identity == way.identity]
        from_places, from_learned = attempt(asked, way.rear_axle_m, local), attempt(asked, guess, local)
        otherwise = any(each.feasible for each in own) or solve(asked, local).feasible
        heard.pairs.append(Pair(way.identity not in known, everyone, from_places, from_learned, otherwise))


def attempt(asked: Problem, start: Guess | Floats, local: MpcSettings) -> Try:
    passed_ms = []
    for _ in range(TRIES):
        begin_ns = thread_time_ns()
        found: Trajectory = solve(asked, local, start)
        passed_ms.append((thread_time_ns() - begin_ns) / 1e6)
    p = arrays(asked, local)
    programmes = optimise(p, *start_of(p, start), local.iterations_max, local.steps_max).iterations
    soon = optimise(p, *start_of(p, start), SOON, local.steps_max).violation <= local.tolerance_m
    return Try(found.feasible, soon, programmes, min(passed_ms), found.cost)
