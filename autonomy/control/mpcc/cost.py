"""What a stage costs, with slope and curvature (Gauss-Newton): errors of contour, lag and speed, rates, and every limit. Pure.

A limit is a margin g >= 0 that is 1 in the middle of what is allowed, and costs -b log g; below NEAR the logarithm goes on as a
parabola, so a limit that cannot be kept is no end of the world (relaxed barrier: Feller, Ebenbauer, IEEE TAC 62(8), 2017).
"""

from math import cos, log, sin
from typing import NamedTuple

from autonomy.control.mpcc.car import Car
from autonomy.control.mpcc.model import dynamic_weight
from autonomy.control.mpcc.stages import (
    ANGLE,
    ASIDE,
    HEADING,
    JERK,
    PROGRESS,
    PUSH,
    RATE,
    SIZE,
    SPEED,
    STAGES,
    STATION,
    TURN,
    X,
    Y,
)
from autonomy.control.mpcc.tyres import Axle, axles, slips
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel, kernel
from autonomy.planning.mpc.line import Spot, piece_of, spot

NEAR = 0.01  # of a margin
LEAST_SLOPE = 0.02  # share of the cornering stiffness: a tyre that slides wholly still shows the way back


class Limits(NamedTuple):
    rate: float
    jerk: float
    angle: float
    push_low: float
    push_high: float
    friction: float  # share of the circle


class Prices(NamedTuple):
    """In the order of `settings.Weights`."""

    contour: float
    lag: float
    speed: float
    rate: float
    jerk: float
    progress: float
    end: float
    closing: float
    barrier: float


class Task(NamedTuple):
    line: Floats
    wanted: Floats  # (N + 1,) speeds
    car: Car
    limits: Limits
    prices: Prices


@kernel
def barrier(margin: float) -> tuple[float, float, float]:
    """-log of a margin with its slope and curvature, and what stands for it below NEAR."""
    if margin > NEAR:
        return -log(margin), -1.0 / margin, 1.0 / (margin * margin)
    over = (margin - 2.0 * NEAR) / NEAR
    return (over * over - 1.0) / 2.0 - log(NEAR), over / NEAR, 1.0 / (NEAR * NEAR)


@kernel
def bound(value: float, low: float, high: float, price: float, at: int, gradient: Floats, hessian: Floats) -> float:
    """Adds the price of being between two limits: its margin is a parabola."""
    half = (high - low) / 2.0
    share = (value - (high + low) / 2.0) / half
    cost, slope, curve = barrier(1.0 - share * share)
    by = -2.0 * share / half
    gradient[at] += price * slope * by
    hessian[at, at] += price * (curve * by * by - 2.0 * slope / (half * half))
    return price * cost


@fast_kernel
def add(error: float, price: float, row: Floats, gradient: Floats, hessian: Floats) -> float:
    """price * error^2 with the error's derivatives `row` (12,), which is emptied."""
    for i in range(SIZE):
        if row[i] != 0.0:
            scaled = 2.0 * price * row[i]
            gradient[i] += scaled * error
            for j in range(SIZE):
                hessian[i, j] += scaled * row[j]
    row[:] = 0.0
    return price * error * error


@fast_kernel
def expand(k: int, z: Floats, near: int, task: Task, row: Floats, gradient: Floats, hessian: Floats) -> tuple[float, int]:
    """The cost of stage k, and the piece of the line it is at; gradient (12,) and hessian (12, 12) are overwritten. row: room."""
    p, limits = task.prices, task.limits
    gradient[:] = 0.0
    hessian[:] = 0.0
    piece = piece_of(task.line, z[STATION], near)
    there = spot(task.line, z[STATION], piece)
    is_last = k == STAGES
    cost = from_path(z, there, p.contour * (p.end if is_last else 1.0), p.lag, row, gradient, hessian)
    row[SPEED] = 1.0
    cost += add(z[SPEED] - task.wanted[k], p.speed, row, gradient, hessian)
    cost += bound(z[ANGLE], -limits.angle, limits.angle, p.barrier, ANGLE, gradient, hessian)
    cost += bound(z[PUSH], limits.push_low, limits.push_high, p.barrier, PUSH, gradient, hessian)
    cost += grip(z, task, row, gradient, hessian)
    if is_last:
        return cost + closing(z, there, p.closing, row, gradient, hessian), piece
    row[PROGRESS], row[SPEED] = 1.0, -1.0
    cost += add(z[PROGRESS] - z[SPEED], p.progress, row, gradient, hessian)
    for at, price, limit in ((RATE, p.rate, limits.rate), (JERK, p.jerk, limits.jerk)):
        cost += price * z[at] * z[at] + bound(z[at], -limit, limit, p.barrier, at, gradient, hessian)
        gradient[at] += 2.0 * price * z[at]
        hessian[at, at] += 2.0 * price
    return cost, piece


@fast_kernel
def from_path(z: Floats, there: Spot, contour: float, lag: float, row: Floats, gradient: Floats, hessian: Floats) -> float:
    tx, ty = there.tangent_x, there.tangent_y
    dx, dy = z[X] - there.x, z[Y] - there.y
    aside, ahead = tx * dy - ty * dx, tx * dx + ty * dy
    row[X], row[Y], row[STATION] = -ty, tx, -there.bend * ahead
    cost = add(aside, contour, row, gradient, hessian)
    row[X], row[Y], row[STATION] = tx, ty, there.bend * aside - there.stretch
    return cost + add(ahead, lag, row, gradient, hessian)


@fast_kernel
def closing(z: Floats, there: Spot, price: float, row: Floats, gradient: Floats, hessian: Floats) -> float:
    """The rear axle's speed away from the path; without a bias in bends, as its heading would have."""
    c, s = cos(z[HEADING]), sin(z[HEADING])
    ahead, across = c * there.tangent_x + s * there.tangent_y, s * there.tangent_x - c * there.tangent_y
    turned = z[SPEED] * ahead - z[ASIDE] * across
    row[HEADING], row[SPEED], row[ASIDE], row[STATION] = turned, across, ahead, -there.bend * turned
    return add(z[SPEED] * across + z[ASIDE] * ahead, price, row, gradient, hessian)


@fast_kernel
def grip(z: Floats, task: Task, row: Floats, gradient: Floats, hessian: Floats) -> float:
    """Both axles' forces inside their share of the friction circle; as far as the tyres are modelled at this speed."""
    weight, weight_by_speed = dynamic_weight(z[SPEED])
    if weight == 0.0:
        return 0.0
    car = task.car
    f_slip, f_speed, f_aside, f_turn, f_angle, r_slip, r_speed, r_aside = slips(
        z[SPEED], z[ASIDE], z[TURN], z[ANGLE], car.wheelbase
    )
    front, rear = axles(f_slip, r_slip, z[PUSH], car)
    price, share = task.prices.barrier * weight, task.limits.friction
    by_slip = max(front.aside_by_slip, LEAST_SLOPE * car.front_stiffness)
    cost = inside(
        front, share, price, by_slip * f_speed, by_slip * f_aside, by_slip * f_turn, by_slip * f_angle, row, gradient, hessian
    )
    by_slip = max(rear.aside_by_slip, LEAST_SLOPE * car.rear_stiffness)
    cost += inside(rear, share, price, by_slip * r_speed, by_slip * r_aside, 0.0, 0.0, row, gradient, hessian)
    gradient[SPEED] += weight_by_speed * cost / weight
    return cost


@fast_kernel
def inside(
    axle: Axle,
    share: float,
    price: float,
    by_speed: float,
    by_aside: float,
    by_turn: float,
    by_angle: float,
    row: Floats,
    gradient: Floats,
    hessian: Floats,
) -> float:
    """Margin 1 - (along^2 + aside^2) / (share grip)^2 of one axle, whose lateral force has these derivatives."""
    one = 1.0 / (share * axle.grip)
    along, aside = axle.along * one, axle.aside * one
    cost, slope, curve = barrier(1.0 - along * along - aside * aside)
    shrinks = axle.grip_by_push / axle.grip
    along_by_push = axle.along_by_push * one - along * shrinks
    aside_by_push = axle.aside_by_push * one - aside * shrinks
    # The barrier's slope makes two squares of the forces, as `add` counts them; its curvature adds the whole margin's slope.
    bow = -price * slope
    row[SPEED], row[ASIDE], row[TURN], row[ANGLE] = by_speed * one, by_aside * one, by_turn * one, by_angle * one
    row[PUSH] = aside_by_push
    add(aside, bow, row, gradient, hessian)
    row[PUSH] = along_by_push
    add(along, bow, row, gradient, hessian)
    m = -2.0 * aside * one
    row[SPEED], row[ASIDE], row[TURN], row[ANGLE] = m * by_speed, m * by_aside, m * by_turn, m * by_angle
    row[PUSH] = -2.0 * (along * along_by_push + aside * aside_by_push)
    add(0.0, curve * price / 2.0, row, gradient, hessian)
    return price * cost
