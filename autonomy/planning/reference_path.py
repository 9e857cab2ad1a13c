"""The line a planner follows, as cubic pieces x(s), y(s) with room to either side: what its kernels read. Pure.

Source of the form: the paper, III-D ("a sequence of cubic splines" for x and y each).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from autonomy.planning.horizon import Floats
from wire.road import Road

PIECE_M = 5.0


@dataclass(frozen=True, slots=True)
class ReferencePath:
    """M pieces from knot to knot; before the first and beyond the last the line goes straight on."""

    knots_m: Floats  # (M + 1,) growing; distances along the line
    x_coefficients: Floats  # (M, 4): x = ((c0 d + c1) d + c2) d + c3, d = s - knot
    y_coefficients: Floats  # (M, 4)
    room_left_m: Floats  # (M + 1,) from the line to the edge of what may be driven on, at the knots; linear between
    room_right_m: Floats  # (M + 1,) positive

    @property
    def first_m(self) -> float:
        return float(self.knots_m[0])

    @property
    def last_m(self) -> float:
        return float(self.knots_m[-1])

    def at(self, station_m: float) -> tuple[float, float, float]:
        """x_m, y_m, heading_rad of the line."""
        inside = min(max(station_m, self.first_m), self.last_m)
        piece = min(max(int(np.searchsorted(self.knots_m, inside, "right")) - 1, 0), len(self.x_coefficients) - 1)
        d = inside - self.knots_m[piece]
        powers, slopes = np.array([d**3, d**2, d, 1.0]), np.array([3 * d**2, 2 * d, 1.0, 0.0])
        x, y = self.x_coefficients[piece] @ powers, self.y_coefficients[piece] @ powers
        heading = float(np.arctan2(self.y_coefficients[piece] @ slopes, self.x_coefficients[piece] @ slopes))
        over = station_m - inside
        return float(x + over * np.cos(heading)), float(y + over * np.sin(heading)), heading


def through(points_m: Floats, headings_rad: Floats, room_left_m: Floats, room_right_m: Floats) -> ReferencePath:
    """Hermite pieces through points (M + 1, 2) with the line's headings there; knots are arc lengths of the pieces' chords.

    Raises ValueError for fewer than two points, points that coincide, or a line that crosses itself backwards.
    """
    chords = np.diff(points_m, axis=0)
    lengths = np.hypot(chords[:, 0], chords[:, 1]) if len(points_m) > 1 else np.zeros(0)
    if len(lengths) < 1 or lengths.min() < 1e-3 or not np.isfinite(points_m).all():
        raise ValueError("a reference path needs two points and more, each apart from the next")
    turns = np.abs((np.diff(np.arctan2(chords[:, 1], chords[:, 0])) + np.pi) % (2 * np.pi) - np.pi)
    if (turns > np.pi / 2).any():
        raise ValueError("a reference path does not turn back on itself")
    bends = np.abs((np.diff(headings_rad) + np.pi) % (2 * np.pi) - np.pi)
    lengths = lengths * np.where(bends > 1e-6, bends / 2 / np.maximum(np.sin(bends / 2), 1e-9), 1.0)  # arc over chord of a circle
    knots = np.concatenate(([0.0], np.cumsum(lengths)))
    tangents = np.stack((np.cos(headings_rad), np.sin(headings_rad)), axis=1)
    x, y = (_hermite(points_m[:, k], tangents[:, k], lengths) for k in (0, 1))
    return ReferencePath(knots, x, y, room_left_m, room_right_m)


def _hermite(values: Floats, slopes: Floats, lengths: Floats) -> Floats:
    """(M, 4) coefficients, highest power first, of the cubics with these values and slopes at their ends."""
    rise = np.diff(values) / lengths
    first, last = slopes[:-1], slopes[1:]
    return np.stack(((first + last - 2 * rise) / lengths**2, (3 * rise - 2 * first - last) / lengths, first, values[:-1]), axis=1)


def lane_path(
    road: Road, offset_m: Callable[[float], float], from_m: float, to_m: float, low_m: float, high_m: float
) -> ReferencePath:
    """The line at `offset_m(station)` of a road, and its room to the offsets low and high (left positive)."""
    count = max(int(np.ceil((to_m - from_m) / PIECE_M)), 1)
    stations = np.linspace(from_m, to_m, count + 1)
    offsets = np.array([offset_m(float(station)) for station in stations])
    places = [road.to_world(float(s), float(o)) for s, o in zip(stations, offsets, strict=True)]
    points = np.array([place[:2] for place in places])
    slant = np.arctan(np.gradient(offsets, stations))
    headings = np.array([place[2] for place in places]) + slant
    return through(points, headings, high_m - offsets, offsets - low_m)
