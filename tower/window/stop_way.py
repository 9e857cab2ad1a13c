"""The way the car would stop along by itself, as the car tells it: its free part, and where the bumper would stand. Pure.

Along the corridor that the automation checked, cut where the gateway finds it no longer free; without one along the curvature
of the wheels as they are. Frame: the car's own at the picture's capture stamp.
"""

from itertools import pairwise
from math import atan2, dist, tan

from tower.window.course import XY, Pose, Strip, beside, moved, ribbon, strip
from wire.messages.vehicle import StopWay, VehicleDescription

CORRIDOR = "corridor"


def way_of_corridor(middle: list[XY], way: StopWay, car: VehicleDescription) -> tuple[Strip | None, tuple[XY, XY] | None]:
    """The corridor up to its free end, and the line across it where the bumper would stand; None for what does not show."""
    ahead = [point for point in middle if point[0] > 0.0]
    if way.along != CORRIDOR:
        return ribbon(middle, car.width_m), None
    end = _within(ahead, way.stop_m)
    return ribbon(_free(ahead, way.free_m), car.width_m), None if end is None else _across(end, car)


def way_held(way: StopWay, road_wheel_angle_rad: float, car: VehicleDescription) -> tuple[Strip, tuple[XY, XY]]:
    """What the car sweeps with its wheels as they are until it stands."""
    end = moved(Pose(), way.stop_m, tan(road_wheel_angle_rad) / car.wheelbase_m)
    return strip(Pose(), 0.0, way.stop_m, road_wheel_angle_rad, car), _across(end, car)


def _free(points: list[XY], free_m: float) -> list[XY]:
    """Those within so much of the way from the car."""
    gone, kept = 0.0, []
    for before, point in pairwise([(0.0, 0.0), *points]):
        gone += dist(before, point)
        if gone > free_m + 0.5:  # the scene and the status are not of the same moment
            break
        kept.append(point)
    return kept


def _within(points: list[XY], way_m: float) -> Pose | None:
    """The pose so far along the points; None beyond their end."""
    left = way_m
    for before, point in pairwise([(0.0, 0.0), *points]):
        step = dist(before, point)
        if step >= left and step > 0.0:
            share = left / step
            heading = atan2(point[1] - before[1], point[0] - before[0])
            return Pose(before[0] + share * (point[0] - before[0]), before[1] + share * (point[1] - before[1]), heading)
        left -= step
    return None


def _across(pose: Pose, car: VehicleDescription) -> tuple[XY, XY]:
    front_m, half_m = car.length_m - car.rear_overhang_m, car.width_m / 2
    return beside(pose, front_m, half_m), beside(pose, front_m, -half_m)
