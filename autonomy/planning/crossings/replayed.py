"""Recorded people from a CSV that a user supplies: frame, id, x_m, y_m, one line each, any order. Pure but for the reading.

They walk as they walked, whatever the car does. Between two frames the place is linear; before its first and after its last
frame a person is not there.
"""

import csv
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from autonomy.planning.horizon import Floats
from wire.configuration import ConfigurationError

COLUMNS = ("frame", "id", "x_m", "y_m")


@dataclass(frozen=True, slots=True)
class Track:
    number: int
    times_s: Floats  # (k,) growing, k >= 2
    places_m: Floats  # (k, 2)


@dataclass(frozen=True, slots=True)
class Tracks:
    people: tuple[Track, ...]

    def at(self, time_s: float) -> tuple[tuple[int, ...], Floats, Floats]:
        """Who is there: numbers, places (n, 2), velocities (n, 2)."""
        there = [track for track in self.people if track.times_s[0] <= time_s <= track.times_s[-1]]
        seen = [_moment(track, time_s) for track in there]
        places, velocities = (np.array([each[k] for each in seen], float).reshape(-1, 2) for k in (0, 1))
        return tuple(track.number for track in there), places, velocities


def _moment(track: Track, time_s: float) -> tuple[Floats, Floats]:
    k = min(int(np.searchsorted(track.times_s, time_s, "right")), len(track.times_s) - 1)
    (t0, t1), (p0, p1) = track.times_s[k - 1 : k + 1], track.places_m[k - 1 : k + 1]
    return p0 + (p1 - p0) * ((time_s - t0) / (t1 - t0)), (p1 - p0) / (t1 - t0)


def read_tracks(path: Path, frames_hz: float) -> Tracks:
    """Raises ConfigurationError that names the line and the fix. Somebody seen in one frame only is left out."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ConfigurationError(f"{path}: cannot be read: {error}; name a CSV with the columns {', '.join(COLUMNS)}") from None
    if not rows or not set(COLUMNS) <= set(rows[0]):
        raise ConfigurationError(f"{path}: its first line must name the columns {', '.join(COLUMNS)}, and people follow")
    seen: dict[int, dict[float, tuple[float, float]]] = {}
    for line, row in enumerate(rows, 2):
        frame, number, x, y = _numbers(path, line, row)
        seen.setdefault(int(number), {})[frame / frames_hz] = (x, y)
    first_s = min(min(moments) for moments in seen.values())
    return Tracks(tuple(_track(number, moments, first_s) for number, moments in sorted(seen.items()) if len(moments) > 1))


def _numbers(path: Path, line: int, row: dict[str, str]) -> list[float]:
    try:
        values = [float(row[name]) for name in COLUMNS]
    except (TypeError, ValueError):
        values = [float("nan")]
    if not all(map(isfinite, values)):
        raise ConfigurationError(f"{path}: line {line}: {', '.join(COLUMNS)} must be numbers")
    return values


def _track(number: int, moments: dict[float, tuple[float, float]], first_s: float) -> Track:
    times = sorted(moments)
    return Track(number, np.array(times) - first_s, np.array([moments[time] for time in times]))
