"""The quadratic programme with its inequalities: Mehrotra's predictor and corrector on the Riccati recursion. Pure.

min g'z + z'Hz / 2, next state = dynamics, margin + C z = t, t >= 0 with multipliers lam >= 0. Infeasible start, one step length
for both (Nocedal, Wright, Numerical Optimization, 16.6). Bounds are the first nine rows of a stage, slack enters each other row.
"""

from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc import riccati
from autonomy.planning.mpc.problem import STAGES
from autonomy.planning.mpc.quadratic import ALL_BOUNDS, BOUNDS, SIZE, Quadratic
from autonomy.planning.mpc.riccati import Factor, factorise

NEAREST = 0.999  # of the way to the boundary
LEAST_START = 0.01  # a margin starts no smaller
COLD = 1.0  # product of margin and multiplier that is started with, in units of cost
WARM = 1e-2
WIDTH = 16  # of the lists that a maximum is gathered in


class Iterate(NamedTuple):
    """(I,) are the inequalities in the order of `Quadratic.margins`."""

    z: Floats  # (K, 9)
    slack: Floats  # (I,) t
    multiplier: Floats  # (I,) lam
    slack_step: Floats  # (I,)
    multiplier_step: Floats  # (I,)
    residual: Floats  # (I,) margin + C z - t
    inverse: Floats  # (I,) 1 / t
    weight: Floats  # (I,) lam / t
    product: Floats  # (I,) lam t, then with the corrector's part
    along: Floats  # (I,) room: C times something, or what C' is applied to
    kept: Floats  # (I,) multipliers of rows by their owner
    rhs: Floats  # (K, 9)
    slope: Floats  # (K, 9) g + H z
    step: Floats  # (K, 9)
    defects: Floats  # (N, 6)
    lead: Floats  # (K, 3)


@fast_kernel
def room_for(q: Quadratic) -> Iterate:
    most = q.margins.shape[0]
    t, zs = np.zeros((10, most)), np.zeros((4, STAGES, SIZE))
    return Iterate(
        zs[0], t[0], t[1], t[2], t[3], t[4], t[5], t[6], t[7], t[8], t[9], zs[1], zs[2], zs[3],
        np.zeros(q.defects.shape), np.zeros((STAGES, 3)),
    )  # fmt: skip


@fast_kernel
def minimise(q: Quadratic, f: Factor, it: Iterate, is_warm: bool, tolerance: float, steps_max: int) -> int:
    """it.z of the programme q, within a tolerance of margins (their unit) and products (cost). Returns the steps it took."""
    begin(q, it, is_warm)
    taken = 0
    while taken < steps_max:
        mean, worst = residuals(q, it)
        if not (mean >= tolerance or worst >= tolerance):  # NaN ends it too: whoever called looks at the result
            break
        assemble(q, f, it)
        factorise(q.jacobians, it.defects, f)
        primal, dual = direction(q, f, it)
        centring = (affine(q, it, min(primal, 1.0), min(dual, 1.0)) / mean) ** 3
        correct(q, it, centring * mean)
        primal, dual = direction(q, f, it)
        advance(q, it, min(NEAREST * min(primal, dual), 1.0))
        taken += 1
    for r in range(q.begins[STAGES]):
        it.kept[q.owners[r]] = it.multiplier[ALL_BOUNDS + r]
    return taken


@fast_kernel
def size(q: Quadratic) -> int:
    return ALL_BOUNDS + int(q.begins[STAGES])


@fast_kernel
def begin(q: Quadratic, it: Iterate, is_warm: bool) -> None:
    it.z[:] = 0.0
    it.defects[:] = q.defects
    for r in range(q.begins[STAGES]):
        it.multiplier[ALL_BOUNDS + r] = it.kept[q.owners[r]]
    for i in range(size(q)):
        t = max(q.margins[i], LEAST_START)
        it.slack[i] = t
        it.multiplier[i] = max(it.multiplier[i], WARM / t) if is_warm else COLD / t


@fast_kernel
def times(q: Quadratic, z: Floats, out: Floats) -> None:
    """C z."""
    slopes, rows = q.slopes, out[ALL_BOUNDS:]
    for k in range(STAGES):
        at = k * BOUNDS
        out[at], out[at + 1], out[at + 2], out[at + 3], out[at + 4] = z[k, 0], -z[k, 0], z[k, 1], -z[k, 1], z[k, 2]
        out[at + 5], out[at + 6], out[at + 7], out[at + 8] = z[k, 6], -z[k, 6], z[k, 7], -z[k, 7]
        slack, x, y, heading, station = z[k, 2], z[k, 3], z[k, 4], z[k, 5], z[k, 8]
        for r in range(q.begins[k], q.begins[k + 1]):
            rows[r] = slack + slopes[0, r] * x + slopes[1, r] * y + slopes[2, r] * heading + slopes[3, r] * station


@fast_kernel
def add_transposed(q: Quadratic, y: Floats, out: Floats) -> None:
    """Adds C' y."""
    slopes, rows = q.slopes, y[ALL_BOUNDS:]
    for k in range(STAGES):
        at = k * BOUNDS
        out[k, 0] += y[at] - y[at + 1]
        out[k, 1] += y[at + 2] - y[at + 3]
        out[k, 6] += y[at + 5] - y[at + 6]
        out[k, 7] += y[at + 7] - y[at + 8]
        slack, by_x, by_y, by_heading, by_station = y[at + 4], 0.0, 0.0, 0.0, 0.0
        for r in range(q.begins[k], q.begins[k + 1]):
            slack += rows[r]
            by_x += slopes[0, r] * rows[r]
            by_y += slopes[1, r] * rows[r]
            by_heading += slopes[2, r] * rows[r]
            by_station += slopes[3, r] * rows[r]
        out[k, 2] += slack
        out[k, 3] += by_x
        out[k, 4] += by_y
        out[k, 5] += by_heading
        out[k, 8] += by_station


@fast_kernel
def residuals(q: Quadratic, it: Iterate) -> tuple[float, float]:
    """Fills what depends on the iterate alone; the mean product of slack and multiplier, and the worst residual."""
    times(q, it.z, it.along)
    total = 0.0
    for i in range(size(q)):
        t = it.slack[i]
        it.residual[i] = q.margins[i] + it.along[i] - t
        it.inverse[i] = 1.0 / t
        it.weight[i] = it.multiplier[i] * it.inverse[i]
        it.product[i] = it.multiplier[i] * t
        it.along[i] = abs(it.residual[i])
        total += it.product[i]
    for k in range(STAGES):
        slope(q.hessians[k], q.gradients[k], it.z[k], it.slope[k])
    worst = largest(it.along, size(q))
    for k in range(it.defects.shape[0]):
        for i in range(6):
            worst = max(worst, abs(it.defects[k, i]))
    return total / size(q), worst


@fast_kernel
def largest(values: Floats, count: int) -> float:
    """Of values >= 0. In lists of their own, which the processor compares side by side."""
    most = np.zeros(WIDTH)
    whole = count - count % WIDTH
    for i in range(0, whole, WIDTH):
        for j in range(WIDTH):
            most[j] = values[i + j] if values[i + j] > most[j] else most[j]
    for i in range(whole, count):
        most[0] = max(most[0], values[i])
    return float(most.max())


@fast_kernel
def slope(hessian: Floats, gradient: Floats, z: Floats, out: Floats) -> None:
    """g + H z; the inputs' block of H is diagonal and has no other."""
    for i in range(3):
        out[i] = gradient[i] + hessian[i, i] * z[i]
    for i in range(3, SIZE):
        out[i] = gradient[i]
        for j in range(3, SIZE):
            out[i] += hessian[i, j] * z[j]


@fast_kernel
def assemble(q: Quadratic, f: Factor, it: Iterate) -> None:
    """H + C' (lam / t) C into the factor's matrices."""
    f.matrices[:] = q.hessians
    weight = it.weight
    for k in range(STAGES):
        m, at = f.matrices[k], k * BOUNDS
        m[0, 0] += weight[at] + weight[at + 1]
        m[1, 1] += weight[at + 2] + weight[at + 3]
        m[2, 2] += weight[at + 4]
        m[6, 6] += weight[at + 5] + weight[at + 6]
        m[7, 7] += weight[at + 7] + weight[at + 8]
        add_rows(q.slopes, weight[ALL_BOUNDS:], q.begins[k], q.begins[k + 1], m)


@fast_kernel
def add_rows(c: Floats, weight: Floats, first: int, end: int, m: Floats) -> None:
    ss = sx = sy = sh = st = xx = xy = yy = xh = yh = hh = xt = yt = ht = tt = 0.0
    for r in range(first, end):
        w = weight[r]
        x, y, h, t = w * c[0, r], w * c[1, r], w * c[2, r], w * c[3, r]
        ss, sx, sy, sh, st = ss + w, sx + x, sy + y, sh + h, st + t
        xx, xy, xh, xt = xx + x * c[0, r], xy + x * c[1, r], xh + x * c[2, r], xt + x * c[3, r]
        yy, yh, yt = yy + y * c[1, r], yh + y * c[2, r], yt + y * c[3, r]
        hh, ht, tt = hh + h * c[2, r], ht + h * c[3, r], tt + t * c[3, r]
    m[2, 2] += ss
    m[3, 2], m[4, 2], m[5, 2], m[8, 2] = m[3, 2] + sx, m[4, 2] + sy, m[5, 2] + sh, m[8, 2] + st
    m[3, 3], m[4, 3], m[4, 4] = m[3, 3] + xx, m[4, 3] + xy, m[4, 4] + yy
    m[5, 3], m[5, 4], m[5, 5] = m[5, 3] + xh, m[5, 4] + yh, m[5, 5] + hh
    m[8, 3], m[8, 4], m[8, 5], m[8, 8] = m[8, 3] + xt, m[8, 4] + yt, m[8, 5] + ht, m[8, 8] + tt


@fast_kernel
def direction(q: Quadratic, f: Factor, it: Iterate) -> tuple[float, float]:
    """The Newton step for the products as they stand; how far slacks and multipliers may follow it, of all of it."""
    for i in range(size(q)):
        it.along[i] = it.weight[i] * it.residual[i] + it.product[i] * it.inverse[i] - it.multiplier[i]
    it.rhs[:] = it.slope
    add_transposed(q, it.along, it.rhs)
    riccati.solve(q.jacobians, it.defects, it.rhs, f, it.lead, it.step)
    times(q, it.step, it.slack_step)
    for i in range(size(q)):
        it.slack_step[i] += it.residual[i]
        it.multiplier_step[i] = -(it.weight[i] * it.slack_step[i] + it.product[i] * it.inverse[i])
        it.along[i] = max(-it.slack_step[i] * it.inverse[i], 0.0)
    primal = 1.0 / max(largest(it.along, size(q)), 1e-9)
    for i in range(size(q)):
        it.along[i] = max(-it.multiplier_step[i] / it.multiplier[i], 0.0)
    return primal, 1.0 / max(largest(it.along, size(q)), 1e-9)


@fast_kernel
def affine(q: Quadratic, it: Iterate, primal: float, dual: float) -> float:
    """Mean of the products after the predictor's longest step."""
    total = 0.0
    for i in range(size(q)):
        total += (it.slack[i] + primal * it.slack_step[i]) * (it.multiplier[i] + dual * it.multiplier_step[i])
    return total / size(q)


@fast_kernel
def correct(q: Quadratic, it: Iterate, target: float) -> None:
    """The corrector's products: the predictor's second order, and the centre they are drawn to."""
    for i in range(size(q)):
        it.product[i] += it.slack_step[i] * it.multiplier_step[i] - target


@fast_kernel
def advance(q: Quadratic, it: Iterate, length: float) -> None:
    for k in range(STAGES):
        for i in range(SIZE):
            it.z[k, i] += length * it.step[k, i]
    for k in range(it.defects.shape[0]):
        for i in range(6):
            it.defects[k, i] *= 1.0 - length
    for i in range(size(q)):
        it.slack[i] += length * it.slack_step[i]
        it.multiplier[i] += length * it.multiplier_step[i]
