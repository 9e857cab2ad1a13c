"""Map frame to road coordinates (station, offset) for whole arrays, as the ground and its shadows need. Pure.

Agrees with wire.road.Road.to_road for every point that lies beside some piece of the road; wire's answers one point at a time.
"""

from dataclasses import dataclass
from itertools import accumulate
from math import cos, sin

import numpy as np

from vehicle_gateway.video.render.projection import Flags, Floats
from wire.road import Road

BEHIND_M, AHEAD_M = 80.0, 260.0  # stretch of road looked at around a station: more lies in the haze


@dataclass(frozen=True, slots=True)
class _Piece:
    station_m: float
    length_m: float
    curvature_1_m: float
    x_m: float
    y_m: float
    heading_rad: float
    is_first: bool
    is_last: bool


class RoadFrame:
    """The pieces of a road, ready to be asked for many points at once."""

    def __init__(self, road: Road) -> None:
        self._pieces: list[_Piece] = []
        starts = [0.0, *accumulate(segment.length_m for segment in road.map.segments)]
        stretches = [
            (start, segment.length_m, segment.curvature_1_m) for start, segment in zip(starts, road.map.segments, strict=False)
        ]
        if stretches[0][2] != 0.0:  # a road that starts or ends in a bend goes straight on from there
            stretches.insert(0, (-BEHIND_M, BEHIND_M, 0.0))
        if stretches[-1][2] != 0.0:
            stretches.append((starts[-1], AHEAD_M, 0.0))
        for i, (start, length, curvature) in enumerate(stretches):
            x, y, heading = road.to_world(start)
            self._pieces.append(_Piece(start, length, curvature, x, y, heading, i == 0, i == len(stretches) - 1))

    def to_road(
        self, x_m: Floats, y_m: Floats, origin_m: tuple[float, float] = (0.0, 0.0), near_station_m: float | None = None
    ) -> tuple[Floats, Floats]:
        """station_m and offset_m of points, in arrays of any one shape.

        x_m, y_m        map frame, relative to `origin_m` (keeps single precision exact far from the map's origin)
        near_station_m  only the road around this station is looked at
        """
        around = [
            piece
            for piece in self._pieces
            if near_station_m is None
            or (piece.station_m + piece.length_m > near_station_m - BEHIND_M and piece.station_m < near_station_m + AHEAD_M)
        ]
        first, *others = around or self._pieces[-1:]
        station, offset, beside = _on_piece(first, x_m, y_m, origin_m)
        distance = np.where(beside, np.abs(offset), np.float32(np.inf))
        for piece in others:
            s, o, beside = _on_piece(piece, x_m, y_m, origin_m)
            away = np.where(beside, np.abs(o), np.float32(np.inf))
            nearer = away < distance
            station, offset = np.where(nearer, s, station), np.where(nearer, o, offset)
            distance = np.minimum(away, distance)
        return station, offset


def _on_piece(piece: _Piece, x_m: Floats, y_m: Floats, origin_m: tuple[float, float]) -> tuple[Floats, Floats, Flags]:
    """station_m, offset_m, and whether the point lies beside the piece; ends of the road go straight on for ever."""
    c, s = np.float32(cos(piece.heading_rad)), np.float32(sin(piece.heading_rad))
    dx, dy = x_m + np.float32(origin_m[0] - piece.x_m), y_m + np.float32(origin_m[1] - piece.y_m)
    ahead, left = dx * c + dy * s, dy * c - dx * s
    k = np.float32(piece.curvature_1_m)
    if abs(k) < 1e-9:
        along, offset = ahead, left
    else:
        along = np.arctan2(k * ahead, 1 - k * left) / k
        offset = (1 - np.hypot(k * ahead, 1 - k * left)) / k
    beside: Flags = np.ones(along.shape, dtype=bool)
    if not piece.is_first:
        beside &= along >= 0
    if not piece.is_last:
        beside &= along <= np.float32(piece.length_m)
    return along + np.float32(piece.station_m), offset, beside
