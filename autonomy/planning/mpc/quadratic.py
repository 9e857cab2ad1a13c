"""The problem around one trajectory: cost, defects and rows, and their quadratic programme (Gauss-Newton). Pure, no hidden state.

A stage's variables z (9,): acceleration, rate, slack | x, y, heading, speed, angle, station; the programme seeks their change.
Cost (the paper, (1a)): contour, lag and speed at stages 1..N, acceleration and steering rate at 0..N-1, angle to the path at N.
One slack a stage softens all its rows, so a programme always has a solution; it is set to the least that the rows need.
"""

from math import atan2, cos, sin
from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEPS, Floats, Integers
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.bicycle import HEADING, SPEED, STATION, step
from autonomy.planning.mpc.line import Spot, piece_of, spot
from autonomy.planning.mpc.problem import STAGES, Arrays
from autonomy.planning.mpc.rows import ROAD_ROWS, people_rows, road_rows

SIZE = 9
BOUNDS = 9  # a stage: both of acceleration, rate; slack from below; both of speed, angle
ALL_BOUNDS = STAGES * BOUNDS
LITTLE = 1e-6  # on the diagonal: what costs nothing is not moved


class Quadratic(NamedTuple):
    """Inequalities stand in one list: the bounds of all stages, then the rows of all stages, R of them at most."""

    jacobians: Floats  # (K, 3, 5) see bicycle.step
    defects: Floats  # (N, 6): where the dynamics lead, minus the next state
    hessians: Floats  # (K, 9, 9)
    gradients: Floats  # (K, 9)
    slopes: Floats  # (4, R) of rows, by x, y, heading, station; by the slack it is 1
    margins: Floats  # (ALL_BOUNDS + R,): of bounds, then of rows with their slack
    owners: Integers  # (R,) whose row it is, alike in every programme
    begins: Integers  # (K + 1,) first row of a stage; the last tells how many there are


class Merit(NamedTuple):
    cost: float  # without slack
    penalty: float  # for slack
    defect: float  # sum of absolute values


@fast_kernel
def room_for(p: Arrays) -> Quadratic:
    most = STAGES * (ROAD_ROWS + p.people.shape[1] + p.sides.shape[1])
    return Quadratic(
        np.zeros((STAGES, 3, 5)),
        np.zeros((STEPS, 6)),
        np.zeros((STAGES, SIZE, SIZE)),
        np.zeros((STAGES, SIZE)),
        np.zeros((4, most)),
        np.zeros(ALL_BOUNDS + most),
        np.zeros(most, np.int64),
        np.zeros(STAGES + 1, np.int64),
    )


@fast_kernel
def expand(p: Arrays, states: Floats, inputs: Floats, q: Quadratic) -> Merit:
    """Fills q around states (K, 6) and inputs (K, 3); sets the slack, inputs[:, 2]. Of stage N's inputs only the slack counts."""
    q.hessians[:] = 0.0
    q.gradients[:] = 0.0
    cost, defect = input_cost(p.weights, inputs, q), 0.0
    penalty = 0.0
    row, piece, values = 0, 0, q.margins[ALL_BOUNDS:]
    for k in range(STAGES):
        state, first, least = states[k], row, 0.0
        if k > 0:
            c, s = cos(state[HEADING]), sin(state[HEADING])
            piece = piece_of(p.line, state[STATION], piece)
            cost += path_cost(
                spot(p.line, state[STATION], piece), k == STEPS, p.speed, p.weights, state, c, s, q.hessians[k], q.gradients[k]
            )
            least = road_rows(p, k, piece, state, c, s, row, values, q.slopes, q.owners)
            row, nearest = people_rows(p, k, state, c, s, row + ROAD_ROWS, values, q.slopes, q.owners)
            least = min(least, nearest)
        slack = max(-least, 0.0)
        inputs[k, 2] = slack
        for i in range(first, row):
            values[i] += slack
        penalty += slack_cost(p.weights, slack, q.hessians[k], q.gradients[k])
        q.begins[k + 1] = row
        if k < STEPS:
            step(state, inputs[k, 0], inputs[k, 1], p.wheelbase, q.defects[k], q.jacobians[k])
            for i in range(6):
                q.defects[k, i] -= states[k + 1, i]
                defect += abs(q.defects[k, i])
    bound(p, states, inputs, q.margins)
    return Merit(cost, penalty, defect)


@fast_kernel
def input_cost(weights: Floats, inputs: Floats, q: Quadratic) -> float:
    """Acceleration and steering rate; of stage N they do nothing and stay zero."""
    by_acceleration, by_rate, cost = weights[3], weights[4], 0.0
    for k in range(STAGES):
        q.hessians[k, 0, 0], q.hessians[k, 1, 1] = 2.0 * by_acceleration, 2.0 * by_rate
        q.gradients[k, 0], q.gradients[k, 1] = 2.0 * by_acceleration * inputs[k, 0], 2.0 * by_rate * inputs[k, 1]
        cost += by_acceleration * inputs[k, 0] * inputs[k, 0] + by_rate * inputs[k, 1] * inputs[k, 1]
    return cost


@fast_kernel
def slack_cost(weights: Floats, slack: float, hessian: Floats, gradient: Floats) -> float:
    hessian[2, 2] = 2.0 * weights[6]
    gradient[2] = 2.0 * weights[6] * slack + weights[7]
    cost: float = (weights[6] * slack + weights[7]) * slack
    return cost


@fast_kernel
def path_cost(
    at: Spot, is_last: bool, speed: float, weights: Floats, state: Floats, c: float, s: float, hessian: Floats, gradient: Floats
) -> float:
    """Of contour, lag, speed, and at the end of the preview: squares of residuals that are linear but for the path's bend."""
    tx, ty = at.tangent_x, at.tangent_y
    ex, ey = state[0] - at.x, state[1] - at.y
    aside, ahead = tx * ey - ty * ex, tx * ex + ty * ey
    square(hessian, gradient, weights[0], aside, -ty, tx, 0.0, -at.bend * ahead)
    square(hessian, gradient, weights[1], ahead, tx, ty, 0.0, at.bend * aside - at.stretch)
    faster = state[SPEED] - speed
    hessian[3 + SPEED, 3 + SPEED] += 2.0 * weights[2]
    gradient[3 + SPEED] += 2.0 * weights[2] * faster
    for i in range(3, SIZE):
        hessian[i, i] += LITTLE
    cost: float = weights[0] * aside * aside + weights[1] * ahead * ahead + weights[2] * faster * faster
    if is_last:
        angle = atan2(s * tx - c * ty, c * tx + s * ty)
        square(hessian, gradient, weights[5], angle, 0.0, 0.0, 1.0, -at.bend)
        cost += weights[5] * angle * angle
    return cost


@fast_kernel
def square(
    hessian: Floats, gradient: Floats, weight: float, value: float, by_x: float, by_y: float, by_heading: float, by_station: float
) -> None:
    """Adds weight * value^2, of which the derivatives are given."""
    by, at = (by_x, by_y, by_heading, by_station), (3, 4, 3 + HEADING, 3 + STATION)
    for i in range(4):
        gradient[at[i]] += 2.0 * weight * value * by[i]
        for j in range(4):
            hessian[at[i], at[j]] += 2.0 * weight * by[i] * by[j]


@fast_kernel
def bound(p: Arrays, states: Floats, inputs: Floats, margins: Floats) -> None:
    """How far each bound is away."""
    for k in range(STAGES):
        at = k * BOUNDS
        for i in range(2):
            margins[at + 2 * i], margins[at + 2 * i + 1] = inputs[k, i] - p.low[k, i], p.high[k, i] - inputs[k, i]
            state = states[k, SPEED + i]
            margins[at + 5 + 2 * i], margins[at + 6 + 2 * i] = state - p.low[k, 3 + i], p.high[k, 3 + i] - state
        margins[at + 4] = inputs[k, 2]
