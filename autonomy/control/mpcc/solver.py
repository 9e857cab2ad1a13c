"""The optimal control problem of one cycle: Gauss-Newton on rolled-out trajectories, a Riccati recursion per step. Pure.

States always obey the model: a step goes backward for gains and forward through the model with them, shortened until the cost
falls (Li, Todorov, ICINCO 2004; limits as barriers in the cost, cost.py). So what comes out after any number of steps can be
driven, and a few a cycle are enough, from the last cycle's inputs (real-time iteration). Rates, and with them angle and force,
are cut to their limits exactly.
"""

from typing import NamedTuple

import numpy as np

from autonomy.control.mpcc.cost import Limits, Task, expand
from autonomy.control.mpcc.model import step
from autonomy.control.mpcc.stages import ANGLE, INPUTS, JERK, PROGRESS, PUSH, RATE, SIZE, STAGE_S, STAGES, STATES, STATION
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel, is_number
from autonomy.planning.mpc.line import piece_of

PROMISE = 1e-4  # share of the promised decrease that has to come
SHORTEST = 1.0 / 16.0  # of a step
SETTLED = 1e-5  # a promise of less than this share of the cost is not worth another step
LEAST_PIVOT = 1e-9


class Course(NamedTuple):
    """States and inputs over the horizon, with what the next step needs to know around them."""

    z: Floats  # (N + 1, 12) states and inputs; the last has no inputs
    dynamics: Floats  # (N, 9, 12)
    gradients: Floats  # (N + 1, 12)
    hessians: Floats  # (N + 1, 12, 12)


class Solved(NamedTuple):
    cost: float  # infinite or NaN: none was found
    iterations: int
    settled: bool


@fast_kernel
def room_for() -> Course:
    n = STAGES + 1
    return Course(np.zeros((n, SIZE)), np.zeros((STAGES, STATES, SIZE)), np.zeros((n, SIZE)), np.zeros((n, SIZE, SIZE)))


@fast_kernel
def optimise(start: Floats, inputs: Floats, task: Task, iterations_max: int) -> tuple[Solved, Floats]:
    """From a start (9,) with inputs (N, 3) as a guess; z (N + 1, 12)."""
    now, trial = room_for(), room_for()
    gains, leads = np.zeros((STAGES, INPUTS, STATES)), np.zeros((STAGES, INPUTS))
    now.z[:STAGES, STATES:] = inputs
    now.z[0, :STATES] = start
    trial.z[0, :STATES] = start
    cost = roll(now.z, gains, leads, 0.0, task, now)
    iterations, settled = 0, False
    while iterations < iterations_max and not settled and is_number(cost):
        iterations += 1
        promise = backward(now, gains, leads)
        if not promise <= 0.0:
            break
        settled = -promise < SETTLED * (1.0 + cost)
        length = 1.0
        while length >= SHORTEST:
            after = roll(now.z, gains, leads, length, task, trial)
            if after <= cost + PROMISE * length * promise:
                break
            length /= 2.0
        if length < SHORTEST:
            break
        now, trial, cost = trial, now, after
    return Solved(cost, iterations, settled), now.z


@fast_kernel
def roll(before: Floats, gains: Floats, leads: Floats, length: float, task: Task, out: Course) -> float:
    """Through the model from out's start, a step of this length away from the trajectory `before`; its cost."""
    z, row, total = out.z, np.zeros(SIZE), 0.0
    piece = piece_of(task.line, z[0, STATION], 0)
    for k in range(STAGES + 1):
        if k < STAGES:
            for i in range(INPUTS):
                wanted = before[k, STATES + i] + length * leads[k, i]
                for j in range(STATES):
                    wanted += gains[k, i, j] * (z[k, j] - before[k, j])
                z[k, STATES + i] = wanted
            into_limits(z[k], task.limits)
            step(z[k, :STATES], z[k, STATES:], STAGE_S, task.car, z[k + 1, :STATES], out.dynamics[k])
        cost, piece = expand(k, z[k], piece, task, row, out.gradients[k], out.hessians[k])
        total += cost
    return total


@fast_kernel
def into_limits(z: Floats, limits: Limits) -> None:
    """Rates that keep angle and force inside their limits a stage on, and are not above their own; progress is never backward."""
    rate = min(max(z[RATE], (-limits.angle - z[ANGLE]) / STAGE_S), (limits.angle - z[ANGLE]) / STAGE_S)
    jerk = min(max(z[JERK], (limits.push_low - z[PUSH]) / STAGE_S), (limits.push_high - z[PUSH]) / STAGE_S)
    z[RATE] = min(max(rate, -limits.rate), limits.rate)
    z[JERK] = min(max(jerk, -limits.jerk), limits.jerk)
    z[PROGRESS] = max(z[PROGRESS], 0.0)


@fast_kernel
def backward(course: Course, gains: Floats, leads: Floats) -> float:
    """Gains and leads of the step, and how much less it promises to cost (below zero); NaN: there is none."""
    value, price = course.hessians[STAGES, :STATES, :STATES].copy(), course.gradients[STAGES, :STATES].copy()
    ways, q, slope, promise = np.empty((STATES, SIZE)), np.empty((SIZE, SIZE)), np.empty(SIZE), 0.0
    for k in range(STAGES - 1, -1, -1):
        q[:] = course.hessians[k]
        slope[:] = course.gradients[k]
        add_cost_to_go(course.dynamics[k], value, price, ways, q, slope)
        share = eliminate(q, slope, gains[k], leads[k])
        if not share <= 0.0:
            return np.nan
        promise += share
        hand_back(q, slope, gains[k], leads[k], value, price)
    return promise


@fast_kernel
def add_cost_to_go(ab: Floats, value: Floats, price: Floats, ways: Floats, q: Floats, slope: Floats) -> None:
    for i in range(STATES):
        ways[i] = 0.0
        for m in range(STATES):
            for j in range(SIZE):
                ways[i, j] += value[i, m] * ab[m, j]
    for m in range(STATES):
        for i in range(SIZE):
            a = ab[m, i]
            if a != 0.0:
                slope[i] += a * price[m]
                for j in range(SIZE):
                    q[i, j] += a * ways[m, j]


@fast_kernel
def hand_back(q: Floats, slope: Floats, gain: Floats, lead: Floats, value: Floats, price: Floats) -> None:
    """The cost to go of the stage itself, its inputs gone."""
    for i in range(STATES):
        price[i] = slope[i]
        for m in range(INPUTS):
            price[i] += q[i, STATES + m] * lead[m]
        for j in range(STATES):
            value[i, j] = q[i, j]
            for m in range(INPUTS):
                value[i, j] += q[i, STATES + m] * gain[m, j]


@fast_kernel
def eliminate(q: Floats, slope: Floats, gain: Floats, lead: Floats) -> float:
    """The inputs that minimise a stage with its cost to go; by how much their lead lowers it (NaN: no minimum)."""
    r, j, p = STATES, STATES + 1, STATES + 2
    a = q[r, r]
    l1, l2 = q[j, r] / a, q[p, r] / a
    b = q[j, j] - l1 * q[j, r]
    l3 = (q[p, j] - l2 * q[j, r]) / b
    c = q[p, p] - l2 * q[p, r] - l3 * (q[p, j] - l2 * q[j, r])
    if not (a > LEAST_PIVOT and b > LEAST_PIVOT and c > LEAST_PIVOT):
        return np.nan
    for column in range(STATES + 1):
        if column < STATES:
            x, y, w = q[r, column], q[j, column], q[p, column]
        else:
            x, y, w = slope[r], slope[j], slope[p]
        y -= l1 * x
        w -= l2 * x + l3 * y
        w = w / c
        y = y / b - l3 * w
        x = x / a - l1 * y - l2 * w
        if column < STATES:
            gain[0, column], gain[1, column], gain[2, column] = -x, -y, -w
        else:
            lead[0], lead[1], lead[2] = -x, -y, -w
    return float(slope[r] * lead[0] + slope[j] * lead[1] + slope[p] * lead[2]) / 2.0
