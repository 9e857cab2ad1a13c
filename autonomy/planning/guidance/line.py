"""The reference path near the car as a chain of vertices: where a station lies, and which station a place has. Kernels.

Chords of at most 1.1 m (the car at 7 m/s): in a bend of 10 m radius they lie 15 mm inside it.
"""

from math import atan2, ceil, cos, floor, hypot, pi, sin
from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel
from autonomy.planning.reference_path import ReferencePath

VERTICES = 64
BEHIND_M = 5.0  # of the car
BEYOND_M = 10.0  # the last goal
X, Y, COS, SIN, HEADING, LOW, HIGH = range(7)  # columns; low and high: offsets of the car's middle, left positive


class Line(NamedTuple):
    first_m: float  # station of the first vertex
    spacing_m: float
    vertices: Floats  # (VERTICES, 7)


def line_of(path: ReferencePath, station_m: float, reach_m: float, half_width_m: float) -> Line:
    """From behind the station to beyond its reach."""
    line = Line(station_m - BEHIND_M, (reach_m + BEHIND_M + BEYOND_M) / (VERTICES - 1), np.empty((VERTICES, 7)))
    rooms = path.room_left_m, path.room_right_m
    _trace(line, path.knots_m, path.x_coefficients, path.y_coefficients, *rooms, half_width_m)
    return line


@kernel
def _trace(line: Line, knots: Floats, x_pieces: Floats, y_pieces: Floats, left: Floats, right: Floats, half_width_m: float) -> None:
    """Fills the vertices; before its first knot and beyond its last the path goes straight on."""
    piece, heading = 0, 0.0
    for i in range(len(line.vertices)):
        station = line.first_m + i * line.spacing_m
        inside = min(max(station, knots[0]), knots[-1])
        while piece < len(x_pieces) - 1 and knots[piece + 1] <= inside:
            piece += 1
        d = inside - knots[piece]
        a, b = x_pieces[piece], y_pieces[piece]
        turned = atan2((3 * b[0] * d + 2 * b[1]) * d + b[2], (3 * a[0] * d + 2 * a[1]) * d + a[2])
        heading = turned if i == 0 else heading + wrapped(turned - heading)  # continuous: it may pass pi
        c, s, over = cos(turned), sin(turned), station - inside
        share = d / (knots[piece + 1] - knots[piece])
        vertex = line.vertices[i]
        vertex[X] = ((a[0] * d + a[1]) * d + a[2]) * d + a[3] + over * c
        vertex[Y] = ((b[0] * d + b[1]) * d + b[2]) * d + b[3] + over * s
        vertex[COS], vertex[SIN], vertex[HEADING] = c, s, heading
        vertex[LOW] = half_width_m - (right[piece] + share * (right[piece + 1] - right[piece]))
        vertex[HIGH] = left[piece] + share * (left[piece + 1] - left[piece]) - half_width_m


@kernel
def wrapped(angle_rad: float) -> float:
    """Into -pi..pi."""
    return angle_rad - 2 * pi * ceil((angle_rad - pi) / (2 * pi))


@kernel
def at(line: Line, station_m: float, column: int) -> float:
    """One column at a station, linear between vertices."""
    along = (station_m - line.first_m) / line.spacing_m
    i = min(max(int(floor(along)), 0), len(line.vertices) - 2)
    low, high = line.vertices[i, column], line.vertices[i + 1, column]
    return float(low + (along - i) * (high - low))


@kernel
def place(line: Line, station_m: float, offset_m: float) -> tuple[float, float]:
    """x_m, y_m at a station and an offset, left positive."""
    c, s = at(line, station_m, COS), at(line, station_m, SIN)
    long = hypot(c, s)
    return at(line, station_m, X) - offset_m * s / long, at(line, station_m, Y) + offset_m * c / long


@kernel
def foot(line: Line, x_m: float, y_m: float, near: int) -> tuple[float, float, int]:
    """station_m, offset_m and the nearest vertex; found downhill from vertex `near`, among all when that is below 0."""
    vertices = line.vertices
    best = near
    if near < 0:
        best = 0
        for i in range(1, len(vertices)):
            if _square(vertices[i], x_m, y_m) < _square(vertices[best], x_m, y_m):
                best = i
    else:
        for way in (-1, 1):
            while 0 <= best + way < len(vertices) and _square(vertices[best + way], x_m, y_m) < _square(vertices[best], x_m, y_m):
                best += way
    dx, dy = x_m - vertices[best, X], y_m - vertices[best, Y]
    c, s = vertices[best, COS], vertices[best, SIN]
    return line.first_m + best * line.spacing_m + c * dx + s * dy, c * dy - s * dx, best


@kernel
def _square(vertex: Floats, x_m: float, y_m: float) -> float:
    return float((vertex[X] - x_m) ** 2 + (vertex[Y] - y_m) ** 2)
