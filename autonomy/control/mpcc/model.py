"""How the car moves: a nonlinear single-track model with Fiala tyres, one stage by the classic Runge-Kutta rule, its derivatives.

Pure. The pose and the speeds are the rear axle's, as the planners'. Slip-driven above 5 m/s, below 2 m/s kinematic - lateral
speed and yaw rate follow the geometry with a lag -, a smooth blend of the two derivatives between: slip angles are singular at
standstill. Steering angle, force and place on the path are integrals of their rates, exact. Source: Rajamani (2012), 2.3;
the blend: Kabzan et al., AMZ Driverless (2020), 5.2.2.
"""

from math import cos, sin, tan

import numpy as np

from autonomy.control.mpcc.car import DYNAMIC_ABOVE_M_S, KINEMATIC_BELOW_M_S, Car
from autonomy.control.mpcc.stages import ANGLE, ASIDE, HEADING, JERK, PUSH, RATE, SPEED, STATES, TURN, X, Y
from autonomy.control.mpcc.tyres import axles, slips
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel, kernel

KINEMATIC_LAG_S = 0.05
WALKING_M_S = 0.5  # below this rolling resistance fades out: a standing car has none
MOVING = 6  # x, y, heading and the three speeds: what is integrated by the rule


@kernel
def dynamic_weight(speed: float) -> tuple[float, float]:
    """0 for the kinematic car, 1 for the dynamic one, a cubic between; its derivative."""
    width = DYNAMIC_ABOVE_M_S - KINEMATIC_BELOW_M_S
    s = min(max((speed - KINEMATIC_BELOW_M_S) / width, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s) / width


@kernel
def resistance(speed: float, car: Car) -> tuple[float, float]:
    """Over the mass, against the motion; its derivative."""
    rolling, slope = car.rolling, 0.0
    if abs(speed) < WALKING_M_S:
        rolling, slope = car.rolling * speed / WALKING_M_S, car.rolling / WALKING_M_S
    elif speed < 0.0:
        rolling = -rolling
    return rolling + car.drag * speed * abs(speed), slope + 2.0 * car.drag * abs(speed)


@kernel
def flow(state: Floats, car: Car, out: Floats, jacobian: Floats) -> None:
    """out (6,): rates of x, y, heading, speed, aside, turn. jacobian (6, 6): by heading, speed, aside, turn, angle, push."""
    heading, speed, aside, turn = state[HEADING], state[SPEED], state[ASIDE], state[TURN]
    angle, push = state[ANGLE], state[PUSH]
    jacobian[:] = 0.0
    c, s = cos(heading), sin(heading)
    out[X], out[Y], out[HEADING] = speed * c - aside * s, speed * s + aside * c, turn
    jacobian[X, 0], jacobian[X, 1], jacobian[X, 2] = -out[Y], c, -s
    jacobian[Y, 0], jacobian[Y, 1], jacobian[Y, 2] = out[X], s, c
    jacobian[HEADING, 3] = 1.0
    drag, drag_slope = resistance(speed, car)
    tangent = tan(angle)
    out[SPEED], out[ASIDE] = push - drag, -aside / KINEMATIC_LAG_S
    out[TURN] = (speed * tangent / car.wheelbase - turn) / KINEMATIC_LAG_S
    jacobian[SPEED, 1], jacobian[SPEED, 5] = -drag_slope, 1.0
    jacobian[ASIDE, 2], jacobian[TURN, 3] = -1.0 / KINEMATIC_LAG_S, -1.0 / KINEMATIC_LAG_S
    jacobian[TURN, 1] = tangent / car.wheelbase / KINEMATIC_LAG_S
    jacobian[TURN, 4] = speed * (1.0 + tangent * tangent) / car.wheelbase / KINEMATIC_LAG_S
    weight, weight_slope = dynamic_weight(speed)
    if weight > 0.0:
        blend(speed, aside, turn, angle, push, drag, drag_slope, weight, weight_slope, car, out, jacobian)


@kernel
def blend(
    speed: float,
    aside: float,
    turn: float,
    angle: float,
    push: float,
    drag: float,
    drag_slope: float,
    weight: float,
    weight_slope: float,
    car: Car,
    out: Floats,
    jacobian: Floats,
) -> None:
    """The slip-driven rates of speed, aside and turn into the kinematic ones."""
    f_slip, f_speed, f_aside, f_turn, f_angle, r_slip, r_speed, r_aside = slips(speed, aside, turn, angle, car.wheelbase)
    front, rear = axles(f_slip, r_slip, push, car)
    c, s = cos(angle), sin(angle)
    across = front.aside * c + front.along * s  # the front axle's force in the frame of the car
    ahead = front.along * c - front.aside * s + rear.along
    lever = 1.0 / car.inertia
    fa, fb = 1.0 - car.rear * car.front * lever, 1.0 + car.rear * car.rear * lever  # of the forces on the rear axle's lateral speed
    middle = aside + car.rear * turn  # lateral speed of the centre of gravity
    speed_rate = ahead - drag + middle * turn
    aside_rate = across * fa + rear.aside * fb - speed * turn
    turn_rate = lever * (car.front * across - car.rear * rear.aside)
    slip_slopes = (0.0, f_speed, f_aside, f_turn, f_angle, 0.0)
    rear_slopes = (0.0, r_speed, r_aside, 0.0, 0.0, 0.0)
    own = (
        (0.0, -drag_slope, turn, aside + 2.0 * car.rear * turn, -across, 0.0),
        (0.0, -turn, 0.0, -speed, 0.0, 0.0),
    )
    for j in range(1, 6):
        aside_f, aside_r = front.aside_by_slip * slip_slopes[j], rear.aside_by_slip * rear_slopes[j]
        across_by, ahead_by = aside_f * c, -aside_f * s
        if j == 4:
            across_by += front.along * c - front.aside * s
        if j == 5:
            aside_r += rear.aside_by_push
            across_by += front.aside_by_push * c + front.along_by_push * s
            ahead_by += front.along_by_push * c - front.aside_by_push * s + rear.along_by_push
        by = (
            ahead_by + own[0][j],
            across_by * fa + aside_r * fb + own[1][j],
            lever * (car.front * across_by - car.rear * aside_r),
        )
        for i in range(3):
            jacobian[SPEED + i, j] += weight * (by[i] - jacobian[SPEED + i, j])
    rates = (speed_rate, aside_rate, turn_rate)
    for i in range(3):
        jacobian[SPEED + i, 1] += weight_slope * (rates[i] - out[SPEED + i])
        out[SPEED + i] += weight * (rates[i] - out[SPEED + i])


@fast_kernel
def step(state: Floats, inputs: Floats, dt: float, car: Car, after: Floats, ab: Floats) -> None:
    """`after` (9,): the state dt later; `ab` (9, 12): its derivatives by states and inputs."""
    node, rates, slopes = np.empty(STATES), np.zeros(MOVING), np.empty((MOVING, 6))
    # Derivatives by heading, the speeds, angle, push, rate and jerk: of the node, and of the last rates.
    along, kept = np.zeros((6, 8)), np.zeros((MOVING, 8))
    ab[:] = 0.0
    for i in range(STATES):
        ab[i, i] = 1.0
        after[i] = state[i]
    for look in range(4):
        reach = 0.0 if look == 0 else (dt if look == 3 else dt / 2.0)
        share = dt / 6.0 if look in (0, 3) else dt / 3.0
        for i in range(MOVING):
            node[i] = state[i] + reach * rates[i]
        node[ANGLE], node[PUSH] = state[ANGLE] + reach * inputs[0], state[PUSH] + reach * inputs[1]
        for i in range(4):
            for j in range(8):
                along[i, j] = reach * kept[HEADING + i, j]
            along[i, i] += 1.0
        along[4, 4], along[5, 5], along[4, 6], along[5, 7] = 1.0, 1.0, reach, reach
        flow(node, car, rates, slopes)
        for i in range(MOVING):
            after[i] += share * rates[i]
            for j in range(8):
                total = 0.0
                for m in range(6):
                    total += slopes[i, m] * along[m, j]
                kept[i, j] = total
            for j in range(6):
                ab[i, HEADING + j] += share * kept[i, j]
            ab[i, RATE] += share * kept[i, 6]
            ab[i, JERK] += share * kept[i, 7]
    for i in range(3):
        after[ANGLE + i] += dt * inputs[i]
        ab[ANGLE + i, RATE + i] = dt
