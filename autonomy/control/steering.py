"""Lateral control: curvature feed-forward plus feedback of offset and angle to the path. Pure, 100 Hz.

In metres driven instead of seconds the error obeys e'' + 2 D w e' + w^2 e = 0, so the car returns to its path over the
same length at every speed (as pure pursuit does with look-ahead 1/w). The feed-forward is the mean curvature of the way
covered while the steering acts. Small angles; the tyres' slip is not modelled.
"""

from math import atan
from typing import Annotated

from msgspec import Meta

from autonomy.car_shape import CarShape
from autonomy.planning.route import Lane, Shift, curvature_at_1_m
from wire.messages.base import Message
from wire.road import Road, RoadPoint, wrap_angle

CREEP_M_S = 1.0  # slower, lateral motion says nothing
Positive = Annotated[float, Meta(gt=0.0, le=50.0)]


class SteeringSettings(Message):
    return_length_m: Positive = 5.0  # 1/w
    damping: Positive = 0.9  # D
    preview_s: Positive = 0.5  # command to effect at the wheels, about twice the steering's lag
    approach_max_rad: Positive = 0.35  # angle at which a far path is approached
    # What the gate lets pass (0.6 rad/s, 5 m/s3), less as far as a step of 10 ms may come in one of its 4 ms.
    rate_max_rad_s: Positive = 0.24  # of the road wheels
    lateral_jerk_max_m_s3: Positive = 2.0
    turning_m: Positive = 2.0  # the most that is driven while the wheels still turn to where they are wanted


def wanted_angle_rad(
    at: RoadPoint,
    heading_rad: float,
    speed_m_s: float,
    road: Road,
    lane: Lane,
    shift: Shift,
    shape: CarShape,
    settings: SteeringSettings,
) -> float:
    """Road-wheel angle towards the path; positive turns left. `at`: the rear axle in road coordinates."""
    ahead = 0.5 + max(speed_m_s, 0.0) * settings.preview_s
    path = lane.middle_m + shift.at(at.station_m)
    bend = sum(curvature_at_1_m(road, at.station_m + ahead * share, path) for share in (0.2, 0.6, 1.0, 1.4)) / 4
    frequency = 1.0 / settings.return_length_m
    damping = 2.0 * settings.damping * frequency
    slope = (shift.at(at.station_m + ahead) - shift.at(at.station_m)) / ahead
    approach = frequency**2 * (at.offset_m - path) / damping
    approach = min(max(approach, -settings.approach_max_rad), settings.approach_max_rad)
    turn = wrap_angle(heading_rad - at.heading_rad) - slope
    angle = atan(shape.wheelbase_m * (bend - damping * (turn + approach)))
    return min(max(angle, -shape.road_wheel_angle_max_rad), shape.road_wheel_angle_max_rad)


def rate_max_rad_s(speed_m_s: float, shape: CarShape, settings: SteeringSettings) -> float:
    """Lateral acceleration is curvature times speed squared: the faster the car, the slower its wheels turn. At small angles."""
    return min(settings.rate_max_rad_s, settings.lateral_jerk_max_m_s3 * shape.wheelbase_m / max(speed_m_s, CREEP_M_S) ** 2)


def turning_speed_m_s(away_rad: float, rate_rad_s: float, settings: SteeringSettings) -> float:
    """So fast that the car drives no more than `turning_m` until its wheels, so far away from where they are wanted, are there."""
    return settings.turning_m * rate_rad_s / max(abs(away_rad), 1e-6)


def toward(previous: float, wanted: float, step_max: float) -> float:
    """One step from `previous` to `wanted`, no larger than step_max."""
    return previous + min(max(wanted - previous, -step_max), step_max)
