"""The reference path inside the kernels: place, tangent, curvature and room at a station, beyond the ends straight on. Pure.

The same line as `reference_path.ReferencePath.at`; the tests hold the two together.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.reference_path import ReferencePath

KNOT, CUBIC_X, CUBIC_Y, LEFT, RIGHT, COLUMNS = 0, 1, 5, 9, 11, 13  # of a piece; LEFT and RIGHT: room at the knot, its slope


class Spot(NamedTuple):
    x: float
    y: float
    tangent_x: float  # of length 1
    tangent_y: float
    stretch: float  # metres of the line per metre of station, near 1
    bend: float  # rad of heading per metre of station
    left: float  # room
    right: float
    left_slope: float  # room per metre of station
    right_slope: float


def table(path: ReferencePath) -> Floats:
    """(M + 1, 13): one row a piece; the last has its knot only."""
    parts = (path.knots_m, path.x_coefficients, path.y_coefficients, path.room_left_m, path.room_right_m)
    return _table(*(np.array(part, dtype=np.float64, order="C") for part in parts))


@fast_kernel
def _table(knots: Floats, x: Floats, y: Floats, left: Floats, right: Floats) -> Floats:
    pieces = np.zeros((len(knots), COLUMNS))
    pieces[:, KNOT] = knots
    for i in range(len(knots) - 1):
        pieces[i, CUBIC_X:CUBIC_Y], pieces[i, CUBIC_Y:LEFT] = x[i], y[i]
        length = knots[i + 1] - knots[i]
        pieces[i, LEFT], pieces[i, LEFT + 1] = left[i], (left[i + 1] - left[i]) / length
        pieces[i, RIGHT], pieces[i, RIGHT + 1] = right[i], (right[i + 1] - right[i]) / length
    return pieces


@fast_kernel
def piece_of(line: Floats, station: float, near: int) -> int:
    """Which piece a station lies on, sought from one that is near."""
    last = len(line) - 2
    while near < last and station >= line[near + 1, KNOT]:
        near += 1
    while near > 0 and station < line[near, KNOT]:
        near -= 1
    return near


@fast_kernel
def spot(line: Floats, station: float, piece: int) -> Spot:
    """`piece` as `piece_of` tells."""
    inside = min(max(station, line[0, KNOT]), line[len(line) - 1, KNOT])
    d, over = inside - line[piece, KNOT], station - inside
    x, x1, x2 = cubic(line, piece, CUBIC_X, d)
    y, y1, y2 = cubic(line, piece, CUBIC_Y, d)
    stretch = sqrt(x1 * x1 + y1 * y1)
    tx, ty = x1 / stretch, y1 / stretch
    left, right = line[piece, LEFT] + line[piece, LEFT + 1] * d, line[piece, RIGHT] + line[piece, RIGHT + 1] * d
    if over != 0.0:
        return Spot(x + over * tx, y + over * ty, tx, ty, 1.0, 0.0, left, right, 0.0, 0.0)
    return Spot(x, y, tx, ty, stretch, (tx * y2 - ty * x2) / stretch, left, right, line[piece, LEFT + 1], line[piece, RIGHT + 1])


@fast_kernel
def cubic(line: Floats, piece: int, at: int, d: float) -> tuple[float, float, float]:
    """Its value and first two derivatives."""
    a, b, c = line[piece, at], line[piece, at + 1], line[piece, at + 2]
    return ((a * d + b) * d + c) * d + line[piece, at + 3], (3.0 * a * d + 2.0 * b) * d + c, 6.0 * a * d + 2.0 * b
