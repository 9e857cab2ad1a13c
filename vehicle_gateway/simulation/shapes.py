"""Distances between the car's rectangle, circles and convex polygons in the plane. Pure; metres, map frame."""

from collections.abc import Sequence
from math import cos, hypot, inf, sin
from typing import NamedTuple

from wire.messages.vehicle import VehicleDescription

Point = tuple[float, float]
Polygon = Sequence[Point]  # convex, counter-clockwise


class Outline(NamedTuple):
    """The car seen from above: a rectangle around the pose of its rear axle."""

    x_m: float
    y_m: float
    heading_rad: float
    front_m: float  # rear axle to front bumper
    rear_m: float  # rear axle to rear bumper
    half_width_m: float


def outline(vehicle: VehicleDescription, x_m: float, y_m: float, heading_rad: float) -> Outline:
    return Outline(x_m, y_m, heading_rad, vehicle.length_m - vehicle.rear_overhang_m, vehicle.rear_overhang_m, vehicle.width_m / 2)


def to_car(car: Outline, x_m: float, y_m: float) -> Point:
    """The point in the car's frame: ahead and left of the rear axle."""
    dx, dy, c, s = x_m - car.x_m, y_m - car.y_m, cos(car.heading_rad), sin(car.heading_rad)
    return dx * c + dy * s, dy * c - dx * s


def point_gap_m(car: Outline, x_m: float, y_m: float) -> float:
    """Distance of a point from the car's rectangle; 0 inside."""
    ahead, left = to_car(car, x_m, y_m)
    beyond = max(ahead - car.front_m, -car.rear_m - ahead, 0.0)
    return hypot(beyond, max(abs(left) - car.half_width_m, 0.0))


def corners(car: Outline) -> tuple[Point, ...]:
    c, s = cos(car.heading_rad), sin(car.heading_rad)
    return tuple(
        (car.x_m + a * c - b * s, car.y_m + a * s + b * c)
        for a, b in (
            (car.front_m, car.half_width_m),
            (-car.rear_m, car.half_width_m),
            (-car.rear_m, -car.half_width_m),
            (car.front_m, -car.half_width_m),
        )
    )


def polygon_gap_m(one: Polygon, other: Polygon) -> float:
    """Distance between two convex polygons; 0 when they touch or overlap."""
    if not _separated(one, other) and not _separated(other, one):
        return 0.0
    return min(_nearest_corner_m(one, other), _nearest_corner_m(other, one))


def _separated(one: Polygon, other: Polygon) -> bool:
    """Whether an edge of `one` has all of `other` on its outer side (separating axis theorem)."""
    return any(all((bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0.0 for x, y in other) for (ax, ay), (bx, by) in _edges(one))


def _nearest_corner_m(one: Polygon, other: Polygon) -> float:
    return min((_segment_distance_m(x, y, a, b) for x, y in one for a, b in _edges(other)), default=inf)


def _segment_distance_m(x_m: float, y_m: float, a: Point, b: Point) -> float:
    dx, dy = b[0] - a[0], b[1] - a[1]
    length2 = dx * dx + dy * dy
    t = min(max(((x_m - a[0]) * dx + (y_m - a[1]) * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
    return hypot(x_m - a[0] - t * dx, y_m - a[1] - t * dy)


def _edges(polygon: Polygon) -> list[tuple[Point, Point]]:
    return [(polygon[i], polygon[(i + 1) % len(polygon)]) for i in range(len(polygon))]


def sees_through(start: Point, end: Point, polygon: Polygon) -> bool:
    """Whether the straight line from start to end misses a convex polygon (clipping after Cyrus and Beck)."""
    (sx, sy), (ex, ey) = start, end
    enter, leave = 0.0, 1.0
    for (ax, ay), (bx, by) in _edges(polygon):
        inside_s = (bx - ax) * (sy - ay) - (by - ay) * (sx - ax)  # > 0: on the inner side of this edge
        inside_e = (bx - ax) * (ey - ay) - (by - ay) * (ex - ax)
        if inside_s <= 0.0 and inside_e <= 0.0:
            return True
        if inside_s < 0.0:
            enter = max(enter, inside_s / (inside_s - inside_e))
        elif inside_e < 0.0:
            leave = min(leave, inside_s / (inside_s - inside_e))
    return enter >= leave
