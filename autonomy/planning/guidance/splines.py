"""The corners of a way rounded: a C2 cubic spline through ten points near it, as clear of everybody as the way was.

The points minimise 25 |c - p|^2 + 10 |second difference|^2 + 0.01 |c' - p'|^2 (p: the way at their times, c' their velocity;
weights of the method's authors), the ends held, and a natural spline goes through them. All of it is linear in p, so a
matrix made once gives the places. A spline that touches somebody, or passes somebody on another side, is made again of the
points p themselves, and then of twice as many, and so on: that comes as near to the way as is asked for.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from autonomy.planning.guidance.clearance import Crowd, clear
from autonomy.planning.guidance.graph import Ints
from autonomy.planning.guidance.winding import side, turned
from autonomy.planning.horizon import HORIZON_S, STEPS, Floats
from autonomy.planning.kernels import kernel

POINTS = 10
NEAR, SMOOTH, VELOCITY = 25.0, 10.0, 0.01  # weights
TIERS = 5  # beside the smoothed one: 10, 19, 37, 73, 145 points on the way itself
MOST_POINTS = (POINTS - 1) * 2 ** (TIERS - 1) + 1
FINE = 2  # places for each step, between which clearance is checked


class Tier(NamedTuple):
    """Matrices from p (count, 2) to what is wanted."""

    points: Floats  # (count, count) to c
    places: Floats  # (FINE STEPS + 1, count)
    velocities: Floats  # (STEPS + 1, count) m/s


@cache
def tiers() -> tuple[Tier, ...]:
    counts = [POINTS] + [(POINTS - 1) * 2**doubling + 1 for doubling in range(TIERS)]
    return tuple(_tier(count, smoothed=place == 0) for place, count in enumerate(counts))


def _tier(count: int, *, smoothed: bool) -> Tier:
    points = _smoothing(count) if smoothed else np.eye(count)
    places = _spline(count, np.linspace(0.0, HORIZON_S, FINE * STEPS + 1), 0) @ points
    velocities = _spline(count, np.linspace(0.0, HORIZON_S, STEPS + 1), 1) @ points
    return Tier(points, np.ascontiguousarray(places), np.ascontiguousarray(velocities))


def _smoothing(count: int) -> Floats:
    """From points on the way to the points that minimise the sum above."""
    near, slope, bend = np.eye(count), np.diff(np.eye(count), axis=0) * (count - 1) / HORIZON_S, np.diff(np.eye(count), 2, axis=0)
    wanted = NEAR * near + VELOCITY * slope.T @ slope
    weights = wanted + SMOOTH * bend.T @ bend
    for end in (0, -1):
        wanted[end] = weights[end] = near[end]
    return np.asarray(np.linalg.solve(weights, wanted), np.float64)


def _spline(count: int, times_s: Floats, derivative: int) -> Floats:
    """From values at evenly spaced knots over the horizon to those (or the slopes) of the natural cubic spline at some times."""
    width = HORIZON_S / (count - 1)
    eye = np.eye(count)
    system = eye.copy()
    for i in range(1, count - 1):
        system[i, i - 1 : i + 2] = 1.0, 4.0, 1.0
    sums = np.zeros((count, count))
    sums[1:-1] = np.diff(eye, 2, axis=0) * 6 / width**2
    bends = np.linalg.solve(system, sums)  # second derivatives at the knots, 0 at both ends
    knot = np.minimum((times_s / width).astype(np.int64), count - 2)
    u = (times_s / width - knot)[:, None]
    low, high, bent, bending = eye[knot], eye[knot + 1], bends[knot], bends[knot + 1]
    if derivative == 1:
        return np.asarray((high - low) / width + width / 6 * ((3 * u**2 - 1) * bending - (3 * (1 - u) ** 2 - 1) * bent))
    return np.asarray((1 - u) * low + u * high + width**2 / 6 * (((1 - u) ** 3 - (1 - u)) * bent + (u**3 - u) * bending))


def spline_at(points_m: Floats, times_s: Floats) -> Floats:
    """(len(times), 2) places of the natural spline through control points (count, 2)."""
    return _spline(len(points_m), np.asarray(times_s, np.float64), 0) @ points_m


@kernel
def rounded(
    corners: Floats, sides: Ints, tiers: tuple[Tier, ...], crowd: Crowd, places: Floats, velocities: Floats, points: Floats
) -> int:
    """Fills places (FINE STEPS + 1, 2), velocities (STEPS + 1, 2) and the control points, whose number it returns; 0 for none."""
    for tier in tiers:
        count = len(tier.points)
        on_way = np.empty((count, 2))
        _sampled(corners, on_way)
        _apply(tier.places, on_way, places)
        if _holds(places, corners, sides, crowd):
            _apply(tier.velocities, on_way, velocities)
            _apply(tier.points, on_way, points)
            return count
    return 0


@kernel
def _apply(matrix: Floats, values: Floats, out: Floats) -> None:
    """matrix @ values into the first rows of out (numba's own product wants scipy)."""
    for i in range(len(matrix)):
        for column in range(values.shape[1]):
            total = 0.0
            for j in range(len(values)):
                total += matrix[i, j] * values[j, column]
            out[i, column] = total


@kernel
def _sampled(corners: Floats, out: Floats) -> None:
    """The way at evenly spaced times."""
    corner, last = 0, len(corners) - 1
    for i in range(len(out)):
        stage = corners[last, 2] * i / (len(out) - 1)
        while corner < last - 1 and corners[corner + 1, 2] <= stage:
            corner += 1
        first, second = corners[corner], corners[corner + 1]
        share = (stage - first[2]) / (second[2] - first[2])
        out[i, 0] = first[0] + share * (second[0] - first[0])
        out[i, 1] = first[1] + share * (second[1] - first[1])


@kernel
def _holds(places: Floats, corners: Floats, sides: Ints, crowd: Crowd) -> bool:
    """Whether it touches nobody and passes everybody as the way does."""
    first, last = np.empty(3), np.empty(3)
    windings = np.zeros(len(sides))
    for i in range(len(places) - 1):
        first[0], first[1], first[2] = places[i, 0], places[i, 1], i / FINE
        last[0], last[1], last[2] = places[i + 1, 0], places[i + 1, 1], (i + 1) / FINE
        if not clear(first, last, crowd, crowd.contacts):
            return False
        for person in range(len(sides)):
            windings[person] += turned(first, last, crowd.tracks[person])
    unlike = 0
    for person in range(len(sides)):
        unlike += side(corners[0], corners[-1], windings[person], crowd, person) != sides[person]
    return unlike == 0
