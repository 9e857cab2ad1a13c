"""What the body of a car sweeps that follows a line of points, and who is out of its reach. Pure; never says what is free.

It spares `free_way` a close look at who stands beside the way. Line and strip of a way are kept while it is the same one.
"""

from collections.abc import Sequence
from itertools import accumulate
from math import atan2, dist, hypot
from typing import NamedTuple

from vehicle_gateway.remembered import remembered
from wire.messages.vehicle import VehicleDescription

STEP_MIN_M = 0.2  # a line of shorter steps is looked at point by point
TURN_MAX_RAD = 1.0  # and one that turns more within the length of the car
ROUNDING_M = 1e-6  # more than a million metres lose in a sum of floats

Points = Sequence[tuple[float, float]]
Circle = tuple[float, float, float]  # x_m, y_m, radius_m


class Strip(NamedTuple):
    """The points of a way, drawn out by the bonnet, where they lie, and what the body of a car sweeps about them."""

    points: Points
    step_m: float  # the longest
    sweep_m: float  # no part of the body gets farther from the points
    cos: float  # of the direction from the first point to the last of the way
    sin: float
    right_m: float  # where the body may be at most, aside of that direction from the origin
    left_m: float


class Line(NamedTuple):
    """What follows from the points of a way and the size of the car alone."""

    along_m: tuple[float, ...]  # of each point, from the first one
    strip: Strip | None  # None: too crooked to say


@remembered  # a corridor lasts for a tenth of a second, some twenty cycles
def line_of(points: tuple[tuple[float, float], ...], vehicle: VehicleDescription) -> Line:
    lengths = list(map(dist, points, points[1:]))
    along_m = along_of(lengths) if points else ()
    sweep_m = _sweep_m(points, lengths, vehicle)
    return Line(along_m, None if sweep_m is None else _strip_of(points, lengths, sweep_m, vehicle))


def along_of(lengths: Sequence[float]) -> tuple[float, ...]:
    return tuple(accumulate(lengths, initial=0.0))


def _sweep_m(points: Points, lengths: Sequence[float], vehicle: VehicleDescription) -> float | None:
    """How far from the points the body of a car that follows them gets at most.

    The body reaches `front` ahead along the tangent; from there the line has turned by at most T = t (front / l + 1), with t the
    largest turn at a point and l the shortest step, and lies beside the tangent by at most front T, short of it by front T^2 / 2.
    """
    shortest, longest = min(lengths, default=0.0), max(lengths, default=0.0)
    if shortest < STEP_MIN_M:
        return None
    front = max(vehicle.length_m - vehicle.rear_overhang_m, vehicle.rear_overhang_m)
    turned = _turn_max_rad(points) * (front / shortest + 1)
    if turned > TURN_MAX_RAD:
        return None
    return vehicle.width_m / 2 + front * turned + front * turned**2 / 2 + max(longest / 2, vehicle.rear_overhang_m)


def _turn_max_rad(points: Points) -> float:
    """The largest at a point, from the step before it to the step after it."""
    turns, (x1, y1), (x2, y2) = [0.0], points[0], points[1]
    ax, ay = x2 - x1, y2 - y1
    for x, y in points[2:]:
        bx, by = x - x2, y - y2
        turns.append(abs(atan2(ax * by - ay * bx, ax * bx + ay * by)))
        x2, y2, ax, ay = x, y, bx, by
    return max(turns)


def _strip_of(points: Points, lengths: Sequence[float], sweep_m: float, vehicle: VehicleDescription) -> Strip:
    (x0, y0), (x1, y1), (x2, y2), length = points[0], points[-2], points[-1], lengths[-1]
    dx, dy, bonnet = (x2 - x1) / length, (y2 - y1) / length, vehicle.length_m - vehicle.rear_overhang_m
    drawn = [*points, *[(x2 + k * length * dx, y2 + k * length * dy) for k in range(1, int(bonnet / length) + 2)]]
    along = hypot(x2 - x0, y2 - y0)
    c, s = ((x2 - x0) / along, (y2 - y0) / along) if along else (1.0, 0.0)
    left, reach = [y * c - x * s for x, y in drawn], sweep_m + ROUNDING_M
    return Strip(drawn, max(lengths), sweep_m, c, s, min(left) - reach, max(left) + reach)


def in_reach(strip: Strip, things: Sequence[Circle]) -> list[Circle]:
    """Only the things that a car on this way could touch: no farther from its line, drawn out by the bonnet, than it sweeps.

    Most things stand beside the way: whoever is too far from its strip is too far from every point in it.
    """
    points, step, sweep, c, s, right, left = strip
    inside = [(x, y, radius) for x, y, radius in things if right - radius < y * c - x * s < left + radius]
    return [(x, y, radius) for x, y, radius in inside if _comes_near(points, step, (x, y), sweep + radius)]


def _comes_near(points: Points, step_m: float, place: tuple[float, float], reach_m: float) -> bool:
    at = 0
    while at < len(points):
        gap = dist(points[at], place) - reach_m
        if gap <= 0.0:
            return True
        at += int(gap / step_m) + 1
    return False
