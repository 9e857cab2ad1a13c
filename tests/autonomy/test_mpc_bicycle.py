"""The bicycle against a circle, a thousand small steps and differences."""

from math import cos, sin, tan

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.horizon import STEP_S, Floats
from autonomy.planning.mpc.bicycle import step

WHEELBASE_M = 2.8
STATES = st.tuples(
    st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3), st.floats(0, 8), st.floats(-0.5, 0.5), st.floats(0, 50)
).map(np.array)
ACCELERATIONS, RATES = st.floats(-3, 3), st.floats(-1.5, 1.5)


def stepped(state: Floats, acceleration: float, rate: float) -> tuple[Floats, Floats]:
    after, jacobian = np.empty(6), np.empty((3, 5))
    step(np.array(state, dtype=np.float64), acceleration, rate, WHEELBASE_M, after, jacobian)
    return after, jacobian


def test_with_a_constant_angle_the_rear_axle_runs_on_a_circle() -> None:
    radius, run = WHEELBASE_M / tan(0.3), 2.0 * STEP_S
    after, _ = stepped(np.array([0.0, 0.0, 0.0, 2.0, 0.3, 0.0]), 0.0, 0.0)
    assert np.allclose(
        after, [radius * sin(run / radius), radius * (1 - cos(run / radius)), run / radius, 2.0, 0.3, run], atol=1e-8
    )


@given(STATES, ACCELERATIONS, RATES)
def test_it_ends_where_many_small_steps_end(state: Floats, acceleration: float, rate: float) -> None:
    x, y, heading, speed, angle, station = state
    small = STEP_S / 1000
    for _ in range(1000):
        speed, angle = speed + acceleration * small / 2, angle + rate * small / 2
        middle = heading + speed * tan(angle) / WHEELBASE_M * small / 2
        x, y, station = x + speed * cos(middle) * small, y + speed * sin(middle) * small, station + speed * small
        heading += speed * tan(angle) / WHEELBASE_M * small
        speed, angle = speed + acceleration * small / 2, angle + rate * small / 2
    assert np.allclose(stepped(state, acceleration, rate)[0], [x, y, heading, speed, angle, station], atol=2e-3)


@given(STATES, ACCELERATIONS, RATES)
def test_its_derivatives_are_its_differences(state: Floats, acceleration: float, rate: float) -> None:
    _, jacobian = stepped(state, acceleration, rate)
    for column in range(5):
        less, more = (np.append(state, (acceleration, rate)) for _ in range(2))
        at = (2, 3, 4, 6, 7)[column]
        less[at] -= 1e-6
        more[at] += 1e-6
        slope = (stepped(more[:6], *more[6:])[0] - stepped(less[:6], *less[6:])[0]) / 2e-6
        assert np.allclose(jacobian[:, column], slope[:3], atol=1e-6, rtol=1e-6)
