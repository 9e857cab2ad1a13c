"""What the tracker follows: a line with the speeds wanted along it, and what its kernels read of both. Pure.

Speed squared is linear between stations: a car that keeps to it accelerates evenly from one to the next. So a start from
standstill is no riddle, as it were with speeds that depend on the place alone: at speed 0 the acceleration says where to.
"""

from dataclasses import dataclass

import numpy as np

from autonomy.control.mpcc.stages import STAGE_S, STAGES
from autonomy.planning.horizon import Floats, Trajectory
from autonomy.planning.kernels import kernel
from autonomy.planning.mpc.line import KNOT, piece_of, spot, table
from autonomy.planning.reference_path import ReferencePath, through

APART_M = 0.1  # points of a trajectory nearer to each other are one
AHEAD_M = 1.0  # of a line for a car that stands
FAR = 1e7  # no map is larger, no speed
EVEN = 1e-9  # m2/s2


@dataclass(frozen=True, slots=True)
class Reference:
    """Made once per plan. Its line goes straight on beyond its ends, with the speeds there."""

    line: Floats  # (M + 1, 13), see planning/mpc/line.py
    stations_m: Floats  # (P,) growing
    squares_m2_s2: Floats  # (P,) of the speeds wanted there

    @property
    def first_m(self) -> float:
        return float(self.line[0, KNOT])

    @property
    def last_m(self) -> float:
        return float(self.line[-1, KNOT])


def along(path: ReferencePath, stations_m: Floats, speeds_m_s: Floats) -> Reference | None:
    """None for anything that is no line with speeds: too short, of different lengths, not growing, no numbers, below zero."""
    stations, speeds = np.array(stations_m, dtype=np.float64), np.array(speeds_m_s, dtype=np.float64)
    if not _is_line(path) or stations.ndim != 1 or stations.shape != speeds.shape or len(stations) < 2:
        return None
    line = table(path)
    numbers = all(bool((np.abs(values) < FAR).all()) for values in (line, stations, speeds))  # not for NaN
    grows = bool((np.diff(stations) > 0.0).all() and (np.diff(path.knots_m) > 0.0).all())
    return Reference(line, stations, speeds * speeds) if numbers and grows and bool((speeds >= 0.0).all()) else None


def _is_line(path: ReferencePath) -> bool:
    """Every piece and knot is there."""
    knots = path.knots_m.shape
    cubics = (knots[0] - 1, 4)
    pieces = path.x_coefficients.shape == cubics and path.y_coefficients.shape == cubics
    return knots[0] >= 2 and pieces and path.room_left_m.shape == path.room_right_m.shape == knots


def of_trajectory(trajectory: Trajectory) -> Reference | None:
    """The line through a planned trajectory's rear axles, with its speeds; where it stands, its line ends. None: not feasible."""
    states = trajectory.states
    if not trajectory.feasible or states.ndim != 2 or states.shape[1] != 6 or len(states) < 1 or not np.isfinite(states).all():
        return None
    kept = [0]
    for i in range(1, len(states)):
        if np.hypot(*(states[i, :2] - states[kept[-1], :2])) >= APART_M:
            kept.append(i)
    points, headings, speeds = states[kept, :2], states[kept, 2], np.maximum(states[kept, 3], 0.0)
    if len(kept) == 1:  # it stands
        points = np.stack((points[0], points[0] + AHEAD_M * np.array((np.cos(headings[0]), np.sin(headings[0])))))
        headings, speeds = np.repeat(headings, 2), np.zeros(2)
    try:
        path = through(points, headings, np.zeros(len(points)), np.zeros(len(points)))
    except ValueError:
        return None
    speeds[-1] = max(states[-1, 3], 0.0)  # points too near to the last were left out
    return along(path, path.knots_m, speeds)


@kernel
def foot(line: Floats, x: float, y: float, heading: float, near: float, window: float) -> float:
    """The station nearest to a place, of those that are at most `window` from `near` and run the car's way; NaN: none does."""
    best, at, found = np.inf, -1, np.nan
    for i in range(len(line) - 1):
        begin, end = max(line[i, KNOT], near - window), min(line[i + 1, KNOT], near + window)
        for share in (0.0, 0.5, 1.0):
            station = begin + share * (end - begin)
            if begin <= end:
                there = spot(line, station, i)
                away = (x - there.x) ** 2 + (y - there.y) ** 2
                if away < best and np.cos(heading) * there.tangent_x + np.sin(heading) * there.tangent_y > 0.0:
                    best, at, found = away, i, station
    if at < 0:
        return np.nan
    for _ in range(8):
        at = piece_of(line, found, at)
        there = spot(line, found, at)
        error = (x - there.x) * there.tangent_x + (y - there.y) * there.tangent_y
        curve = (x - there.x) * -there.tangent_y + (y - there.y) * there.tangent_x
        found += error / there.stretch / max(1.0 - there.bend * curve, 0.3)
        if abs(error) < 1e-6:
            break
    return found


@kernel
def square_at(stations: Floats, squares: Floats, station: float) -> tuple[float, float]:
    """The speed squared wanted at a station, and the acceleration of a car that keeps to it."""
    last = len(stations) - 1
    if station >= stations[last]:
        return squares[last], 0.0
    i = max(int(np.searchsorted(stations, station, "right")) - 1, 0)
    slope = (squares[i + 1] - squares[i]) / (stations[i + 1] - stations[i])
    return max(squares[i] + slope * max(station - stations[i], 0.0), 0.0), slope / 2.0


@kernel
def wanted_speeds(stations: Floats, squares: Floats, station: float, speed: float, acceleration_max: float, out: Floats) -> None:
    """out (N + 1,): the speed of a car that keeps to the reference, or comes up to it with the greatest acceleration."""
    square, slope = square_at(stations, squares, station)
    now = min(max(speed, 0.0), np.sqrt(square))
    out[0] = now
    for k in range(1, STAGES + 1):
        pull = min(slope, acceleration_max) if now * now >= square - EVEN else acceleration_max
        station += max(now + pull * STAGE_S / 2.0, 0.0) * STAGE_S
        square, slope = square_at(stations, squares, station)
        now = min(now + acceleration_max * STAGE_S, np.sqrt(square))
        out[k] = now
