"""One cycle of the planner among people: ways that pass them differently, each made drivable, and the best of them taken. Pure.

T-MPC++ (the paper, III-D): a local planner for every guidance, kept on its side of everybody, and one without. The least cost
among the feasible wins; the class that was taken last counts less, so that the car does not waver. When none is feasible the car
brakes along what it was doing, and says so. It does not watch the time: every planner ends by its own count of iterations.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import Annotated

import numpy as np
from msgspec import Meta
from msgspec.structs import replace

from autonomy.car_shape import CarShape
from autonomy.planning.guidance.planner import guide
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.guidance.state import Guidance, Guidances, GuidanceState, initial_state
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, CarState, Floats, Predictions, Trajectory
from autonomy.planning.learned.guesses import guesses
from autonomy.planning.learned.weights import shipped_weights
from autonomy.planning.mpc.bicycle import ANGLE, SPEED, step
from autonomy.planning.mpc.guess import Guess, later
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve
from autonomy.planning.mpc.problem import Problem, state_of
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.reference_path import ReferencePath
from wire.messages.base import Message

UNGUIDED = -1  # in place of a class
BRAKING = -2
SLOWEST_M_S, FASTEST_M_S = 0.5, 14.0  # that guidances are sought for


class TopologySettings(Message):
    guidance: GuidanceSettings = GuidanceSettings()
    local: MpcSettings = MpcSettings()
    guided: bool = True  # with unguided: T-MPC++; alone: T-MPC, which brakes where guidance finds no way
    unguided: bool = True  # alone: LMPCC
    consistency: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.75  # the class taken last counts so much; source: T-MPC
    learned_guess: bool = True  # in a class that has no trajectory yet; off: from the guidance's own places
    braking_m_s2: Annotated[float, Meta(gt=0.1, le=9.0)] = 4.0  # when nothing is feasible


@dataclass(frozen=True, slots=True, kw_only=True)
class Around:
    """What a cycle plans for."""

    car: CarState
    path: ReferencePath
    predictions: Predictions | None  # None: nobody looked
    speed_m_s: float  # wanted


@dataclass(frozen=True, slots=True, kw_only=True)
class Candidate:
    identity: int  # of its class, or UNGUIDED, or BRAKING
    trajectory: Trajectory
    guidance: Guidance | None = None

    @property
    def feasible(self) -> bool:
        return self.trajectory.feasible


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    chosen: Candidate
    candidates: tuple[Candidate, ...]
    guidances: Guidances

    @property
    def braking(self) -> bool:
        """No planner found anything: for the take-over monitor."""
        return self.chosen.identity == BRAKING


@dataclass(frozen=True, slots=True, kw_only=True)
class TopologyState:
    guidance: GuidanceState = field(default_factory=lambda: initial_state(1))
    taken: Candidate | None = None
    found: Mapping[int, Trajectory] = field(default_factory=dict)  # of the last cycle, the feasible ones by class

    @property
    def lost(self) -> bool:
        """In the last cycle no planner found anything."""
        return self.taken is not None and self.taken.identity == BRAKING


def plan(
    state: TopologyState, around: Around, shape: CarShape, settings: TopologySettings, elapsed_s: float = PLAN_PERIOD_S
) -> tuple[TopologyState, Decision]:
    """elapsed_s: since the last plan."""
    memory, guidances = state.guidance, Guidances()
    if settings.guided and around.predictions is not None:
        guided = _guidance_settings(around, shape, settings.guidance)
        memory, guidances = guide(memory, around.car, around.path, around.predictions, guided, elapsed_s)
    ways = () if guidances.left_out else guidances.ways  # they do not know of everybody
    starts = _starts(ways, state, around, shape, settings, elapsed_s)
    candidates = [_guided(way, start, around, shape, settings) for way, start in zip(ways, starts, strict=True)]
    if settings.unguided:
        candidates.append(_unguided(state, around, shape, settings, elapsed_s))
    chosen = _best(candidates, state.taken, settings) or _braking(state.taken, around.car, shape, settings, elapsed_s)
    after = TopologyState(
        guidance=memory, taken=chosen, found={each.identity: each.trajectory for each in (*candidates, chosen) if each.feasible}
    )
    return after, Decision(chosen=chosen, candidates=tuple(candidates), guidances=guidances)


def _guidance_settings(around: Around, shape: CarShape, settings: GuidanceSettings) -> GuidanceSettings:
    """This car's disc, and the speed asked for now."""
    return replace(
        settings,
        speed_m_s=min(max(around.speed_m_s, SLOWEST_M_S), FASTEST_M_S),
        ahead_m=(shape.front_m - shape.rear_m) / 2.0,
        half_width_m=shape.half_width_m,
    )


def _starts(
    ways: Sequence[Guidance], state: TopologyState, around: Around, shape: CarShape, settings: TopologySettings, elapsed_s: float
) -> list[Guess | Floats]:
    """Of each: the last trajectory of its class; in a new class what was learned; else the guidance itself."""
    new = [way for way in ways if way.identity not in state.found]
    weights = shipped_weights() if settings.learned_guess and new else None
    learned = guesses(weights, new, _problem(around, shape, None), settings.local)
    starts: dict[int, Guess | Floats] = {way.identity: way.rear_axle_m for way in new}
    starts |= {way.identity: guess for way, guess in zip(new, learned or (), strict=False)}
    return [later(state.found[i], elapsed_s) if i in state.found else starts[i] for i in (way.identity for way in ways)]


def _guided(way: Guidance, start: Guess | Floats, around: Around, shape: CarShape, settings: TopologySettings) -> Candidate:
    """On the guidance's side of everybody."""
    assert around.predictions is not None
    sides = half_spaces(way.rear_axle_m, around.predictions)
    return Candidate(identity=way.identity, trajectory=solve(_problem(around, shape, sides), settings.local, start), guidance=way)


def _unguided(state: TopologyState, around: Around, shape: CarShape, settings: TopologySettings, elapsed_s: float) -> Candidate:
    """From whatever was taken last."""
    last = state.taken.trajectory if state.taken is not None else None
    guess = later(last, elapsed_s) if last is not None else None
    return Candidate(identity=UNGUIDED, trajectory=solve(_problem(around, shape, None), settings.local, guess))


def _problem(around: Around, shape: CarShape, sides: Floats | None) -> Problem:
    return Problem(
        car=shape, start=around.car, path=around.path, predictions=around.predictions, speed_m_s=around.speed_m_s, sides=sides
    )


def _best(candidates: list[Candidate], taken: Candidate | None, settings: TopologySettings) -> Candidate | None:
    """The least cost; in a tie the first."""
    before = taken.identity if taken is not None else None
    weighed = [
        (each.trajectory.cost * (settings.consistency if each.identity == before else 1.0), number)
        for number, each in enumerate(candidates)
        if each.feasible
    ]
    return candidates[min(weighed)[1]] if weighed else None


def _braking(taken: Candidate | None, car: CarState, shape: CarShape, settings: TopologySettings, elapsed_s: float) -> Candidate:
    """Along the last trajectory's steering, to a standstill as hard as it takes; the next cycle starts from it."""
    rates = later(taken.trajectory, elapsed_s).inputs[:, 1] if taken is not None else np.zeros(STEPS)
    states, inputs, unused = np.zeros((STEPS + 1, 6)), np.zeros((STEPS, 2)), np.zeros((3, 5))
    states[0] = np.nan_to_num(state_of(car), posinf=0.0, neginf=0.0)
    for k in range(STEPS):
        speed, angle = states[k, SPEED], states[k, ANGLE]
        slower = speed - np.clip(speed, -settings.braking_m_s2 * STEP_S, settings.braking_m_s2 * STEP_S)
        bound = shape.road_wheel_angle_max_rad
        turned = np.clip(angle + rates[k] * STEP_S, -bound, bound) - angle if speed != 0.0 else 0.0
        inputs[k] = (slower - speed) / STEP_S, turned / STEP_S
        step(states[k], inputs[k, 0], inputs[k, 1], shape.wheelbase_m, states[k + 1], unused)
    if not isfinite(car.speed_m_s):
        inputs[:, 0] = -settings.braking_m_s2
    braked = Trajectory(states=states, inputs=inputs, cost=np.inf, feasible=False, violation=np.inf)
    return Candidate(identity=BRAKING, trajectory=braked)
