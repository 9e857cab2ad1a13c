"""The way the car may take: the own lane of the map, to the goal. Pure geometry; knows no obstacle.

Offsets are those of wire.road.Road: from the centre line, left positive.
"""

from dataclasses import dataclass
from math import sqrt

from autonomy.planning.speed_limits import SpeedCap
from wire.messages.base import Point
from wire.road import Road


@dataclass(frozen=True, slots=True)
class Lane:
    """The own lane as an interval of offsets."""

    middle_m: float
    low_m: float
    high_m: float

    def contains(self, offset_m: float, radius_m: float, least_m: float = 0.1) -> bool:
        """Whether a circle reaches at least `least_m` into the lane."""
        return offset_m + radius_m > self.low_m + least_m and offset_m - radius_m < self.high_m - least_m


@dataclass(frozen=True, slots=True)
class Shift:
    """Where beside the lane's middle the car drives: from one value to another along a straight ramp."""

    station_m: float = 0.0  # where the ramp starts
    start_m: float = 0.0  # left positive
    end_m: float = 0.0
    slope: float = 0.05  # metres aside per metre ahead: 0.35 m/s at the speed limit

    def at(self, station_m: float) -> float:
        reach = self.slope * max(station_m - self.station_m, 0.0)
        return self.start_m + min(max(self.end_m - self.start_m, -reach), reach)


def own_lane(road: Road) -> Lane:
    middle, half = road.own_lane_offset_m, road.map.lane_width_m / 2
    return Lane(middle, middle - half, middle + half)


def path_points(
    road: Road, lane: Lane, shift: Shift, from_station_m: float, to_station_m: float, step_m: float
) -> tuple[Point, ...]:
    """Points of the rear axle's path in the map frame."""
    count = max(int((to_station_m - from_station_m) / step_m), 0) + 1
    stations = [from_station_m + i * step_m for i in range(count)]
    return tuple(road.to_world(station, lane.middle_m + shift.at(station))[:2] for station in stations)


def curvature_at_1_m(road: Road, station_m: float, offset_m: float) -> float:
    """Of the line parallel to the centre line at `offset_m`, left positive."""
    curvature = road.curvature_1_m(station_m)
    return curvature / max(1.0 - curvature * offset_m, 0.1)


def bend_caps(road: Road, offset_m: float, lateral_acceleration_m_s2: float) -> tuple[SpeedCap, ...]:
    """One speed cap for every segment of the map too tight for the speed limit."""
    caps, station = [], 0.0
    for segment in road.map.segments:
        bend = abs(curvature_at_1_m(road, station + segment.length_m / 2, offset_m))
        speed = sqrt(lateral_acceleration_m_s2 / max(bend, 1e-6))
        if speed < road.map.speed_limit_m_s:
            caps.append(SpeedCap(station, station + segment.length_m, speed))
        station += segment.length_m
    return tuple(caps)
