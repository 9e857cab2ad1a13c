"""Axles and tyres: loads, what drive and brakes use of the friction circle, and the lateral force left, after Fiala. Pure.

Every force over the mass of the car. Source: Rajamani, Vehicle Dynamics and Control (2012), 13.4 (Fiala's brush model with the
friction derated by the longitudinal force); loads quasi-static, from the force that is asked for. No left-right transfer.
"""

from math import copysign, sqrt, tan
from typing import NamedTuple

from autonomy.control.mpcc.car import GRAVITY_M_S2, Car
from autonomy.planning.kernels import kernel

LEAST_LOAD = 0.05  # share of the weight: neither axle ever lifts off wholly
LEAST_GRIP = 0.1  # share of an axle's grip: a locked wheel still scrubs


class Axle(NamedTuple):
    """Forces of one axle, and their derivatives by the tangent of the slip angle and by the whole force asked for."""

    along: float
    along_by_push: float
    aside: float  # to the left of the wheel
    aside_by_slip: float
    aside_by_push: float
    grip: float  # friction times load
    grip_by_push: float


@kernel
def fiala(slip: float, stiffness: float, grip: float) -> tuple[float, float, float]:
    """Force with the sign of `slip` (the tangent of its angle); its derivatives by slip and by grip."""
    share = abs(slip) * stiffness / (3.0 * grip)
    if share >= 1.0:
        return copysign(grip, slip), 0.0, copysign(1.0, slip)
    rest = 1.0 - share
    force = stiffness * slip * (1.0 - share + share * share / 3.0)
    return force, stiffness * rest * rest, copysign(share * share * (3.0 - 2.0 * share), slip)


@kernel
def loads(push: float, car: Car) -> tuple[float, float, float]:
    """Over the mass, front and rear; the front one's derivative by push."""
    moved = car.height / car.wheelbase
    front, slope = GRAVITY_M_S2 * car.rear / car.wheelbase - push * moved, -moved
    least = LEAST_LOAD * GRAVITY_M_S2
    if front < least or front > GRAVITY_M_S2 - least:
        front, slope = min(max(front, least), GRAVITY_M_S2 - least), 0.0
    return front, GRAVITY_M_S2 - front, slope


@kernel
def axles(front_slip: float, rear_slip: float, push: float, car: Car) -> tuple[Axle, Axle]:
    """Front and rear. push: the force of all wheels, forward positive."""
    front, rear, slope = loads(push, car)
    if push >= 0.0:
        share, share_slope = car.front_drive, 0.0
    else:
        share, share_slope = front / GRAVITY_M_S2, slope / GRAVITY_M_S2
    along, along_slope = push * share, share + push * share_slope
    return (
        axle(front_slip, along, along_slope, car.front_stiffness, car.friction * front, car.friction * slope),
        axle(rear_slip, push - along, 1.0 - along_slope, car.rear_stiffness, car.friction * rear, -car.friction * slope),
    )


@kernel
def axle(slip: float, along: float, along_slope: float, stiffness: float, grip: float, grip_slope: float) -> Axle:
    left = grip * grip - along * along
    least = LEAST_GRIP * grip
    if left > least * least:
        left = sqrt(left)
        left_slope = (grip * grip_slope - along * along_slope) / left
    else:
        left, left_slope = least, LEAST_GRIP * grip_slope
    aside, by_slip, by_left = fiala(slip, stiffness, left)
    return Axle(along, along_slope, aside, by_slip, by_left * left_slope, grip, grip_slope)


@kernel
def slips(speed: float, aside: float, turn: float, angle: float, wheelbase: float) -> tuple[float, ...]:
    """Tangents of the slip angles: front, by speed, aside, turn, angle; rear, by speed, aside. speed > 0."""
    course = (aside + wheelbase * turn) / speed
    tangent = tan(angle)
    one = 1.0 + course * tangent
    front = (tangent - course) / one
    by_course = -(1.0 + front * front) / (1.0 + course * course)
    rear = -aside / speed
    return (
        front,
        -by_course * course / speed,
        by_course / speed,
        by_course * wheelbase / speed,
        1.0 + front * front,
        rear,
        -rear / speed,
        -1.0 / speed,
    )
