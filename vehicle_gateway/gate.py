"""Last check before CAN: limit one command, and say which rules changed it. Pure: no clock, no I/O, no logging.

Braking is never limited: more deceleration than last cycle passes at once, down to the car's own maximum.
Frame: ISO 8855; positive angle turns left.
"""

from math import atan, isfinite
from typing import Annotated

import msgspec
from msgspec import Meta

from wire.messages.base import Gear, Message, Name
from wire.messages.vehicle import Actuation, VehicleDescription


class GateLimits(Message):
    lateral_acceleration_max_m_s2: Annotated[float, Meta(ge=0.5, le=6.0)] = 3.0  # ISO 11270, as opendbc car/lateral.py
    lateral_jerk_max_m_s3: Annotated[float, Meta(ge=0.5, le=20.0)] = 5.0  # ISO 11270
    road_wheel_rate_max_rad_s: Annotated[float, Meta(ge=0.05, le=2.0)] = (
        0.6  # about 480 deg/s at the steering wheel: a brisk driver
    )
    traction_jerk_max_m_s3: Annotated[float, Meta(ge=0.2, le=20.0)] = 3.0  # ours: no jolt from the throttle
    transition_acceleration_m_s2: Annotated[float, Meta(ge=0.1, le=3.0)] = 1.0  # Autoware, while control changes hands
    transition_jerk_m_s3: Annotated[float, Meta(ge=0.1, le=10.0)] = 0.5  # Autoware, likewise
    transition_road_wheel_rate_rad_s: Annotated[float, Meta(ge=0.02, le=1.0)] = 0.3  # ours: half of the full rate
    cap_time_constant_s: Annotated[float, Meta(ge=0.1, le=5.0)] = 0.5  # how fast the speed settles on its cap
    cap_braking_m_s2: Annotated[float, Meta(ge=0.1, le=4.0)] = 2.5  # no harder than this for the cap alone
    reverse_shift_speed_m_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.3  # architecture: shift below 0.3 m/s


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
) -> GateResult:
    """What may go to the car.

    requested      what the driving source asks for
    previous       what was sent last cycle
    speed_m_s      measured, forward positive
    cap_m_s        the most the car may do now
    in_transition  control is changing hands: traction and steering steps are smaller, braking is not
    dt_s           real time since `previous` was sent
    """
    requested, number_rules = _numbers_only(requested, previous)
    angle, angle_rules = _steering(
        requested.road_wheel_angle_rad,
        previous.road_wheel_angle_rad,
        abs(speed_m_s),
        in_transition,
        dt_s,
        vehicle,
        limits,
    )
    acceleration, rules = _acceleration(
        requested.acceleration_m_s2,
        previous.acceleration_m_s2,
        abs(speed_m_s),
        cap_m_s,
        in_transition,
        dt_s,
        vehicle,
        limits,
    )
    gear, gear_rules = _gear(requested.gear, previous.gear, speed_m_s, limits)
    if gear_rules:  # traction meant for the other direction
        acceleration = min(acceleration, 0.0)
    sent = msgspec.structs.replace(requested, road_wheel_angle_rad=angle, acceleration_m_s2=acceleration, gear=gear)
    return GateResult(actuation=sent, rules=(*number_rules, *angle_rules, *rules, *gear_rules))


def _steering(
    requested: float,
    previous: float,
    speed: float,
    in_transition: bool,
    dt_s: float,
    vehicle: VehicleDescription,
    limits: GateLimits,
) -> tuple[float, tuple[str, ...]]:
    v2 = max(speed, 1.0) ** 2  # below 1 m/s the formulas of lateral motion say nothing
    angle_max = min(vehicle.road_wheel_angle_max_rad, atan(vehicle.wheelbase_m * limits.lateral_acceleration_max_m_s2 / v2))
    rate_max = limits.transition_road_wheel_rate_rad_s if in_transition else limits.road_wheel_rate_max_rad_s
    step_max = min(rate_max, vehicle.wheelbase_m * limits.lateral_jerk_max_m_s3 / v2) * dt_s
    bounded = min(max(requested, -angle_max), angle_max)
    stepped = min(max(bounded, previous - step_max), previous + step_max)
    rules = ("steering angle",) * (bounded != requested) + ("steering rate",) * (stepped != bounded)
    return stepped, rules


def _acceleration(
    requested: float,
    previous: float,
    speed: float,
    cap: float,
    in_transition: bool,
    dt_s: float,
    vehicle: VehicleDescription,
    limits: GateLimits,
) -> tuple[float, tuple[str, ...]]:
    most = (
        min(vehicle.acceleration_max_m_s2, limits.transition_acceleration_m_s2) if in_transition else vehicle.acceleration_max_m_s2
    )
    for_cap = max((cap - speed) / limits.cap_time_constant_s, -limits.cap_braking_m_s2)
    jerk = limits.transition_jerk_m_s3 if in_transition else limits.traction_jerk_max_m_s3
    rising = max(previous, 0.0) + jerk * dt_s  # releasing the brake is free, building traction is not
    bounds = (("acceleration", most), ("speed cap", for_cap), ("jerk", rising))
    applied, rules = requested, []
    for rule, bound in bounds:
        if applied > bound:
            applied = bound
            rules.append(rule)
    if applied < -vehicle.braking_max_m_s2:
        applied = -vehicle.braking_max_m_s2
        rules.append("car's braking")
    return applied, tuple(rules)


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
