"""Recorded people from a CSV that a user supplies: frame, id, x_m, y_m, one line each, any order. Pure but for the reading.

They walk as they walked, whatever the car does. Between two frames the place is linear; before its first and after its last
frame a person is not there. Whatever their ids are in the file, they are numbered in the order of those, from 0 on.
"""

import csv
from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite
from pathlib import Path

import numpy as np

from autonomy.planning.horizon import Floats
from wire.configuration import ConfigurationError

COLUMNS = ("frame", "id", "x_m", "y_m")
PEOPLE_MAX = 9000  # drive.py numbers them before things
FARTHEST_M = 1e6  # from the origin


@dataclass(frozen=True, slots=True)
class Track:
    number: int  # the file's id
    times_s: Floats  # (k,) growing, k >= 2
    places_m: Floats  # (k, 2)


@dataclass(frozen=True, slots=True)
class Tracks:
    people: tuple[Track, ...]

    def at(self, time_s: float) -> tuple[tuple[int, ...], Floats, Floats]:
        """Who is there: which of `people`, places (n, 2), velocities (n, 2)."""
        there = [k for k, track in enumerate(self.people) if track.times_s[0] <= time_s <= track.times_s[-1]]
        seen = [_moment(self.people[k], time_s) for k in there]
        places, velocities = (np.array([each[k] for each in seen], float).reshape(-1, 2) for k in (0, 1))
        return tuple(there), places, velocities


def _moment(track: Track, time_s: float) -> tuple[Floats, Floats]:
    k = min(int(np.searchsorted(track.times_s, time_s, "right")), len(track.times_s) - 1)
    (t0, t1), (p0, p1) = track.times_s[k - 1 : k + 1], track.places_m[k - 1 : k + 1]
    return p0 + (p1 - p0) * ((time_s - t0) / (t1 - t0)), (p1 - p0) / (t1 - t0)


def read_tracks(path: Path, frames_hz: float) -> Tracks:
    """Raises ConfigurationError that names the line and the fix. Somebody seen in one frame only is left out."""
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            first, *lines = list(csv.reader(file)) or [[]]
    except (OSError, ValueError, csv.Error) as error:
        raise ConfigurationError(f"{path}: cannot be read: {error}; name a CSV with the columns {', '.join(COLUMNS)}") from None
    seen: dict[int, dict[float, Place]] = {}
    for line, (frame, number, place) in _rows(path, [name.strip() for name in first], lines):
        if seen.setdefault(number, {}).setdefault(frame / frames_hz, place) != place:
            raise ConfigurationError(f"{path}: line {line}: id {number} is in two places in frame {frame:g}; leave one out")
    there = sorted(number for number, moments in seen.items() if len(moments) > 1)
    if not 0 < len(there) <= PEOPLE_MAX:
        raise ConfigurationError(f"{path}: {len(there)} people in two frames and more; from 1 to {PEOPLE_MAX} can be replayed")
    first_s = min(min(moments) for moments in seen.values())
    return Tracks(tuple(_track(number, seen[number], first_s) for number in there))


Place = tuple[float, float]  # x_m, y_m


def _rows(path: Path, names: list[str], lines: list[list[str]]) -> Iterator[tuple[int, tuple[float, int, Place]]]:
    """Number of the line, and what it says: frame, id, place. Empty ones are left out."""
    if not set(COLUMNS) <= set(names):
        told = ",".join(names)[:60]
        raise ConfigurationError(f"{path}: its first line is {told!r}; it must name {', '.join(COLUMNS)}, with commas between them")
    columns = [names.index(name) for name in COLUMNS]
    for line, values in enumerate(lines, 2):
        if values:
            yield line, _row(path, line, [values[column] if column < len(values) else "" for column in columns])


def _row(path: Path, line: int, values: list[str]) -> tuple[float, int, Place]:
    try:
        frame, x, y = (float(values[k]) for k in (0, 2, 3))
        number = _whole(values[1])
    except ValueError:
        frame, number, x, y = float("nan"), 0, 0.0, 0.0
    if not (isfinite(frame) and abs(x) <= FARTHEST_M and abs(y) <= FARTHEST_M):
        columns = ", ".join(COLUMNS)
        raise ConfigurationError(f"{path}: line {line}: {columns} must be numbers, id a whole one, places within {FARTHEST_M:g} m")
    return frame, number, (x, y)


def _whole(text: str) -> int:
    """Also of 12.0, as some exports write it. Raises ValueError for what is no whole number."""
    try:
        return int(text)
    except ValueError:
        value = float(text)
        if not value.is_integer():
            raise
        return int(value)


def _track(number: int, moments: dict[float, Place], first_s: float) -> Track:
    times = sorted(moments)
    return Track(number, np.array(times) - first_s, np.array([moments[time] for time in times]))
