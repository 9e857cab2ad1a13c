"""What goes into the guidance planner from cycle to cycle, and what comes out. Plain data."""

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from autonomy.planning.guidance.graph import Graph, Ints
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import Floats

Code = tuple[tuple[int, Side], ...]  # track number and side, by growing number


class Lack(StrEnum):
    """Why there is no guidance at all."""

    CAR = "the car's state is not a number"
    PATH = "the path is not a number, or ends where the car is"
    OFF_ROAD = "the car is too far off the road"
    TOUCHING = "somebody is where the car is"
    NO_WAY = "no way found"


@dataclass(frozen=True, slots=True, kw_only=True)
class Guidance:
    """One way through the crowd, as a trajectory of the car's middle and what follows of it for the rear axle."""

    identity: int  # of its class: the same from cycle to cycle
    code: Code  # of everybody who counts
    middle_m: Floats  # (STEPS + 1, 2) the car's middle, GuidanceSettings.ahead_m before the rear axle
    speeds_m_s: Floats  # (STEPS + 1,) of the middle
    rear_axle_m: Floats  # (STEPS + 1, 2) pulled along behind it, as on a drawbar
    headings_rad: Floats  # (STEPS + 1,) continuous from the car's own
    points_m: Floats  # (10, 2), seldom more: of the spline through them, evenly spaced in time
    cost_m: float  # of its goal: metres short of where the car would like to be, and aside


@dataclass(frozen=True, slots=True, kw_only=True)
class Searched:
    """What was looked through, for looking at: outcome.view_of makes nodes and edges of it."""

    graph: Graph
    connectors: tuple[Ints, ...]  # of each way, from the start on: rows of nodes


@dataclass(frozen=True, slots=True, kw_only=True)
class Guidances:
    """Best first. Fewer than asked for, or none, is a result like any other."""

    ways: tuple[Guidance, ...] = ()
    lack: Lack | None = None  # when there is none
    left_out: tuple[int, ...] = ()  # track numbers of predictions that are not numbers: guidance knows nothing of them
    searched: Searched | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class KnownClass:
    identity: int
    code: Code  # from where the car is
    missed: int = 0  # cycles since it was found


def _no_nodes() -> Floats:
    return np.empty((0, 3))


@dataclass(frozen=True, slots=True, kw_only=True)
class GuidanceState:
    chance: int  # state of the random numbers
    nodes: Floats = field(default_factory=_no_nodes)  # (n, 3) x_m, y_m, stage: best first
    classes: tuple[KnownClass, ...] = ()  # of the last cycle, best first, and some from before
    phases: tuple[tuple[int, float], ...] = ()  # track number and the car's bearing from there, as winding.phase counts it
    next_identity: int = 0


def initial_state(seed: int) -> GuidanceState:
    return GuidanceState(chance=seed % 2**64)
