"""The local planner's problem once more, written for casadi from the equations alone: its oracle in tests, its peer in a benchmark.

The same arrays in (`autonomy.planning.mpc.problem.Arrays`), so the same path model; no code shared but their layout. Solved by
ipopt (mumps) or fatrop, from a guess of one's own.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from autonomy.planning.horizon import STEP_S, STEPS, Floats
from autonomy.planning.mpc.problem import Arrays

OPTIONS: dict[str, dict[str, Any]] = {
    "ipopt": {"print_time": 0, "ipopt.print_level": 0, "ipopt.sb": "yes", "ipopt.tol": 1e-6, "ipopt.max_iter": 300},
    "fatrop": {
        "print_time": 0,
        "fatrop.print_level": 0,
        "fatrop.tolerance": 1e-6,
        "fatrop.max_iter": 300,
        "structure_detection": "auto",
    },
}
# Stays where it is started: a barrier that is low already, and hardly a push away from bounds.
OPTIONS["ipopt, near"] = OPTIONS["ipopt"] | {
    "ipopt.mu_init": 1e-6,
    "ipopt.warm_start_init_point": "yes",
    "ipopt.warm_start_bound_push": 1e-8,
    "ipopt.warm_start_slack_bound_push": 1e-8,
}
SMALLEST_M2 = 1e-9  # of a distance, as in ours: the same problem


class Answer(NamedTuple):
    states: Floats  # (STEPS + 1, 6)
    cost: float
    slack: float
    converged: bool


Oracle = Callable[[Arrays, Floats, Floats], Answer]


class Shape(NamedTuple):
    """What a solver is built for; the numbers in it are parameters."""

    people: int
    sides: int
    knots: int


def shape_of(p: Arrays) -> Shape:
    return Shape(p.people.shape[1], p.sides.shape[1], len(p.line))


def oracle(name: str, like: Arrays) -> Oracle:
    """A solver for problems of the shape, car, weights and speed of one. It wants the guess: states (K, 6) and inputs (N, 2)."""
    shape = shape_of(like)
    variables, parameters = _Variables(), ca.SX.sym("p", _size(shape))
    stage_of = [_stage(k, shape, parameters) for k in range(STEPS + 1)]
    cost: Any = 0
    for k in range(STEPS + 1):
        state, wanted = variables.state(k), variables.inputs(k)
        cost += _cost(like, k, state, wanted, _line(parameters, shape.knots, state[5]))
        if k < STEPS:
            variables.equal(variables.state(k + 1) - _next(like, state, wanted))
        if k == 0:
            variables.equal(state - parameters[-6:])
        else:
            variables.least(_rows(like, state, wanted[2], *stage_of[k], parameters, shape.knots))
    programme = {"x": ca.vertcat(*variables.all), "f": cost, "g": ca.vertcat(*variables.rows), "p": parameters}
    options = dict(OPTIONS[name])
    if name == "fatrop":
        options["equality"] = variables.is_equal
    solver = ca.nlpsol("oracle", name.partition(",")[0], programme, options)
    high_of_rows = np.where(variables.is_equal, 0.0, np.inf)

    def solve(p: Arrays, states: Floats, inputs: Floats) -> Answer:
        low, high, first = _bounds(p, states, inputs)
        told = solver(x0=first, p=_numbers(p), lbx=low, ubx=high, lbg=0.0, ubg=high_of_rows)
        found = np.array(told["x"]).reshape(STEPS + 1, 9)
        below = np.minimum(found[:, 8], 0.0)  # both let a bound be missed by 1e-8, which here is paid for
        cost = float(told["f"]) - float(((p.weights[6] * below + p.weights[7]) * below).sum())
        return Answer(found[:, :6], cost, float(found[:, 8].max()), bool(solver.stats()["success"]))

    return solve


class _Variables:
    """Stage after stage: six states, three inputs, and the rows in the order in which fatrop wants them."""

    def __init__(self) -> None:
        self.all = [ca.SX.sym(f"z{k}", 9) for k in range(STEPS + 1)]
        self.rows: list[Any] = []
        self.is_equal: list[bool] = []

    def state(self, k: int) -> Any:
        return self.all[k][:6]

    def inputs(self, k: int) -> Any:
        return self.all[k][6:]

    def equal(self, row: Any) -> None:
        self.rows.append(row)
        self.is_equal += [True] * row.numel()

    def least(self, row: Any) -> None:
        self.rows.append(row)
        self.is_equal += [False] * row.numel()


def _size(shape: Shape) -> int:
    return shape.knots * 13 + (STEPS + 1) * (shape.people * 7 + shape.sides * 3) + 6


def _numbers(p: Arrays) -> Floats:
    return np.concatenate((p.line.ravel(), p.people.ravel(), p.sides.ravel(), p.start))


def _stage(k: int, shape: Shape, parameters: Any) -> tuple[list[Any], list[Any]]:
    first = shape.knots * 13
    people = [parameters[first + 7 * (k * shape.people + j) :][:7] for j in range(shape.people)]
    first += 7 * shape.people * (STEPS + 1)
    return people, [parameters[first + 3 * (k * shape.sides + j) :][:3] for j in range(shape.sides)]


def _bounds(p: Arrays, states: Floats, inputs: Floats) -> tuple[Floats, Floats, Floats]:
    low, high = np.full((STEPS + 1, 9), -np.inf), np.full((STEPS + 1, 9), np.inf)
    for k in range(STEPS + 1):
        if k > 0:
            low[k, 3:5], high[k, 3:5] = p.low[k, 3:], p.high[k, 3:]
        low[k, 6:8], high[k, 6:8] = (p.low[k, :2], p.high[k, :2]) if k < STEPS else (0.0, 0.0)
        low[k, 8] = 0.0
    first = np.zeros((STEPS + 1, 9))
    first[:, :6], first[:STEPS, 6:8] = states, inputs
    return low.ravel(), high.ravel(), first.ravel()


def _next(p: Arrays, state: Any, wanted: Any) -> Any:
    """Runge and Kutta's rule on the rear axle's bicycle."""

    def slope(x: Any) -> Any:
        turn = x[3] * ca.tan(x[4]) / p.wheelbase
        return ca.vertcat(x[3] * ca.cos(x[2]), x[3] * ca.sin(x[2]), turn, wanted[0], wanted[1], x[3])

    k1 = slope(state)
    k2 = slope(state + STEP_S / 2 * k1)
    k3 = slope(state + STEP_S / 2 * k2)
    k4 = slope(state + STEP_S * k3)
    return state + STEP_S / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def _line(parameters: Any, knots: int, station: Any) -> tuple[Any, ...]:
    """x, y, unit tangent, room left and right at a station; straight on beyond the ends."""
    rows = [parameters[13 * i : 13 * (i + 1)] for i in range(knots)]
    first, last = rows[0][0], rows[-1][0]
    inside = ca.fmin(ca.fmax(station, first), last)
    row = rows[0]
    for i in range(1, knots - 1):
        row = ca.if_else(inside >= rows[i][0], rows[i], row)
    d = inside - row[0]
    x, y = (((row[i] * d + row[i + 1]) * d + row[i + 2]) * d + row[i + 3] for i in (1, 5))
    dx, dy = ((3 * row[i] * d + 2 * row[i + 1]) * d + row[i + 2] for i in (1, 5))
    length = ca.sqrt(dx * dx + dy * dy)
    tx, ty, over = dx / length, dy / length, station - inside
    return x + over * tx, y + over * ty, tx, ty, row[9] + row[10] * d, row[11] + row[12] * d


def _cost(p: Arrays, k: int, state: Any, wanted: Any, line: tuple[Any, ...]) -> Any:
    contour, lag, speed, acceleration, rate, preview, slack, slack_linear = p.weights
    x, y, tx, ty, _, _ = line
    cost = slack * wanted[2] ** 2 + slack_linear * wanted[2]
    if k < STEPS:
        cost += acceleration * wanted[0] ** 2 + rate * wanted[1] ** 2
    if k > 0:
        ex, ey = state[0] - x, state[1] - y
        cost += contour * (tx * ey - ty * ex) ** 2 + lag * (tx * ex + ty * ey) ** 2 + speed * (state[3] - p.speed) ** 2
    if k == STEPS:
        sine, cosine = ca.sin(state[2]) * tx - ca.cos(state[2]) * ty, ca.cos(state[2]) * tx + ca.sin(state[2]) * ty
        cost += preview * ca.atan2(sine, cosine) ** 2
    return cost


def _rows(p: Arrays, state: Any, slack: Any, people: list[Any], sides: list[Any], parameters: Any, knots: int) -> Any:
    x, y, c, s = state[0], state[1], ca.cos(state[2]), ca.sin(state[2])
    found = []
    for along in (p.rear, (p.rear + p.front) / 2, p.front):
        at_x, at_y, tx, ty, left, right = _line(parameters, knots, state[5] + along)
        for sign, room in ((1, left), (-1, right)):
            corner_x, corner_y = x + along * c - sign * p.half_width * s, y + along * s + sign * p.half_width * c
            found.append(room - sign * (tx * (corner_y - at_y) - ty * (corner_x - at_x)))
    for person in people:
        qx, qy = person[0] - x, person[1] - y
        disc = ca.fmin(ca.fmax(c * qx + s * qy, p.disc_rear), p.disc_front)
        ex, ey = qx - disc * c, qy - disc * s
        distance = ca.sqrt(ex * ex + ey * ey + SMALLEST_M2)
        ax, ay = ex / distance, ey / distance
        spread = ca.sqrt(person[2] * ax * ax + 2 * person[3] * ax * ay + person[4] * ay * ay)
        found.append(distance - person[6] - person[5] * spread)
    found += [side[2] - side[0] * x - side[1] * y for side in sides]
    return ca.vertcat(*found) + slack
