"""Last check before CAN: limit one command, and say which rules changed it. Pure: no clock, no I/O, no logging.

Every limit on a step holds twice: per frame (no frame moves more than `frame_longest_s` allows, however long the pause
before it was) and in real time (a step is a rate times the time that really passed, so calling twice as often moves nothing
faster). Steps count from what was sent last: a limit that shrinks with speed faster than the wheel may turn is approached at
the wheel's own rate, and meanwhile "curve speed" keeps traction from making the car faster than the angle that is sent allows.

Braking is never limited: more deceleration than last cycle passes at once, down to the car's own maximum.
Frame: ISO 8855; positive angle turns left.
"""

from math import atan, inf, isfinite, sqrt, tan
from typing import Annotated, NamedTuple

import msgspec
from msgspec import Meta

from wire.messages.base import Gear, Message, Name
from wire.messages.vehicle import Actuation, VehicleDescription

CREEP_M_S = 1.0  # below it the formulas of lateral motion say nothing


class GateLimits(Message):
    lateral_acceleration_max_m_s2: Annotated[float, Meta(ge=0.5, le=6.0)] = 3.0  # ISO 11270, as opendbc car/lateral.py
    lateral_jerk_max_m_s3: Annotated[float, Meta(ge=0.5, le=20.0)] = 5.0  # ISO 11270
    road_wheel_rate_max_rad_s: Annotated[float, Meta(ge=0.05, le=2.0)] = (
        0.6  # about 480 deg/s at the steering wheel: a brisk driver
    )
    traction_max_m_s2: Annotated[float, Meta(ge=0.1, le=5.0)] = 2.0  # ISO 15622, as opendbc; the car may give less
    traction_jerk_max_m_s3: Annotated[float, Meta(ge=0.2, le=20.0)] = 3.0  # ours: no jolt from the throttle
    transition_acceleration_m_s2: Annotated[float, Meta(ge=0.1, le=3.0)] = 1.0  # Autoware, while control changes hands
    transition_jerk_m_s3: Annotated[float, Meta(ge=0.1, le=10.0)] = 0.5  # Autoware, likewise
    transition_road_wheel_rate_rad_s: Annotated[float, Meta(ge=0.02, le=1.0)] = 0.3  # ours: half of the full rate
    frame_longest_s: Annotated[float, Meta(ge=0.01, le=0.1)] = 0.02  # ours: two of the gateway's cycles; no leap after a pause
    cap_time_constant_s: Annotated[float, Meta(ge=0.1, le=5.0)] = 0.5  # how fast the speed settles on its cap
    cap_braking_m_s2: Annotated[float, Meta(ge=0.1, le=4.0)] = 2.5  # no harder than this for the cap alone
    reverse_shift_speed_m_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.3  # architecture: shift below 0.3 m/s


class Bound(NamedTuple):
    """The most acceleration that one rule allows now; negative asks for braking."""

    rule: str
    acceleration_m_s2: float


class GateResult(Message):
    actuation: Actuation
    rules: tuple[Name, ...]  # those that changed something, () when the command passed unchanged


def gate(
    requested: Actuation,
    previous: Actuation,
    speed_m_s: float,
    cap_m_s: float,
    in_transition: bool,
    dt_s: float,
    vehicle: VehicleDescription,
    limits: GateLimits,
    bounds: tuple[Bound, ...] = (),
) -> GateResult:
    """What may go to the car.

    requested      what the driving source asks for
    previous       what was sent last cycle
    speed_m_s      measured, forward positive
    cap_m_s        the most the car may do now
    in_transition  control is changing hands: traction and steering steps are smaller, braking is not
    dt_s           real time since `previous` was sent
    bounds         of the place and of what stands in the way
    """
    step_s = min(dt_s, limits.frame_longest_s)
    speed = abs(speed_m_s)
    finite, number_rules = _numbers_only(requested, previous)
    angle, angle_rules = _steering(
        finite.road_wheel_angle_rad, previous.road_wheel_angle_rad, speed, in_transition, step_s, vehicle, limits
    )
    table = (
        Bound("acceleration", _traction_max(in_transition, vehicle, limits)),
        Bound("speed cap", toward_m_s2(cap_m_s, speed, limits)),
        Bound("curve speed", max(toward_m_s2(_curve_speed_m_s(angle, vehicle, limits), speed, limits), 0.0)),
        *bounds,
        Bound("jerk", _rising(previous.acceleration_m_s2, in_transition, step_s, limits)),
    )
    acceleration, rules = _acceleration(finite.acceleration_m_s2, table, vehicle)
    gear, gear_rules = _gear(finite.gear, previous.gear, speed_m_s, limits)
    if gear_rules:  # traction meant for the other direction
        acceleration = min(acceleration, 0.0)
    sent = msgspec.structs.replace(finite, road_wheel_angle_rad=angle, acceleration_m_s2=acceleration, gear=gear)
    return GateResult(actuation=sent, rules=(*number_rules, *angle_rules, *rules, *gear_rules))


def _steering(
    requested: float,
    previous: float,
    speed: float,
    in_transition: bool,
    step_s: float,
    vehicle: VehicleDescription,
    limits: GateLimits,
) -> tuple[float, tuple[str, ...]]:
    """Ends first, steps from the last angle after them: what cannot be reached in one step is approached."""
    per_m_s2 = vehicle.wheelbase_m / max(speed, CREEP_M_S) ** 2  # tan(angle) = wheelbase * lateral acceleration / speed^2
    rate = limits.transition_road_wheel_rate_rad_s if in_transition else limits.road_wheel_rate_max_rad_s
    lateral = atan(per_m_s2 * limits.lateral_acceleration_max_m_s2)
    now, jerk = tan(previous), per_m_s2 * limits.lateral_jerk_max_m_s3 * step_s
    less, more = (previous + (atan(now + step) - atan(now)) for step in (-jerk, jerk))
    table = (
        ("steering angle", -vehicle.road_wheel_angle_max_rad, vehicle.road_wheel_angle_max_rad),
        ("lateral acceleration", -lateral, lateral),
        ("steering rate", previous - rate * step_s, previous + rate * step_s),
        ("lateral jerk", less, more),
    )
    applied, rules = requested, []
    for rule, low, high in table:
        bounded = min(max(applied, low), high)
        if bounded != applied:
            applied = bounded
            rules.append(rule)
    return applied, tuple(rules) if applied != requested else ()


def _acceleration(requested: float, table: tuple[Bound, ...], vehicle: VehicleDescription) -> tuple[float, tuple[str, ...]]:
    applied, rules = requested, []
    for rule, bound in table:
        if applied > bound:
            applied = bound
            rules.append(rule)
    if applied < -vehicle.braking_max_m_s2:
        applied = -vehicle.braking_max_m_s2
        rules.append("car's braking")
    return applied, tuple(rules)


def _traction_max(in_transition: bool, vehicle: VehicleDescription, limits: GateLimits) -> float:
    most = min(vehicle.acceleration_max_m_s2, limits.traction_max_m_s2)
    return min(most, limits.transition_acceleration_m_s2) if in_transition else most


def _rising(previous: float, in_transition: bool, step_s: float, limits: GateLimits) -> float:
    """Releasing the brake is free, building traction is not."""
    return max(previous, 0.0) + (limits.transition_jerk_m_s3 if in_transition else limits.traction_jerk_max_m_s3) * step_s


def toward_m_s2(most_m_s: float, speed_m_s: float, limits: GateLimits) -> float:
    """The acceleration that lets the speed settle on `most_m_s`, braking no harder than a cap may."""
    return max((most_m_s - speed_m_s) / limits.cap_time_constant_s, -limits.cap_braking_m_s2)


def _curve_speed_m_s(angle: float, vehicle: VehicleDescription, limits: GateLimits) -> float:
    """The speed at which this angle gives the greatest lateral acceleration."""
    bend = tan(abs(angle)) / vehicle.wheelbase_m
    return sqrt(limits.lateral_acceleration_max_m_s2 / bend) if bend > 0.0 else inf


def _numbers_only(requested: Actuation, previous: Actuation) -> tuple[Actuation, tuple[str, ...]]:
    """A value that is no number never reaches the car: the angle stays, traction ends."""
    angle, acceleration = requested.road_wheel_angle_rad, requested.acceleration_m_s2
    if isfinite(angle) and isfinite(acceleration):
        return requested, ()
    held = previous.road_wheel_angle_rad if not isfinite(angle) else angle
    calm = min(previous.acceleration_m_s2, 0.0) if not isfinite(acceleration) else acceleration
    return msgspec.structs.replace(requested, road_wheel_angle_rad=held, acceleration_m_s2=calm), ("not a number",)


def _gear(requested: Gear, previous: Gear, speed_m_s: float, limits: GateLimits) -> tuple[Gear, tuple[str, ...]]:
    if requested == previous or abs(speed_m_s) < limits.reverse_shift_speed_m_s:
        return requested, ()
    return previous, ("gear while moving",)
