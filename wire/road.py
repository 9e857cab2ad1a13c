"""Geometry of the road a map describes: arc-length coordinates (station, offset) and back. Pure; numpy inside.

station_m runs along the centre line from its start; offset_m is perpendicular to it, left positive. The centre line
divides the two directions of traffic: with drives_on "right" the own lane's middle lies at -lane_width/2.
"""

from bisect import bisect_right
from dataclasses import dataclass, replace
from math import atan2, cos, hypot, inf, pi, sin
from typing import NamedTuple

from wire.messages.automation import RoadMap, RoadSegment


class RoadPoint(NamedTuple):
    station_m: float
    offset_m: float
    heading_rad: float  # of the centre line at that station


Pose = tuple[float, float, float]  # x_m, y_m (map frame), heading_rad
NOWHERE: Pose = (0.0, 0.0, 0.0)
APART_M = 1e-3  # more than two distances differ by rounding


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
    cos: float  # of heading_rad
    sin: float
    start: Pose = NOWHERE
    end: Pose = NOWHERE
    anchor: Pose = NOWHERE  # a point that `nearest` never misses: the middle, or, of a bend of more than half a turn, the start
    reach_m: float = 0.0  # no point of it is farther from there

    def at(self, along_m: float) -> Pose:
        """x_m, y_m, heading_rad at `along_m` from the start of the piece (exact on line and circle)."""
        turned = self.curvature_1_m * along_m
        half = turned / 2
        chord = along_m * (sin(half) / half if abs(half) > 1e-9 else 1.0)
        return (
            self.x_m + chord * cos(self.heading_rad + half),
            self.y_m + chord * sin(self.heading_rad + half),
            self.heading_rad + turned,
        )

    def nearest(self, x_m: float, y_m: float) -> tuple[float, float, float, float]:
        """Its point closest to (x_m, y_m): along_m from its start, x_m, y_m, heading_rad."""
        dx, dy, c, s = x_m - self.x_m, y_m - self.y_m, self.cos, self.sin
        ahead, left = dx * c + dy * s, -dx * s + dy * c
        k = self.curvature_1_m
        along = ahead if abs(k) < 1e-9 else atan2(k * ahead, 1.0 - k * left) / k
        if along < 0.0 and abs(k) >= 1e-9:
            along += 2 * pi / abs(k)  # the second half of a turn
        if 0.0 <= along <= self.length_m:
            return along, *self.at(along)
        (sx, sy, _), (ex, ey, _) = self.start, self.end  # beyond the piece: the nearer of its ends
        at_start = hypot(x_m - sx, y_m - sy) <= hypot(x_m - ex, y_m - ey)
        return (0.0, *self.start) if at_start else (self.length_m, *self.end)


def _piece(station_m: float, segment: RoadSegment, x_m: float, y_m: float, heading_rad: float) -> _Piece:
    bare = _Piece(
        station_m,
        segment.length_m,
        segment.curvature_1_m,
        x_m,
        y_m,
        heading_rad,
        segment.slope_rad,
        cos(heading_rad),
        sin(heading_rad),
    )
    reach_m = segment.length_m / 2 if abs(segment.curvature_1_m) * segment.length_m <= pi else segment.length_m
    anchor = bare.at(segment.length_m - reach_m)
    return replace(bare, start=bare.at(0.0), end=bare.at(segment.length_m), anchor=anchor, reach_m=reach_m)


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
            piece = _piece(station, segment, x, y, heading)
            self._pieces.append(piece)
            x, y, heading = piece.end
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
        pieces = self._pieces if near_station_m is None else self._about(near_station_m)
        anchors = [hypot(x_m - piece.anchor[0], y_m - piece.anchor[1]) for piece in pieces]
        piece, least_m, found = pieces[0], inf, (0.0, *NOWHERE)
        most_m = min(anchors) + APART_M  # an anchor is a point of the road: the closest one is no farther
        for each, anchor_m in zip(pieces, anchors, strict=True):
            if anchor_m - each.reach_m > most_m:  # most pieces are far off
                continue
            nearest = each.nearest(x_m, y_m)
            distance = hypot(x_m - nearest[1], y_m - nearest[2])
            if distance < least_m - 1e-9:
                piece, least_m, found = each, distance, nearest
        return self._beside(piece, found, x_m, y_m)

    def _about(self, station_m: float) -> list[_Piece]:
        """The pieces within 60 m of a station; all of them where there is none."""
        about = [piece for piece in self._pieces if piece.station_m - 60 <= station_m <= piece.station_m + piece.length_m + 60]
        return about or self._pieces

    def _beside(self, piece: _Piece, nearest: tuple[float, float, float, float], x_m: float, y_m: float) -> RoadPoint:
        """The road coordinates of a point whose closest one is known."""
        along, px, py, heading = nearest
        dx, dy, c, s = x_m - px, y_m - py, cos(heading), sin(heading)
        ahead = dx * c + dy * s
        beyond_end = (piece is self._pieces[-1] and along >= piece.length_m and ahead > 0) or (
            piece is self._pieces[0] and along <= 0 and ahead < 0
        )
        return RoadPoint(piece.station_m + along + (ahead if beyond_end else 0.0), -dx * s + dy * c, wrap_angle(heading))

    def curvature_1_m(self, station_m: float) -> float:
        """Of the centre line, left positive."""
        return self._pieces[max(0, bisect_right(self._starts, station_m) - 1)].curvature_1_m

    def slope_rad(self, station_m: float) -> float:
        """Uphill along the road positive."""
        return self._pieces[max(0, bisect_right(self._starts, station_m) - 1)].slope_rad
