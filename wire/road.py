"""Geometry of the road a map describes: arc-length coordinates (station, offset) and back. Pure; numpy inside.

station_m runs along the centre line from its start; offset_m is perpendicular to it, left positive. The centre line
divides the two directions of traffic: with drives_on "right" the own lane's middle lies at -lane_width/2.
"""

from bisect import bisect_right
from dataclasses import dataclass
from math import atan2, cos, hypot, pi, sin
from typing import NamedTuple

from wire.messages.automation import RoadMap


class RoadPoint(NamedTuple):
    station_m: float
    offset_m: float
    heading_rad: float  # of the centre line at that station


@dataclass(frozen=True, slots=True)
class _Piece:
    """One segment of constant curvature, with its start in the map frame."""

    station_m: float
    length_m: float
    curvature_1_m: float
    x_m: float
    y_m: float
    heading_rad: float
    slope_rad: float

    def at(self, along_m: float) -> tuple[float, float, float]:
        """x_m, y_m, heading_rad at `along_m` from the start of the piece (exact on line and circle)."""
        turned = self.curvature_1_m * along_m
        half = turned / 2
        chord = along_m * (sin(half) / half if abs(half) > 1e-9 else 1.0)
        return (
            self.x_m + chord * cos(self.heading_rad + half),
            self.y_m + chord * sin(self.heading_rad + half),
            self.heading_rad + turned,
        )

    def project(self, x_m: float, y_m: float) -> tuple[float, float]:
        """(along_m clamped to the piece, offset_m signed left positive of the closest point's tangent)."""
        dx, dy = x_m - self.x_m, y_m - self.y_m
        c, s = cos(self.heading_rad), sin(self.heading_rad)
        ahead, left = dx * c + dy * s, -dx * s + dy * c
        k = self.curvature_1_m
        along = ahead if abs(k) < 1e-9 else atan2(k * ahead, 1.0 - k * left) / k
        if not 0.0 <= along <= self.length_m:  # beyond the piece: the nearer of its ends
            along = min((0.0, self.length_m), key=lambda end: hypot(x_m - self.at(end)[0], y_m - self.at(end)[1]))
        px, py, heading = self.at(along)
        return along, -(x_m - px) * sin(heading) + (y_m - py) * cos(heading)


def wrap_angle(angle_rad: float) -> float:
    """The same direction in (-pi, pi]."""
    return angle_rad - 2 * pi * round(angle_rad / (2 * pi))


class Road:
    """A map as geometry. Cheap to build; every method is pure."""

    def __init__(self, road_map: RoadMap) -> None:
        self.map = road_map
        self._pieces: list[_Piece] = []
        station, (x, y), heading = 0.0, road_map.start, road_map.start_heading_rad
        for segment in road_map.segments:
            piece = _Piece(station, segment.length_m, segment.curvature_1_m, x, y, heading, segment.slope_rad)
            self._pieces.append(piece)
            x, y, heading = piece.at(segment.length_m)
            station += segment.length_m
        self.length_m = station
        self._starts = [piece.station_m for piece in self._pieces]
        self.own_side = -1.0 if road_map.drives_on == "right" else 1.0  # sign of the offset of the own lane
        self.own_lane_offset_m = self.own_side * road_map.lane_width_m / 2
        self.half_width_m = road_map.lane_width_m  # one lane each way: kerb at +- this offset

    def to_world(self, station_m: float, offset_m: float = 0.0) -> tuple[float, float, float]:
        """x_m, y_m (map frame) and the heading of the centre line there. Beyond the ends: straight on."""
        piece = self._pieces[max(0, bisect_right(self._starts, station_m) - 1)]
        along = station_m - piece.station_m
        inside = min(max(along, 0.0), piece.length_m)
        x, y, heading = piece.at(inside)
        over = along - inside
        return (
            x + over * cos(heading) - offset_m * sin(heading),
            y + over * sin(heading) + offset_m * cos(heading),
            heading,
        )

    def to_road(self, x_m: float, y_m: float, near_station_m: float | None = None) -> RoadPoint:
        """The road coordinates of a point: those of the closest point of the centre line.

        near_station_m  only pieces within 60 m of it are looked at (a road may pass near itself)
        """
        best: tuple[float, _Piece, float, float] | None = None
        for piece in self._pieces:
            if near_station_m is not None and not (piece.station_m - 60 <= near_station_m <= piece.station_m + piece.length_m + 60):
                continue
            along, offset = piece.project(x_m, y_m)
            px, py, _ = piece.at(along)
            distance = hypot(x_m - px, y_m - py)
            if best is None or distance < best[0] - 1e-9:
                best = (distance, piece, along, offset)
        if best is None:
            return self.to_road(x_m, y_m)
        _, piece, along, offset = best
        px, py, heading = piece.at(along)
        ahead = (x_m - px) * cos(heading) + (y_m - py) * sin(heading)
        beyond_end = (piece is self._pieces[-1] and along >= piece.length_m and ahead > 0) or (
            piece is self._pieces[0] and along <= 0 and ahead < 0
        )
        return RoadPoint(piece.station_m + along + (ahead if beyond_end else 0.0), offset, wrap_angle(heading))

    def curvature_1_m(self, station_m: float) -> float:
        """Of the centre line, left positive."""
        return self._pieces[max(0, bisect_right(self._starts, station_m) - 1)].curvature_1_m

    def slope_rad(self, station_m: float) -> float:
        """Uphill along the road positive."""
        return self._pieces[max(0, bisect_right(self._starts, station_m) - 1)].slope_rad
