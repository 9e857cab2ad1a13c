"""How fast the car may be where: stop points and speed caps, and the ceiling they make together. Pure.

Closed form instead of a sampled profile: exact at every station, cheap enough to be asked 100 times a second.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf, sqrt
from typing import NamedTuple

GENTLE_M_S2 = 2.0  # up to here a stop ends softly; a firmer one keeps its deceleration to the end
END_SPEED_M_S = 0.6  # below this a soft stop lets go of the brakes
END_DECELERATION_M_S2 = 0.35  # so that standstill is no jerk
NEAR_M = 0.02  # closer than this to a stop point: arrived


@dataclass(frozen=True, slots=True)
class StopPoint:
    """The rear axle stops here."""

    station_m: float
    deceleration_m_s2: float  # positive
    cause: str  # goal, static, standing (a person), person, takeover


@dataclass(frozen=True, slots=True)
class SpeedCap:
    """Between two stations (of the rear axle) no faster than this."""

    from_m: float
    to_m: float
    speed_m_s: float


class Ceiling(NamedTuple):
    speed_m_s: float
    slope_m_s2: float  # acceleration of a car that keeps to it; <= 0


def ceiling(
    station_m: float, limit_m_s: float, comfort_m_s2: float, stops: Sequence[StopPoint], caps: Sequence[SpeedCap]
) -> Ceiling:
    """The lowest of everything that bounds the speed at a station of the rear axle."""
    lowest = Ceiling(limit_m_s, 0.0)
    for cap in caps:
        if station_m <= cap.to_m:
            lowest = min(lowest, _before_cap(cap, station_m, comfort_m_s2))
    for stop in stops:
        lowest = min(lowest, _before_stop(stop.station_m - station_m, stop.deceleration_m_s2))
    return lowest


def _before_cap(cap: SpeedCap, station_m: float, comfort_m_s2: float) -> Ceiling:
    distance = cap.from_m - station_m
    if distance <= 0.0:
        return Ceiling(cap.speed_m_s, 0.0)
    return Ceiling(sqrt(cap.speed_m_s**2 + 2 * comfort_m_s2 * distance), -comfort_m_s2)


def _before_stop(distance_m: float, deceleration_m_s2: float) -> Ceiling:
    if distance_m <= NEAR_M:
        return Ceiling(0.0, -deceleration_m_s2)
    end = END_DECELERATION_M_S2
    if not end < deceleration_m_s2 <= GENTLE_M_S2:
        return Ceiling(sqrt(2 * deceleration_m_s2 * distance_m), -deceleration_m_s2)
    soft = END_SPEED_M_S**2 / (2 * end)
    if distance_m <= soft:
        return Ceiling(sqrt(2 * end * distance_m), -end)
    return Ceiling(sqrt(END_SPEED_M_S**2 + 2 * deceleration_m_s2 * (distance_m - soft)), -deceleration_m_s2)


def driving_time_s(
    station_m: float,
    speed_m_s: float,
    acceleration_m_s2: float,
    limit_m_s: float,
    comfort_m_s2: float,
    stops: Sequence[StopPoint],
    caps: Sequence[SpeedCap],
    horizon_s: float,
) -> float:
    """For how long a car that keeps to the ceiling is in motion before it stands at a stop point, at most horizon_s."""
    step_s, time_s, speed = 0.25, 0.0, speed_m_s
    last = min((stop.station_m for stop in stops), default=inf)
    while time_s < horizon_s and station_m < last - 0.3:
        allowed = ceiling(station_m, limit_m_s, comfort_m_s2, stops, caps).speed_m_s
        speed = max(min(speed + acceleration_m_s2 * step_s, allowed), 0.1)
        station_m += speed * step_s
        time_s += step_s
    return min(time_s, horizon_s)
