"""The programme's solution against dense linear algebra, and against the conditions that a solution has to meet."""

import numpy as np

from autonomy.planning.horizon import STEP_S, STEPS, Floats
from autonomy.planning.mpc import interior_point, riccati
from autonomy.planning.mpc.guess import along
from autonomy.planning.mpc.problem import STAGES, arrays
from autonomy.planning.mpc.quadratic import ALL_BOUNDS, SIZE, Quadratic, expand, room_for
from autonomy.planning.mpc.settings import MpcSettings
from benchmarks.planner_crowd import Drive


def programme(people: int) -> Quadratic:
    """Around a guess through the crowd, so that rows are active and the dynamics do not hold."""
    asked = Drive(0, people).problem()
    assert asked.predictions is not None
    asked.predictions.positions_m[:] = (9.0, 2.0)  # all in one place on the line
    p = arrays(asked, MpcSettings())
    q, guess = room_for(p), along(p)
    inputs = np.zeros((STAGES, 3))
    inputs[:STEPS, 0] = np.random.default_rng(0).normal(0.0, 0.3, STEPS)
    expand(p, guess.states, inputs, q)
    return q


def dynamics(q: Quadratic) -> tuple[Floats, Floats]:
    """E z = -defects, dense: the next state's change is what this stage's changes make of it."""
    e = np.zeros((6 * STAGES, SIZE * STAGES))
    e[:6, 3:9] = np.eye(6)
    for k in range(STEPS):
        rows, a, b = slice(6 * k + 6, 6 * k + 12), np.eye(6), np.zeros((6, 3))
        a[:3, 2:5] = q.jacobians[k, :, :3]
        a[2, 2], a[5, 3] = 1.0, STEP_S
        b[:3, :2] = q.jacobians[k, :, 3:]
        b[3, 0], b[4, 1], b[5, 0] = STEP_S, STEP_S, STEP_S**2 / 2
        e[rows, SIZE * k : SIZE * k + 3], e[rows, SIZE * k + 3 : SIZE * k + 9] = -b, -a
        e[rows, SIZE * (k + 1) + 3 : SIZE * (k + 1) + 9] = np.eye(6)
    return e, np.concatenate((np.zeros(6), q.defects.ravel()))


def dense(matrices: Floats) -> Floats:
    """Of blocks."""
    h = np.zeros((SIZE * STAGES, SIZE * STAGES))
    for k in range(STAGES):
        h[SIZE * k : SIZE * (k + 1), SIZE * k : SIZE * (k + 1)] = matrices[k]
    return h


def test_without_inequalities_it_is_one_linear_system() -> None:
    q, f = programme(0), riccati.room_for()
    e, right = dynamics(q)
    h = dense(q.hessians)
    kkt = np.block([[h, e.T], [e, np.zeros((len(e), len(e)))]])
    expected = np.linalg.solve(kkt, np.concatenate((-q.gradients.ravel(), right)))[: SIZE * STAGES].reshape(STAGES, SIZE)
    f.matrices[:] = q.hessians
    riccati.factorise(q.jacobians, q.defects, f)
    z = np.zeros((STAGES, SIZE))
    riccati.solve(q.jacobians, q.defects, q.gradients, f, np.zeros((STAGES, 3)), z)
    assert np.allclose(z, expected, atol=1e-8)


def test_a_solution_meets_every_condition_of_one() -> None:
    """Dynamics, rows, signs, complementarity, and a gradient that is made of the constraints' own."""
    q = programme(4)
    f, it = riccati.room_for(), interior_point.room_for(q)
    assert interior_point.minimise(q, f, it, False, 1e-7, 60) < 40
    count = interior_point.size(q)
    e, right = dynamics(q)
    assert np.allclose(e @ it.z.ravel(), right, atol=1e-6)
    change = np.zeros_like(q.margins)
    interior_point.times(q, it.z, change)
    margins, prices = (q.margins + change)[:count], it.multiplier[:count]
    assert margins.min() > -1e-5 and prices.min() >= 0.0 and (margins * prices).max() < 1e-4
    assert prices[ALL_BOUNDS:].max() > 1.0  # somebody is in the way
    pull = np.zeros((STAGES, SIZE))
    interior_point.add_transposed(q, np.where(np.arange(len(q.margins)) < count, it.multiplier, 0.0), pull)
    gradient = dense(q.hessians) @ it.z.ravel() + q.gradients.ravel() - pull.ravel()
    free = np.linalg.lstsq(e.T, -gradient, rcond=None)[0]
    assert np.abs(e.T @ free + gradient).max() < 1e-4
