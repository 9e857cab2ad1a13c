"""One problem of the local planner: what is asked, whether it can be asked, and as the arrays that the kernels read. Pure."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from msgspec.structs import astuple

from autonomy.car_shape import CarShape
from autonomy.planning.horizon import STEP_S, STEPS, CarState, Floats, Predictions
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.bicycle import SPEED
from autonomy.planning.mpc.line import table
from autonomy.planning.mpc.outline import outline
from autonomy.planning.mpc.people import FLAWS, REACH_M, flaw, person_table
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.reference_path import ReferencePath

STAGES = STEPS + 1
FREE = 1e3  # bound of what is not bounded: at stage 0, which is given
PEOPLE_MAX = 64  # ours: the work grows with them
BACK_SHARE = 0.5  # of what the actuators can do: with so much a speed or angle beyond its bound comes back to it


@dataclass(frozen=True, slots=True, kw_only=True)
class Problem:
    """`sides`: half-spaces of a topology (halfspaces.py), none for the planner without guidance."""

    car: CarShape
    start: CarState
    path: ReferencePath
    predictions: Predictions | None  # None: nobody looked. Nobody there is a Predictions of nobody.
    speed_m_s: float  # asked for
    sides: Floats | None = None  # (STEPS + 1, n, 3): x * a + y * b <= c


class Arrays(NamedTuple):
    """What the kernels read: K stages, n people, m half-spaces a stage."""

    start: Floats  # (6,)
    line: Floats  # (M + 1, 13) see line.py
    people: Floats  # (K, n, 7)
    sides: Floats  # (K, m, 3)
    low: Floats  # (K, 5): acceleration, rate, slack, speed, angle
    high: Floats  # (K, 5)
    weights: Floats  # (8,) in the order of `settings.Weights`
    speed: float
    disc_rear: float  # of the discs' middles
    disc_front: float
    rear: float  # of the body
    front: float
    half_width: float
    wheelbase: float


def refusal(problem: Problem) -> str:
    """Why this cannot be asked at all; "" when it can."""
    people = problem.predictions
    if people is None:
        return "no predictions"
    if not _is_within(state_of(problem.start)) or not np.isfinite(problem.speed_m_s):
        return "the start or the speed asked for is no number"
    return path_refused(problem.path) or people_refused(people) or _sides_refused(problem.sides, people.count)


def path_refused(path: ReferencePath) -> str:
    knots = path.knots_m.shape
    cubics = (knots[0] - 1, 4)
    if knots[0] < 2 or (path.x_coefficients.shape, path.y_coefficients.shape) != (cubics, cubics):
        return "the path has no pieces, or not one fewer than knots"
    if (path.room_left_m.shape, path.room_right_m.shape) != (knots, knots):
        return "the path's room is not told at its knots"
    if not (_is_within(table(path)) and (np.diff(path.knots_m) > 0.0).all()):
        return "the path is no line of numbers whose knots grow"
    return ""


def people_refused(people: Predictions) -> str:
    n = people.count
    shapes = people.positions_m.shape, people.covariances_m2.shape, people.radii_m.shape
    if shapes != ((STAGES, n, 2), (STAGES, n, 2, 2), (n,)):
        return f"predictions are not {STAGES} stages of {n}"
    if n > PEOPLE_MAX:
        return f"more than {PEOPLE_MAX} predictions"
    return FLAWS[flaw(_own(people.positions_m), _own(people.covariances_m2), _own(people.radii_m))]


def _sides_refused(sides: Floats | None, count: int) -> str:
    if sides is None:
        return ""
    if sides.shape != (STAGES, count, 3):
        return f"half-spaces are not {STAGES} stages of {count}"
    return "" if _is_within(sides) else "half-spaces are no numbers"


def _is_within(values: Floats) -> bool:
    return bool((np.abs(values) <= REACH_M).all())  # not for NaN


def state_of(start: CarState) -> Floats:
    return np.array(
        (start.x_m, start.y_m, start.heading_rad, start.speed_m_s, start.road_wheel_angle_rad, start.station_m), dtype=np.float64
    )


def arrays(problem: Problem, settings: MpcSettings) -> Arrays:
    """Of a problem that is not refused. All of it copies: contiguous and writable, one type for the kernels."""
    people, car = problem.predictions, problem.car
    assert people is not None  # for the type checker
    start, discs = state_of(problem.start), outline(car)
    low, high = bounds(start, car, settings)
    return Arrays(
        start=start,
        line=table(problem.path),
        people=people_of(people, discs.radius_m + settings.tolerance_m, settings.risk),
        sides=np.empty((STAGES, 0, 3)) if problem.sides is None else _own(problem.sides),
        low=low,
        high=high,
        weights=np.array(astuple(settings.weights), dtype=np.float64),
        speed=float(problem.speed_m_s),
        disc_rear=discs.rear_m,
        disc_front=discs.front_m,
        rear=-car.rear_m,
        front=car.front_m,
        half_width=car.half_width_m,
        wheelbase=car.wheelbase_m,
    )


def people_of(people: Predictions, kept_off_m: float, risk: float) -> Floats:
    return person_table(_own(people.positions_m), _own(people.covariances_m2), _own(people.radii_m), kept_off_m, risk)


def _own(values: Floats) -> Floats:
    """A contiguous copy that may be written: one type for the kernels, whatever it was."""
    return np.array(values, dtype=np.float64, order="C")


def bounds(start: Floats, car: CarShape, settings: MpcSettings) -> tuple[Floats, Floats]:
    """Low and high (K, 5) of acceleration, rate, slack, speed, angle. What the start has beyond a bound comes back in its time."""
    rate, angle = settings.steering_rate_max_rad_s, car.road_wheel_angle_max_rad
    low = np.array((-settings.deceleration_max_m_s2, -rate, 0.0, 0.0, -angle))
    high = np.array((settings.acceleration_max_m_s2, rate, FREE, settings.speed_max_m_s, angle))
    return widened(start, low, high)


@fast_kernel
def widened(start: Floats, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Bounds (5,) at every stage, with a share of the inputs' own for the way back of speed and angle."""
    lows, highs = np.empty((STAGES, 5)), np.empty((STAGES, 5))
    for k in range(STAGES):
        lows[k], highs[k] = low, high
        for i in range(2):
            state, passed = start[SPEED + i], BACK_SHARE * k * STEP_S
            highs[k, 3 + i] = max(high[3 + i], state + passed * low[i]) if k > 0 else FREE
            lows[k, 3 + i] = min(low[3 + i], state + passed * high[i]) if k > 0 else -FREE
    return lows, highs
