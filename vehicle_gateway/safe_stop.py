"""The minimal risk manoeuvre: brake to standstill with limited jerk, along the corridor that was checked last. Pure.

With no fresh corridor it holds the curvature and brakes firmly. Hazard lights on. Also the formula of the distance it takes,
which every fault test prints beforehand and the referee's measurement is held against.
"""

from math import sqrt
from typing import Annotated

from msgspec import Meta

from vehicle_gateway.corridor import CORRIDOR_AGE_MAX_NS, Corridor, Odometry, pursue, usable_from
from wire.messages.base import Indicators, Message
from wire.messages.vehicle import Actuation, VehicleDescription


class StopLimits(Message):
    braking_m_s2: Annotated[float, Meta(ge=1.0, le=4.0)] = 2.5  # Autoware "emergency": firm, standing people keep their feet
    braking_max_m_s2: Annotated[float, Meta(ge=1.0, le=8.0)] = 4.0  # UN R157's ceiling; without a corridor at once
    jerk_m_s3: Annotated[float, Meta(ge=0.5, le=20.0)] = 5.0
    # with nothing known of the way ahead: walking pace. A car that perceives nothing says here what its operators answer for
    blind_speed_m_s: Annotated[float, Meta(ge=0.5, le=40.0)] = 5 / 3.6


def safe_stop(
    previous: Actuation,
    corridor: Corridor,
    odometry: Odometry,
    speed_m_s: float,
    now_ns: int,
    dt_s: float,
    vehicle: VehicleDescription,
    limits: StopLimits,
    corridor_free: int | None = None,
) -> Actuation:
    """What the gateway asks for in SAFE_STOP.

    previous       what was sent last cycle: the deceleration grows from there, and without a corridor its angle is held
    corridor_free  how many of the corridor's points are still free (None: all): it stops before the first that is not
    """
    fresh = now_ns - corridor.checked_ns <= CORRIDOR_AGE_MAX_NS
    known = usable_from(corridor, odometry, speed_m_s, now_ns) is not None
    pursuit = pursue(corridor, odometry, speed_m_s, vehicle.wheelbase_m, corridor_free) if known else None
    if pursuit is None:
        angle, braking = previous.road_wheel_angle_rad, limits.braking_max_m_s2
    else:
        needed = speed_m_s**2 / (2 * max(pursuit.remaining_m, 0.1))
        firm = limits.braking_m_s2 if fresh else limits.braking_max_m_s2
        angle, braking = pursuit.road_wheel_angle_rad, min(max(firm, needed), limits.braking_max_m_s2)
    angle = min(max(angle, -vehicle.road_wheel_angle_max_rad), vehicle.road_wheel_angle_max_rad)
    before, step = min(previous.acceleration_m_s2, 0.0), limits.jerk_m_s3 * dt_s
    acceleration = min(max(-braking, before - step), before + step)
    return Actuation(
        road_wheel_angle_rad=angle,
        acceleration_m_s2=acceleration,
        gear=previous.gear,
        indicators=Indicators.OFF,
        hazard=True,
        lights=previous.lights,
        wipers=previous.wipers,
    )


def speed_for_distance_m_s(distance_m: float, reaction_s: float, braking_m_s2: float, jerk_m_s3: float) -> float:
    """The speed whose `stopping_distance_m` is within `distance_m`: its inverse without the small term b t_j^2 / 24."""
    delay_s = reaction_s + braking_m_s2 / (2 * jerk_m_s3)
    return braking_m_s2 * (sqrt(delay_s**2 + 2 * max(distance_m, 0.0) / braking_m_s2) - delay_s)


def stopping_distance_m(speed_m_s: float, reaction_s: float, braking_m_s2: float, jerk_m_s3: float) -> float:
    """Distance to standstill: `reaction_s` at constant speed, then braking that builds up with `jerk_m_s3` to `braking_m_s2`.

    Formula: v t_r + v t_j - j t_j^3 / 6 + v_j^2 / (2 b), with t_j = b / j and v_j = v - b t_j / 2 (or, where the car stands
    before the braking has built up, t_j = sqrt(2 v / j)). Speeds >= 0, both limits > 0.
    """
    build_s = braking_m_s2 / jerk_m_s3
    after = speed_m_s - braking_m_s2 * build_s / 2
    if after <= 0.0:
        build_s, after = (2 * speed_m_s / jerk_m_s3) ** 0.5, 0.0
    building = speed_m_s * build_s - jerk_m_s3 * build_s**3 / 6
    return speed_m_s * reaction_s + building + after**2 / (2 * braking_m_s2)
