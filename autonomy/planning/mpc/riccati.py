"""A quadratic programme with dynamics and no inequalities, solved stage by stage from the last to the first and back. Pure.

Textbook Riccati recursion (e.g. Rawlings, Mayne, Diehl, Model Predictive Control, 8.8.3). A stage's inputs are eliminated one
after the other: the slack touches neither dynamics nor the other two. The dynamics' zeros and ones are never multiplied.
"""

from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEP_S, STEPS, Floats
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.problem import STAGES
from autonomy.planning.mpc.quadratic import SIZE

H = STEP_S
HALF = H * H / 2.0


class Factor(NamedTuple):
    matrices: Floats  # (K, 9, 9) lower: hessians with the inequalities' part, then with the cost to go
    pivots: Floats  # (K, 4) inverse of acceleration's, rate's part of it, inverses of rate's and slack's
    couplings: Floats  # (K, 3, 6) of the inputs, as eliminated, with the states
    values: Floats  # (K, 6, 6) cost to go, symmetric
    pulls: Floats  # (N, 6) the next stage's cost to go times the defects
    ways: Floats  # (6, 9) values times dynamics, of one stage


@fast_kernel
def room_for() -> Factor:
    matrices, values = np.zeros((STAGES, SIZE, SIZE)), np.zeros((STAGES, 6, 6))
    return Factor(matrices, np.zeros((STAGES, 4)), np.zeros((STAGES, 3, 6)), values, np.zeros((STEPS, 6)), np.zeros((6, SIZE)))


@fast_kernel
def transposed(j: Floats, x: float, y: float, heading: float, speed: float, angle: float, station: float) -> tuple[float, ...]:
    """(6,) times the derivatives of the next state by z, without the slack: their zero."""
    return (
        x * j[0, 3] + y * j[1, 3] + heading * j[2, 3] + speed * H + station * HALF,
        x * j[0, 4] + y * j[1, 4] + heading * j[2, 4] + angle * H,
        x,
        y,
        x * j[0, 0] + y * j[1, 0] + heading,
        x * j[0, 1] + y * j[1, 1] + heading * j[2, 1] + speed + station * H,
        x * j[0, 2] + y * j[1, 2] + heading * j[2, 2] + angle,
        station,
    )


@fast_kernel
def factorise(jacobians: Floats, defects: Floats, f: Factor) -> None:
    for k in range(STEPS, -1, -1):
        m = f.matrices[k]
        if k < STEPS:
            add_cost_to_go(jacobians[k], f.values[k + 1], f.ways, m)
            for i in range(6):
                pull = 0.0
                for n in range(6):
                    pull += f.values[k + 1, i, n] * defects[k, n]
                f.pulls[k, i] = pull
        eliminate(m, f.pivots[k], f.couplings[k], f.values[k])


@fast_kernel
def add_cost_to_go(j: Floats, value: Floats, ways: Floats, m: Floats) -> None:
    for i in range(6):
        v = value[i]
        ways[i, 0], ways[i, 1], ways[i, 3], ways[i, 4], ways[i, 5], ways[i, 6], ways[i, 7], ways[i, 8] = transposed(
            j, v[0], v[1], v[2], v[3], v[4], v[5]
        )
    for c in (0, 1, 3, 4, 5, 6, 7, 8):
        t = transposed(j, ways[0, c], ways[1, c], ways[2, c], ways[3, c], ways[4, c], ways[5, c])
        m[0, c] += t[0]
        m[1, c] += t[1]
        for r in range(2, 8):
            m[r + 1, c] += t[r]


@fast_kernel
def eliminate(m: Floats, pivot: Floats, coupling: Floats, value: Floats) -> None:
    """The inputs out of m; the cost to go is what is left."""
    pivot[0] = 1.0 / m[0, 0]
    pivot[1] = m[1, 0] * pivot[0]
    pivot[2] = 1.0 / (m[1, 1] - pivot[1] * m[1, 0])
    pivot[3] = 1.0 / m[2, 2]
    for i in range(6):
        coupling[0, i] = m[3 + i, 0]
        coupling[1, i] = m[3 + i, 1] - pivot[1] * m[3 + i, 0]
        coupling[2, i] = m[3 + i, 2]
    for i in range(6):
        a, b, c = coupling[0, i] * pivot[0], coupling[1, i] * pivot[2], coupling[2, i] * pivot[3]
        for j in range(i + 1):
            left = m[3 + i, 3 + j] - a * coupling[0, j] - b * coupling[1, j] - c * coupling[2, j]
            value[i, j] = left
            value[j, i] = left


@fast_kernel
def solve(jacobians: Floats, defects: Floats, gradients: Floats, f: Factor, lead: Floats, z: Floats) -> None:
    """z (K, 9) that minimises with these gradients (K, 9) and the factor's defects (N, 6), from zero on. lead (K, 3): room."""
    price = np.zeros(6)  # of a change of the state, seen from behind
    for k in range(STEPS, -1, -1):
        g, pivot, coupling = gradients[k], f.pivots[k], f.couplings[k]
        a, b, c = g[0], g[1], g[2]
        x, y, heading, speed, angle, station = g[3], g[4], g[5], g[6], g[7], g[8]
        if k < STEPS:
            for i in range(6):
                price[i] += f.pulls[k, i]
            t = transposed(jacobians[k], price[0], price[1], price[2], price[3], price[4], price[5])
            a, b, x, y = a + t[0], b + t[1], x + t[2], y + t[3]
            heading, speed, angle, station = heading + t[4], speed + t[5], angle + t[6], station + t[7]
        b -= pivot[1] * a
        lead[k, 0], lead[k, 1], lead[k, 2] = a, b, c
        price[0], price[1], price[2], price[3], price[4], price[5] = x, y, heading, speed, angle, station
        a, b, c = a * pivot[0], b * pivot[2], c * pivot[3]
        for i in range(6):
            price[i] -= a * coupling[0, i] + b * coupling[1, i] + c * coupling[2, i]
    z[0, 3:] = 0.0
    for k in range(STAGES):
        choose(f.pivots[k], f.couplings[k], lead[k], z[k])
        if k < STEPS:
            forward(jacobians[k], defects[k], z[k], z[k + 1])


@fast_kernel
def choose(pivot: Floats, coupling: Floats, lead: Floats, z: Floats) -> None:
    """The inputs, once the state is known."""
    a, b, c = lead[0], lead[1], lead[2]
    for i in range(6):
        a += coupling[0, i] * z[3 + i]
        b += coupling[1, i] * z[3 + i]
        c += coupling[2, i] * z[3 + i]
    z[2] = -c * pivot[3]
    z[1] = -b * pivot[2]
    z[0] = -a * pivot[0] - pivot[1] * z[1]


@fast_kernel
def forward(j: Floats, defect: Floats, z: Floats, after: Floats) -> None:
    for i in range(3):
        after[3 + i] = defect[i] + z[3 + i] + j[i, 1] * z[6] + j[i, 2] * z[7] + j[i, 3] * z[0] + j[i, 4] * z[1]
    after[3] += j[0, 0] * z[5]
    after[4] += j[1, 0] * z[5]
    after[6] = defect[3] + z[6] + H * z[0]
    after[7] = defect[4] + z[7] + H * z[1]
    after[8] = defect[5] + z[8] + H * z[6] + HALF * z[0]
