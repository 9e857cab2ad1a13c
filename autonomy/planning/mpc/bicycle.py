"""The kinematic bicycle of the REAR AXLE's middle, one stage by the classic Runge-Kutta rule, and its derivatives. Pure.

x' = v cos(heading), y' = v sin(heading), heading' = v tan(angle) / wheelbase, v' = acceleration, angle' = rate, station' = v.
Speed, angle and station are polynomials in time, exact here. State and inputs in the order of `horizon.Trajectory`.
"""

from math import cos, sin, tan

from autonomy.planning.horizon import STEP_S, Floats
from autonomy.planning.kernels import fast_kernel

H = STEP_S
X, Y, HEADING, SPEED, ANGLE, STATION = range(6)


@fast_kernel
def step(state: Floats, acceleration: float, rate: float, wheelbase: float, after: Floats, jacobian: Floats) -> None:
    """`after` (6,): the state a stage on; `jacobian` (3, 5): of its x, y, heading by heading, speed, angle, acceleration, rate."""
    speed, angle, heading = state[SPEED], state[ANGLE], state[HEADING]
    begin = turning(speed, angle, wheelbase)  # turning rate, by speed, by angle
    middle = turning(speed + H / 2 * acceleration, angle + H / 2 * rate, wheelbase)
    end = turning(speed + H * acceleration, angle + H * rate, wheelbase)
    after[:] = state
    jacobian[:] = 0.0
    look(speed, heading, H / 6, after, jacobian, acceleration, 0.0, 0.0, begin)
    look(speed, heading, H / 3, after, jacobian, acceleration, H / 2, 0.0, begin)
    look(speed, heading, H / 3, after, jacobian, acceleration, H / 2, H / 2, middle)
    look(speed, heading, H / 6, after, jacobian, acceleration, H, H / 2, middle)
    after[HEADING] += H / 6 * (begin[0] + 4.0 * middle[0] + end[0])
    after[SPEED] += H * acceleration
    after[ANGLE] += H * rate
    after[STATION] += H * speed + H * H / 2 * acceleration
    jacobian[HEADING, 0] = 1.0
    for i in (1, 2):
        jacobian[HEADING, i] = H / 6 * (begin[i] + 4.0 * middle[i] + end[i])
        jacobian[HEADING, 2 + i] = H * H / 6 * (2.0 * middle[i] + end[i])


@fast_kernel
def turning(speed: float, angle: float, wheelbase: float) -> tuple[float, float, float]:
    """heading', and its derivatives by speed and angle."""
    tangent = tan(angle)
    return speed * tangent / wheelbase, tangent / wheelbase, speed * (1.0 + tangent * tangent) / wheelbase


@fast_kernel
def look(
    speed: float,
    heading: float,
    weight: float,
    after: Floats,
    jacobian: Floats,
    acceleration: float,
    reach: float,
    turned_at: float,
    turn: tuple[float, float, float],
) -> None:
    """One of the rule's four: `reach` into the stage, with the turning rate that it had at `turned_at`."""
    heading, speed = heading + reach * turn[0], speed + reach * acceleration
    ahead, aside = weight * cos(heading), weight * sin(heading)
    by_speed, by_angle = reach * turn[1], reach * turn[2]  # of the heading there
    after[X] += speed * ahead
    after[Y] += speed * aside
    for row, along, across in ((X, ahead, -speed * aside), (Y, aside, speed * ahead)):
        jacobian[row, 0] += across
        jacobian[row, 1] += across * by_speed + along
        jacobian[row, 2] += across * by_angle
        jacobian[row, 3] += across * by_speed * turned_at + along * reach
        jacobian[row, 4] += across * by_angle * turned_at
