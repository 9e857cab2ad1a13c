"""Who moves along the street is predicted along it: cyclists, walkers, cars. Who crosses it or stands is left as told. Pure.

Told: everybody at constant velocity. Of whoever moves along the path both parts of that velocity are kept, along the path and
across it, in the path's directions instead of the map's, and the covariance turns with them. On a straight street that is the
same; in a bend nobody who follows it is sent across the lane. The braking planner reckons so already (`perception/prediction.py`).
It foresees no turn out of the street, and who gives way to whom is nothing it knows.
"""

from dataclasses import replace
from math import cos, hypot, inf, radians

import numpy as np

from autonomy.planning.horizon import STEP_S, Floats, Predictions
from autonomy.planning.kernels import kernel
from autonomy.planning.mpc.line import CUBIC_X, CUBIC_Y, Spot, piece_of, spot, table
from autonomy.planning.mpc.problem import path_refused, people_refused
from autonomy.planning.mpc.warm_up import small_problem
from autonomy.planning.reference_path import ReferencePath

LEAST_M_S = 0.5  # `TrackingSettings.moving_m_s`: who is slower may stand, and the direction is noise
# Of the path's direction: three deviations of a walker's, as tracked (0.27 m/s each way at 1.4 m/s). Who crosses is five from it
# (0.2 rad from straight across, `crossings/scenario.py`).
ALONG_COS = cos(radians(30.0))
BESIDE_M = 6.0  # beyond the room: the oncoming lane (3.5 m) and a sidewalk (2.5 m)
FOOT_STEPS, FOOT_M = 8, 0.01  # Newton's steps to somebody's foot on the path, and how near the last has to come
SPACING_LEAST = 0.2  # metres per metre of station: near the middle of a bend's circle a station is no place


def along_street(predictions: Predictions, path: ReferencePath) -> Predictions:
    """predictions  at constant velocity. What is no prediction, or no path, comes back as it is: the planners refuse it."""
    if predictions.count == 0 or path_refused(path) or people_refused(predictions):
        return predictions
    positions = np.array(predictions.positions_m, np.float64, order="C")
    covariances = np.array(predictions.covariances_m2, np.float64, order="C")
    _lead(table(path), positions, covariances)
    return replace(predictions, positions_m=positions, covariances_m2=covariances)


def warm_up() -> None:
    """Compiles the kernels, or reads them from disk: they take their types from the arrays."""
    problem = small_problem()
    assert problem.predictions is not None  # for the type checker
    along_street(problem.predictions, problem.path)


@kernel
def _lead(line: Floats, positions: Floats, covariances: Floats) -> None:
    for person in range(positions.shape[1]):
        x, y = positions[0, person]
        vx, vy = (positions[1, person] - positions[0, person]) / STEP_S
        speed = hypot(vx, vy)
        if speed < LEAST_M_S:
            continue
        station, offset, piece = _foot(line, x, y)
        here = spot(line, station, piece)
        along, aside = vx * here.tangent_x + vy * here.tangent_y, vy * here.tangent_x - vx * here.tangent_y
        if abs(along) >= ALONG_COS * speed and -here.right - BESIDE_M < offset < here.left + BESIDE_M:
            _go(line, station, offset, piece, along, aside, positions[:, person], covariances[:, person])


@kernel
def _foot(line: Floats, x: float, y: float) -> tuple[float, float, int]:
    """Station, offset and piece, from the nearest knot; an infinite offset where none is found."""
    pieces = len(line) - 1
    piece, least = 0, inf
    for i in range(pieces):
        away = hypot(line[i, CUBIC_X + 3] - x, line[i, CUBIC_Y + 3] - y)
        if away < least:
            piece, least = i, away
    station, offset, ahead = line[piece, 0], inf, inf
    for _ in range(FOOT_STEPS):
        piece = piece_of(line, station, piece)
        at = spot(line, station, piece)
        dx, dy = x - at.x, y - at.y
        offset, ahead = dy * at.tangent_x - dx * at.tangent_y, dx * at.tangent_x + dy * at.tangent_y
        station += ahead / _spacing(at, offset)
    return station, offset if abs(ahead) < FOOT_M else inf, piece_of(line, station, piece)


@kernel
def _go(
    line: Floats, station: float, offset: float, piece: int, along: float, aside: float, places: Floats, covariances: Floats
) -> None:
    """Fills one person's places (K, 2) from the second on and turns their covariances (K, 2, 2)."""
    first = spot(line, station, piece)
    at = first
    for k in range(1, len(places)):
        step = along * STEP_S / _spacing(at, offset)
        offset += aside * STEP_S
        piece = piece_of(line, station + step, piece)
        there = spot(line, station + step, piece)
        station += 0.5 * (step + along * STEP_S / _spacing(there, offset))  # Heun
        piece = piece_of(line, station, piece)
        at = spot(line, station, piece)
        places[k, 0], places[k, 1] = at.x - offset * at.tangent_y, at.y + offset * at.tangent_x
        _turn(
            covariances[k],
            first.tangent_x * at.tangent_x + first.tangent_y * at.tangent_y,
            first.tangent_x * at.tangent_y - first.tangent_y * at.tangent_x,
        )


@kernel
def _spacing(at: Spot, offset: float) -> float:
    """Metres of the line at this offset per metre of station."""
    return max(at.stretch - at.bend * offset, SPACING_LEAST)


@kernel
def _turn(covariance: Floats, c: float, s: float) -> None:
    """By the angle of this cosine and sine."""
    xx, xy, yy = covariance[0, 0], covariance[0, 1], covariance[1, 1]
    covariance[0, 0] = c * c * xx - 2.0 * c * s * xy + s * s * yy
    covariance[1, 1] = s * s * xx + 2.0 * c * s * xy + c * c * yy
    covariance[0, 1] = covariance[1, 0] = c * s * (xx - yy) + (c * c - s * s) * xy
