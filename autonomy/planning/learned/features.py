"""What the network is told of a guidance: the way, the car, the line and the people near the way, in the car's own frame. Pure.

A person is told as seen from the way, ahead and aside at ten times: that is what the optimiser will have to make room for.
Not told: sides (the way says them), stages between, and people beyond the twelve nearest to the way.
"""

from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autonomy.planning.guidance.state import Guidance
from autonomy.planning.horizon import STEPS, CarState, Floats, Predictions
from autonomy.planning.kernels import fast_kernel
from autonomy.planning.mpc.line import piece_of, spot, table
from autonomy.planning.reference_path import ReferencePath

Singles = NDArray[np.float32]
PEOPLE = 12  # at most, the nearest to each way
AT = np.array((0, 3, 7, 11, 15, 19, 23, 27, 31, 35))  # stages at which people are told
AHEAD_M = np.arange(9) * 2.0  # from the car's foot, where the line is told: what 7 s at 2 m/s reach
WAY, LINE, CAR, PERSON = 2 * STEPS, 4 * len(AHEAD_M), 3, 2 * len(AT) + 2  # numbers of each
NEAR_M = 5.0  # half of the scale on which a distance to somebody counts
FAR_M, ROOM_M, SPEED_M_S, ANGLE_RAD, DEVIATION_M = 10.0, 3.0, 2.0, 0.5, 0.5  # what is about 1 for the network


class Features(NamedTuple):
    alone: Singles  # (w, WAY + LINE + CAR) of w ways: x, then y, of the way; x, y, room left, room right of the line; the car
    people: Singles  # (w, n, PERSON) ahead, then aside, of the way; radius, deviation at the horizon's end


def features(ways: Sequence[Guidance], car: CarState, path: ReferencePath, predictions: Predictions, speed_m_s: float) -> Features:
    """speed_m_s: asked for. What is no number comes out as none."""
    places = np.array([way.rear_axle_m for way in ways])
    headings = np.array([way.headings_rad for way in ways])
    alone = np.empty((len(ways), WAY + LINE + CAR), np.float32)
    people = np.empty((len(ways), min(predictions.count, PEOPLE), PERSON), np.float32)
    start = np.array((car.x_m, car.y_m, car.heading_rad, car.speed_m_s, car.road_wheel_angle_rad, car.station_m))
    _alone(places, start, table(path), float(speed_m_s), alone)
    positions, radii = np.ascontiguousarray(predictions.positions_m), np.ascontiguousarray(predictions.radii_m)
    _people(places, headings, positions, radii, np.array(predictions.covariances_m2[-1, :, 0, 0]), people)
    return Features(alone, people)


@fast_kernel
def _alone(places: Floats, start: Floats, line: Floats, speed: float, alone: Singles) -> None:
    c, s, piece = cos(start[2]), sin(start[2]), 0
    count = len(AHEAD_M)
    for way in range(len(alone)):
        for k in range(STEPS):
            x, y = places[way, k + 1, 0] - start[0], places[way, k + 1, 1] - start[1]
            alone[way, k], alone[way, STEPS + k] = (x * c + y * s) / FAR_M, (y * c - x * s) / FAR_M
        for i in range(count):
            station = start[5] + AHEAD_M[i]
            piece = piece_of(line, station, piece)
            at = spot(line, station, piece)
            x, y = at.x - start[0], at.y - start[1]
            alone[way, WAY + i], alone[way, WAY + count + i] = (x * c + y * s) / FAR_M, (y * c - x * s) / FAR_M
            alone[way, WAY + 2 * count + i], alone[way, WAY + 3 * count + i] = at.left / ROOM_M, at.right / ROOM_M
        told = WAY + LINE
        alone[way, told], alone[way, told + 1] = start[3] / SPEED_M_S, start[4] / ANGLE_RAD
        alone[way, told + 2] = speed / SPEED_M_S


@fast_kernel
def _people(places: Floats, headings: Floats, positions: Floats, radii: Floats, variances: Floats, people: Singles) -> None:
    """Of each way its nearest, nearest first."""
    times = len(AT)
    for way in range(len(people)):
        squared = np.full(len(radii), np.inf)
        for person in range(len(radii)):
            for k in AT:
                x, y = positions[k, person, 0] - places[way, k, 0], positions[k, person, 1] - places[way, k, 1]
                squared[person] = min(squared[person], x * x + y * y)
        for row in range(people.shape[1]):
            person = int(np.argmin(squared))
            squared[person] = np.inf
            for i in range(times):
                k = AT[i]
                c, s = cos(headings[way, k]), sin(headings[way, k])
                x, y = positions[k, person, 0] - places[way, k, 0], positions[k, person, 1] - places[way, k, 1]
                ahead, aside = x * c + y * s, y * c - x * s
                people[way, row, i] = ahead / (NEAR_M + abs(ahead))
                people[way, row, times + i] = aside / (NEAR_M + abs(aside))
            people[way, row, 2 * times] = radii[person]
            people[way, row, 2 * times + 1] = sqrt(max(variances[person], 0.0)) / DEVIATION_M
