"""Who counts, and as what: predictions as arrays for the kernels. Pure; what is not a number is left out, and said.

Someone who never comes near where the car can be (the room beside the path up to the farthest goal) is no matter of
guidance: passing them on one side or the other is not a choice.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from autonomy.planning.guidance.clearance import Crowd
from autonomy.planning.guidance.line import BEHIND_M, BEYOND_M, HEADING, HIGH, LOW, VERTICES, Line, at, foot
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.horizon import STEPS, Floats, Predictions
from autonomy.planning.kernels import kernel

SIDE_M = 1.0  # beyond the room; also what someone moves aside within a step
NEARER = 0.95  # of the distance that someone has who is too near already: the way leads away from them
TOUCHING = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class People:
    numbers: tuple[int, ...]  # of those who count, in the order of the crowd
    left_out: tuple[int, ...]  # their prediction is no number, or has another shape
    crowd: Crowd
    nearest_m: float  # from the car's middle to the middle of anybody, now


def people(predictions: Predictions, line: Line, start: Floats, settings: GuidanceSettings) -> People:
    """start: the node where the car's middle is now."""
    tracks, radii, good = _sound(predictions)
    headings = np.empty(tracks.shape[:2])
    near = np.empty(len(tracks), np.bool_)
    off_road = max(at(line, start[3], LOW) - start[4], start[4] - at(line, start[3], HIGH), 0.0)
    reach = np.max(radii, initial=0.0) + settings.half_width_m + settings.margin_m + SIDE_M + off_road
    _project(line, tracks, float(reach), headings, near)
    tracks, headings, contacts = tracks[near], headings[near], radii[near] + settings.half_width_m
    now = np.hypot(tracks[:, 0, 0] - start[0], tracks[:, 0, 1] - start[1])
    paces = np.hypot(*np.diff(tracks, axis=1).T).max(axis=0, initial=0.0)
    clearances = np.minimum(contacts + settings.margin_m, NEARER * now)
    crowd = Crowd(tracks, headings, clearances, np.minimum(contacts, TOUCHING * now), paces)
    numbers = np.array(predictions.numbers, np.int64)
    return People(
        numbers=tuple(numbers[good][near].tolist()) if len(good) else (),
        left_out=tuple(numbers[~good].tolist()) if len(good) else predictions.numbers,
        crowd=crowd,
        nearest_m=float(now.min(initial=np.inf)),
    )


def _sound(predictions: Predictions) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Tracks (n, STEPS + 1, 2) and radii of those whose every number is one; nobody when the shapes are wrong."""
    count = predictions.count
    if predictions.positions_m.shape != (STEPS + 1, count, 2) or predictions.radii_m.shape != (count,):
        return np.empty((0, STEPS + 1, 2)), np.empty(0), np.zeros(0, np.bool_)
    tracks = np.ascontiguousarray(predictions.positions_m.transpose(1, 0, 2), np.float64)
    good = np.isfinite(tracks).all(axis=(1, 2)) & (predictions.radii_m >= 0.0) & (predictions.radii_m < np.inf)
    return tracks[good], np.asarray(predictions.radii_m, np.float64)[good], good


@kernel
def _project(line: Line, tracks: Floats, reach_m: float, headings: Floats, near: NDArray[np.bool_]) -> None:
    """Headings of the path where everybody is, and whether they ever come as near as reach_m to the car's room."""
    low, high = line.first_m + BEHIND_M - reach_m, line.first_m + (VERTICES - 1) * line.spacing_m - BEYOND_M + reach_m
    for person in range(len(tracks)):
        vertex = -1
        near[person] = False
        for k in range(tracks.shape[1]):
            station, offset, vertex = foot(line, tracks[person, k, 0], tracks[person, k, 1], vertex)
            headings[person, k] = line.vertices[vertex, HEADING]
            beside = at(line, station, LOW) - reach_m <= offset <= at(line, station, HIGH) + reach_m
            near[person] |= low <= station <= high and beside
