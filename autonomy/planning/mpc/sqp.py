"""Sequential quadratic programming: expand, solve, step, as long as it pays. Pure; caps count iterations, never time.

Step length by an l1 merit: cost with the least slack that the rows need, and the defects of the dynamics at a price that every
programme may raise (Nocedal, Wright, 18.36). It must fall below the worst of the last three, by a share of what was promised.
At the end the states are rolled out from the inputs: what is returned obeys the dynamics exactly, and is judged as such.
"""

from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEPS, Floats
from autonomy.planning.kernels import fast_kernel, is_number
from autonomy.planning.mpc import interior_point, riccati
from autonomy.planning.mpc.bicycle import ANGLE, SPEED, step
from autonomy.planning.mpc.interior_point import Iterate, minimise
from autonomy.planning.mpc.problem import STAGES, Arrays
from autonomy.planning.mpc.quadratic import SIZE, Quadratic, expand, room_for

PROMISE = 1e-3  # share of the promised decrease that has to come
SHORTEST = 1.0 / 64.0  # of a step
SETTLED = 1e-4  # a promise of less than this share of the cost, with dynamics that hold as well, is not worth another programme
MEMORY = 3
LOOSE, TIGHT = 1e-2, 1e-4  # tolerances of the programmes: of the first, and of those that may be the last


class Result(NamedTuple):
    cost: float
    violation: float
    iterations: int
    steps: int
    settled: bool


@fast_kernel
def optimise(p: Arrays, states: Floats, inputs: Floats, iterations_max: int, steps_max: int) -> Result:
    """From states (K, 6) and inputs (K, 3) as a guess, in place: there the result stands."""
    q = room_for(p)
    f, it = riccati.room_for(), interior_point.room_for(q)
    into_bounds(p, states, inputs)
    now = expand(p, states, inputs, q)
    costs, defects = np.full(MEMORY, now.cost + now.penalty), np.full(MEMORY, now.defect)
    price, steps, iterations, settled = 1.0, 0, 0, False
    trial_states, trial_inputs = np.empty(states.shape), np.empty(inputs.shape)
    while iterations < iterations_max and steps < steps_max and not settled:
        steps += minimise(q, f, it, iterations > 0, LOOSE if iterations == 0 else TIGHT, steps_max - steps)
        iterations += 1
        change, curve = promised(p, q, it, inputs)
        if not is_number(change + curve):
            break
        if now.defect > 1e-9:
            price = max(price, (change + max(curve, 0.0) / 2.0) / (0.7 * now.defect))
        settled = change - price * now.defect > -SETTLED * (1.0 + now.cost) and now.defect < 1e-3
        length = 1.0
        while True:
            move(it, length, states, inputs, trial_states, trial_inputs)
            after = expand(p, trial_states, trial_inputs, q)
            wanted = np.max(costs + price * defects) + PROMISE * length * (change - price * now.defect)
            if after.cost + after.penalty + price * after.defect <= wanted or settled:
                break
            length /= 2.0
            if length < SHORTEST:
                break
        if length < SHORTEST:
            break
        states[:], inputs[:], now = trial_states, trial_inputs, after
        costs[iterations % MEMORY], defects[iterations % MEMORY] = now.cost + now.penalty, now.defect
    roll_out(p, states, inputs)
    now = expand(p, states, inputs, q)
    return Result(now.cost + now.penalty, violation(p, states, inputs), iterations, steps, settled)


@fast_kernel
def into_bounds(p: Arrays, states: Floats, inputs: Floats) -> None:
    """Whatever was guessed; the start is given."""
    states[0] = p.start
    for k in range(STAGES):
        for i in range(2):
            inputs[k, i] = min(max(inputs[k, i], p.low[k, i]), p.high[k, i]) if k < STEPS else 0.0
            states[k, SPEED + i] = min(max(states[k, SPEED + i], p.low[k, 3 + i]), p.high[k, 3 + i])


@fast_kernel
def promised(p: Arrays, q: Quadratic, it: Iterate, inputs: Floats) -> tuple[float, float]:
    """How cost and penalty would change to first order, and z'Hz, the second."""
    change, curve = 0.0, 0.0
    for k in range(STAGES):
        slack, after = inputs[k, 2], max(inputs[k, 2] + it.z[k, 2], 0.0)
        change += (p.weights[6] * (after + slack) + p.weights[7]) * (after - slack)
        interior_point.slope(q.hessians[k], q.gradients[k], it.z[k], it.slope[k])
        for i in range(SIZE):
            if i != 2:
                change += q.gradients[k, i] * it.z[k, i]
                curve += (it.slope[k, i] - q.gradients[k, i]) * it.z[k, i]
    return change, curve


@fast_kernel
def move(it: Iterate, length: float, states: Floats, inputs: Floats, to_states: Floats, to_inputs: Floats) -> None:
    for k in range(STAGES):
        for i in range(3):
            to_inputs[k, i] = inputs[k, i] + length * it.z[k, i]
        for i in range(6):
            to_states[k, i] = states[k, i] + length * it.z[k, 3 + i]


@fast_kernel
def roll_out(p: Arrays, states: Floats, inputs: Floats) -> None:
    unused = np.empty((3, 5))
    for k in range(STEPS):
        for i in range(2):
            inputs[k, i] = min(max(inputs[k, i], p.low[k, i]), p.high[k, i])
        step(states[k], inputs[k, 0], inputs[k, 1], p.wheelbase, states[k + 1], unused)


@fast_kernel
def violation(p: Arrays, states: Floats, inputs: Floats) -> float:
    """The largest: slack that rows need, or speed or angle beyond a bound."""
    worst = 0.0
    for k in range(STAGES):
        worst = max(worst, inputs[k, 2])
        for i, at in ((3, SPEED), (4, ANGLE)):
            worst = max(worst, p.low[k, i] - states[k, at], states[k, at] - p.high[k, i])
    return worst
