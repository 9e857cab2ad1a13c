"""What the body of a car sweeps that follows a line of points, and who is out of its reach. Pure; never says what is free.

It spares `free_way` a close look at who stands beside the way. Line and strip of a way are kept while it is the same one.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import atan2, dist, hypot
from typing import NamedTuple

from wire.messages.vehicle import VehicleDescription

STEP_MIN_M = 0.2  # a line of shorter steps is looked at point by point
TURN_MAX_RAD = 1.0  # and one that turns more within the length of the car
ROUNDING_M = 1e-6  # more than a million metres lose in a sum of floats

Points = Sequence[tuple[float, float]]


class Circle(NamedTuple):
    x_m: float
    y_m: float
    radius_m: float


def sweep_of(points: Points, vehicle: VehicleDescription) -> float | None:
    """How far from the points the body of a car that follows them gets at most; None for a line too crooked to say.

    The body reaches `front` ahead along the tangent; from there the line has turned by at most T = t (front / l + 1), with t the
    largest turn at a point and l the shortest step, and lies beside the tangent by at most front T, short of it by front T^2 / 2.
    """
    lengths = list(map(dist, points, points[1:]))
    shortest, longest = min(lengths, default=0.0), max(lengths, default=0.0)
    if shortest < STEP_MIN_M:
        return None
    steps = [(x2 - x1, y2 - y1) for (x1, y1), (x2, y2) in pairwise(points)]
    turns = [abs(atan2(ax * by - ay * bx, ax * bx + ay * by)) for (ax, ay), (bx, by) in pairwise(steps)]
    front = max(vehicle.length_m - vehicle.rear_overhang_m, vehicle.rear_overhang_m)
    turned = max(turns, default=0.0) * (front / shortest + 1)
    if turned > TURN_MAX_RAD:
        return None
    return vehicle.width_m / 2 + front * turned + front * turned**2 / 2 + max(longest / 2, vehicle.rear_overhang_m)


def in_reach(points: Points, begin: int, things: Sequence[Circle], sweep_m: float, vehicle: VehicleDescription) -> list[Circle]:
    """Only the things that a car on this way could touch: no farther from its line, drawn out by the bonnet, than it sweeps.

    Most things stand beside the way: whoever is too far from its strip is too far from every point in it.
    """
    drawn, step, c, s, right, left = line_of(tuple(points), vehicle.length_m - vehicle.rear_overhang_m)
    (x0, y0), found = drawn[0], []
    for thing in things:
        x, y, radius = thing
        reach, aside = sweep_m + radius, (y - y0) * c - (x - x0) * s
        if right - reach < aside < left + reach and _comes_near(drawn, step, begin, (x, y), reach):
            found.append(thing)
    return found


class Line(NamedTuple):
    """The points of a way, drawn out by the bonnet, and the strip they lie in."""

    points: Points
    step_m: float  # the longest
    cos: float  # of the strip's direction, from the first point to the last of the way
    sin: float
    right_m: float  # where the strip ends beside the first point
    left_m: float


@lru_cache(maxsize=2)  # a corridor lasts for a tenth of a second, some twenty cycles
def line_of(points: tuple[tuple[float, float], ...], bonnet_m: float) -> Line:
    (x0, y0), (x1, y1), (x2, y2) = points[0], points[-2], points[-1]
    length = dist((x1, y1), (x2, y2))
    dx, dy = (x2 - x1) / length, (y2 - y1) / length
    drawn = [*points, *((x2 + k * length * dx, y2 + k * length * dy) for k in range(1, int(bonnet_m / length) + 2))]
    along = hypot(x2 - x0, y2 - y0)
    c, s = ((x2 - x0) / along, (y2 - y0) / along) if along else (1.0, 0.0)
    left = [(y - y0) * c - (x - x0) * s for x, y in drawn]
    return Line(drawn, max(map(dist, points, points[1:])), c, s, min(left) - ROUNDING_M, max(left) + ROUNDING_M)


def _comes_near(points: Points, step_m: float, begin: int, place: tuple[float, float], reach_m: float) -> bool:
    at = begin
    while at < len(points):
        gap = dist(points[at], place) - reach_m
        if gap <= 0.0:
            return True
        at += int(gap / step_m) + 1
    return False
