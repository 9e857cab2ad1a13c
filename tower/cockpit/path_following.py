"""Where the car is by now, and how to turn the wheel to keep to the path: dead reckoning over the delay, then pure pursuit. Pure.

Angles are road wheel angles. The operator knows what they have steered since the moment the picture shows.
Source of the steering law: Coulter, "Implementation of the Pure Pursuit Path Tracking Algorithm", CMU-RI-TR-92-01, 1992.
"""

from collections.abc import Callable, Sequence
from math import atan, atan2, cos, hypot, sin, tan
from typing import NamedTuple

from wire.road import Road, wrap_angle

STEP_S = 0.04


class Pose(NamedTuple):
    x_m: float  # rear axle, map frame
    y_m: float
    heading_rad: float


def reckoned(
    pose: Pose,
    speed_m_s: float,
    acceleration_m_s2: float,
    steered: Sequence[tuple[float, float]],
    horizon_s: float,
    wheelbase_m: float,
) -> Pose:
    """The pose horizon_s later.

    steered  (age in seconds, road wheel angle), newest first: what was steered that long ago holds until the next
    """
    x, y, heading = pose
    left_s, speed, index = horizon_s, speed_m_s, len(steered) - 1
    while left_s > 1e-6:
        dt = min(STEP_S, left_s)
        while index > 0 and steered[index - 1][0] >= left_s:
            index -= 1
        angle = steered[index][1] if steered else 0.0
        middle = heading + speed * tan(angle) / wheelbase_m * dt / 2
        x, y = x + speed * dt * cos(middle), y + speed * dt * sin(middle)
        heading += speed * tan(angle) / wheelbase_m * dt
        speed = max(speed + acceleration_m_s2 * dt, 0.0) if speed_m_s >= 0 else speed
        left_s -= dt
    return Pose(x, y, wrap_angle(heading))


def pursued(
    pose: Pose, station_m: float, speed_m_s: float, road: Road, offset_at: Callable[[float], float], wheelbase_m: float
) -> float:
    """Road wheel angle towards the path's point a look-ahead away; left positive.

    offset_at  offset_m of the path at a station, left of the centre line positive
    """
    ahead = min(max(0.8 * speed_m_s + 1.4, 2.6), 7.0)  # m; short enough for a 9 m change of lane, long enough not to wobble
    x, y, _ = road.to_world(station_m + ahead, offset_at(station_m + ahead))
    bearing = wrap_angle(atan2(y - pose.y_m, x - pose.x_m) - pose.heading_rad)
    return atan(2.0 * wheelbase_m * sin(bearing) / max(hypot(x - pose.x_m, y - pose.y_m), 1.0))
