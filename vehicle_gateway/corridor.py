"""The stopping corridor and the odometry it is tracked in: where to brake to when nobody drives. Pure.

The automation's scene brings a path that was checked against road edge and standing things. It is kept in the odometry frame
(dead reckoning of CAN speed and yaw rate), so that SAFE_STOP can follow it closed loop with every other process gone. Where it
is no longer free is for `free_way` to say, in every cycle.
"""

from collections.abc import Iterable
from itertools import repeat
from math import atan2, cos, dist, hypot, sin
from typing import NamedTuple

from vehicle_gateway.sweep import along_of, line_of
from wire.messages.automation import Scene
from wire.messages.base import Angle, Count, Length, Message, Position, TimeNs
from wire.messages.vehicle import VehicleDescription

CORRIDOR_AGE_MAX_NS = 1_000_000_000  # evidence older than this is no evidence (ten scenes at 10 Hz)
USABLE_NS = 6_000_000_000  # and older than this no guide either: a stop from 30 km/h takes 4 s, dead reckoning drifts
BESIDE_MAX_M = 1.5  # from its nearest point (they lie 1 m apart): farther, the operator went another way
LOOK_AHEAD_MIN_M = 3.0  # about one wheelbase: shorter oscillates
LOOK_AHEAD_S = 0.8


class Odometry(Message):
    """Rear axle, in a frame that starts where the gateway started."""

    x_m: Position = 0.0
    y_m: Position = 0.0
    heading_rad: float = 0.0


class Corridor(Message):
    points: tuple[tuple[float, float], ...] = ()  # odometry frame, from the car on
    checked_ns: TimeNs = 0
    free: Count | None = None  # so many points of it are clear of standing things; None: all
    sweep_m: Length | None = None  # no part of the car that follows it gets farther from its points; None: not known
    along_m: tuple[Length, ...] = ()  # of each point, from the first one; () in what was recorded before there was this


class Shift(NamedTuple):
    """From the map frame of a scene into the odometry frame."""

    map_x_m: float
    map_y_m: float
    x_m: float
    y_m: float
    cos: float
    sin: float

    def points(self, points: Iterable[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
        map_x, map_y, x0, y0, c, s = self
        shifted = []
        for x, y in points:
            dx, dy = x - map_x, y - map_y
            shifted.append((x0 + dx * c - dy * s, y0 + dx * s + dy * c))
        return tuple(shifted)


def advance(odometry: Odometry, speed_m_s: float, yaw_rate_rad_s: float, dt_s: float) -> Odometry:
    """Dead reckoning over one cycle, midpoint heading."""
    middle = odometry.heading_rad + yaw_rate_rad_s * dt_s / 2
    return Odometry(
        x_m=odometry.x_m + speed_m_s * dt_s * cos(middle),
        y_m=odometry.y_m + speed_m_s * dt_s * sin(middle),
        heading_rad=odometry.heading_rad + yaw_rate_rad_s * dt_s,
    )


def keep_corridor(scene: Scene, shift: Shift, vehicle: VehicleDescription) -> Corridor:
    """The scene's corridor in the odometry frame."""
    points = shift.points(scene.stopping_corridor)
    along_m, strip = line_of(points, vehicle)
    return Corridor(points=points, checked_ns=scene.stamp_ns, along_m=along_m, sweep_m=strip.sweep_m if strip else None)


class Pursuit(Message):
    road_wheel_angle_rad: Angle
    remaining_m: Length  # along the corridor


def nearest(corridor: Corridor, odometry: Odometry) -> tuple[int, float]:
    """Number of the point that the car is at, and how far it is from there."""
    distances = list(map(dist, corridor.points, repeat((odometry.x_m, odometry.y_m))))
    least_m = min(distances)
    return distances.index(least_m), least_m


def usable_from(corridor: Corridor, odometry: Odometry, speed_m_s: float, now_ns: int) -> int | None:
    """Number of the point that the car is at; None when the corridor says nothing about where this car is now.

    It does not when it is too old, when the car is beside it, or drives backwards.
    """
    if not corridor.points or speed_m_s < 0.0 or now_ns - corridor.checked_ns > USABLE_NS:
        return None
    at, beside_m = nearest(corridor, odometry)
    return at if beside_m <= BESIDE_MAX_M else None


def remaining_m(corridor: Corridor, odometry: Odometry, at: int, free: int | None) -> float | None:
    """How much of a usable corridor is left before the car, as far as it is free; None when the car is beyond its end.

    As `pursue` has it, for every cycle: only the points from `at` on, the one the car is at, are looked at.
    """
    points, (x0, y0) = corridor.points, (odometry.x_m, odometry.y_m)
    c, s = cos(odometry.heading_rad), sin(odometry.heading_rad)
    ahead = (number for number in range(at, len(points)) if (points[number][0] - x0) * c + (points[number][1] - y0) * s > 0.0)
    first, end = next(ahead, None), len(points) if free is None else free
    if first is None:
        return None
    along_m = corridor.along_m or along_of(list(map(dist, points, points[1:])))
    return dist(points[first], (x0, y0)) + along_m[end - 1] - along_m[first] if first < end else 0.0


def pursue(corridor: Corridor, odometry: Odometry, speed_m_s: float, wheelbase_m: float, free: int | None = None) -> Pursuit | None:
    """Steering that follows the corridor (pure pursuit), and how much of it is left; None when the car is beyond its end.

    free  so many of its points are free now (None: all): it is steered along to its end, but only what is free remains
    """
    ahead = [(x - odometry.x_m, y - odometry.y_m) for x, y in corridor.points]
    c, s = cos(odometry.heading_rad), sin(odometry.heading_rad)
    every = [(dx * c + dy * s, -dx * s + dy * c) for dx, dy in ahead]
    local = [point for point in every if point[0] > 0.0]
    if not local:
        return None
    look_m = max(LOOK_AHEAD_MIN_M, LOOK_AHEAD_S * abs(speed_m_s))
    x, y = next((point for point in local if hypot(*point) >= look_m), local[-1])
    clear = local if free is None else [point for point in every[:free] if point[0] > 0.0]
    remaining = hypot(*clear[0]) + sum(map(dist, clear, clear[1:])) if clear else 0.0
    distance2 = max(x * x + y * y, LOOK_AHEAD_MIN_M**2)  # a short rest of the path does not ask for a sharp turn
    return Pursuit(road_wheel_angle_rad=atan2(2.0 * wheelbase_m * y, distance2), remaining_m=remaining)
