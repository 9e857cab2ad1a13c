"""The tracks that trackers drive: one to tune on, another to be measured on. Fixed before any tracker was tuned. Pure.

Curvature changes linearly along each piece, as the steering of a real car does. Straights, S-curves, a hairpin, a corner tighter
than that, a stop at the end; the speeds follow from the limits of acceleration that a passenger of a delivery car accepts.
"""

from dataclasses import dataclass, replace

import numpy as np

from autonomy.planning.horizon import Floats
from autonomy.planning.reference_path import ReferencePath, through

FINE_M = 0.01  # of the integration
KNOT_M = 1.0
ROOM_M = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    pieces: tuple[tuple[float, float], ...]  # length in m, curvature at its end in 1/m, left positive
    speed_max_m_s: float = 15.0
    lateral_m_s2: float = 3.0
    acceleration_m_s2: float = 1.5
    braking_m_s2: float = 2.0


MEASURED = Track(
    pieces=(
        (110.0, 0.0),
        *((20.0, 1 / 40), (15.0, 1 / 40), (30.0, -1 / 40), (15.0, -1 / 40), (20.0, 0.0)),  # S-curves
        (20.0, 0.0),
        *((12.0, 1 / 9), (16.0, 1 / 9), (12.0, 0.0)),  # hairpin
        (30.0, 0.0),
        *((12.0, -1 / 30), (24.0, 1 / 30), (12.0, 0.0)),  # chicane
        *((8.0, -1 / 6), (4.0, -1 / 6), (8.0, 0.0)),  # tight corner
        (40.0, 0.0),
    )
)
_CORNERS = (*MEASURED.pieces[7:10], (5.0, 0.0), *MEASURED.pieces[14:17])
SLOW = replace(MEASURED, pieces=((5.0, 0.0), *_CORNERS, (5.0, 0.0)), speed_max_m_s=2.5)
"""Its hairpin and its tight corner at a walk."""
TUNING = Track(
    pieces=(
        (120.0, 0.0),
        *((15.0, -1 / 25), (10.0, -1 / 25), (15.0, 0.0)),
        (30.0, 0.0),
        *((10.0, 1 / 50), (20.0, -1 / 50), (10.0, 0.0)),
        *((10.0, -1 / 7.5), (14.0, -1 / 7.5), (10.0, 0.0)),
        *((18.0, 1 / 18), (10.0, 1 / 18), (18.0, 0.0)),
        (50.0, 0.0),
    )
)


def path_of(track: Track) -> ReferencePath:
    """From (0, 0) eastwards."""
    ends = np.cumsum([0.0, *(length for length, _ in track.pieces)])
    bends = np.array([0.0, *(bend for _, bend in track.pieces)])
    stations = np.arange(0.0, ends[-1] + FINE_M / 2, FINE_M)
    middles = np.interp((stations[:-1] + stations[1:]) / 2, ends, bends)
    headings = np.concatenate(([0.0], np.cumsum(middles * FINE_M)))
    halves = (headings[:-1] + headings[1:]) / 2
    points = np.cumsum(FINE_M * np.stack((np.cos(halves), np.sin(halves)), axis=1), axis=0)
    points = np.concatenate((np.zeros((1, 2)), points))
    knots = np.unique(np.append(np.arange(0, len(stations), round(KNOT_M / FINE_M)), len(stations) - 1))
    room = np.full(len(knots), ROOM_M)
    return through(points[knots], headings[knots], room, room)


def speeds_of(track: Track) -> tuple[Floats, Floats]:
    """Stations and the highest speeds there that keep to every limit, from standstill to standstill."""
    ends = np.cumsum([0.0, *(length for length, _ in track.pieces)])
    stations = np.linspace(0.0, ends[-1], round(ends[-1] / KNOT_M) + 1)
    bends = np.abs(np.interp(stations, ends, np.array([0.0, *(bend for _, bend in track.pieces)])))
    squares = np.minimum(track.speed_max_m_s**2, track.lateral_m_s2 / np.maximum(bends, 1e-6))
    squares[0] = squares[-1] = 0.0
    step = stations[1]
    for i in range(1, len(squares)):
        squares[i] = min(squares[i], squares[i - 1] + 2 * track.acceleration_m_s2 * step)
    for i in range(len(squares) - 2, -1, -1):
        squares[i] = min(squares[i], squares[i + 1] + 2 * track.braking_m_s2 * step)
    return stations, np.sqrt(squares)
