"""On which side a trajectory passes each person, or that it does not: the winding code. Kernels.

The car's bearing seen from a person turns by the winding angle w as both move; every increment counts, also the first and
the last. Counted from the direction of the path where the person is, a bearing is ahead of them (-pi/2..pi/2) or behind
(pi/2..3 pi/2). A car that comes from behind and ends ahead has passed: on their left when it turned clockwise, on their
right when counter-clockwise; one that stays behind has not, however far it turned. The paper (III-D) takes |w| for the
progress of passing. A limit for |w| alone cannot tell the two apart: before a person who walks across 3 m ahead a waiting car turns
by 118 degrees, and one that overtakes from 3 m behind to 3 m ahead, 3 m aside, by 90. So the limit is the line across the
path through the person.
"""

from enum import IntEnum
from math import atan2, floor, pi

import numpy as np

from autonomy.planning.guidance.clearance import SAME_STAGE, Crowd, apart
from autonomy.planning.guidance.line import wrapped
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel


class Side(IntEnum):
    """Where the car is as it passes somebody. (One who overtakes the car on its left turns it clockwise too: LEFT.)"""

    RIGHT = -1
    NON_PASSING = 0
    LEFT = 1


@kernel
def turned(first: Floats, last: Floats, track: Floats) -> float:
    """Winding angle of the straight stretch between two nodes (x_m, y_m, stage, ...) round a person, counter-clockwise positive.

    The sum of all increments, each less than pi because the relative motion is straight: the difference of the two bearings,
    and a full turn for every crossing of the ray behind the origin where bearings jump.
    """
    stages = last[2] - first[2]
    vx, vy = (last[0] - first[0]) / stages, (last[1] - first[1]) / stages
    stage, turns = first[2], 0
    k = min(int(floor(stage + SAME_STAGE)), len(track) - 2)
    rx, ry = apart(first, vx, vy, track, k, stage)
    bearing = atan2(ry + 0.0, rx)  # never -0.0, whose bearing is -pi
    while stage < last[2] - SAME_STAGE:
        end = min(float(k + 1), last[2])
        qx, qy = apart(first, vx, vy, track, k, end)
        if (ry < 0.0) != (qy < 0.0) and (rx * qy - qx * ry) * (qy - ry) < 0.0:
            turns += 1 if qy < 0.0 else -1
        rx, ry, stage, k = qx, qy, end, min(k + 1, len(track) - 2)
    return atan2(ry + 0.0, rx) - bearing + 2 * pi * turns


@kernel
def phase(node: Floats, crowd: Crowd, person: int) -> float:
    """Bearing of a node from a person, from the path's direction there, in -pi/2..3 pi/2: ahead below pi/2, else behind."""
    track = crowd.tracks[person]
    k = min(int(floor(node[2] + SAME_STAGE)), len(track) - 2)
    x, y = apart(node, 0.0, 0.0, track, k, node[2])
    angle = wrapped(atan2(y + 0.0, x) - _heading(crowd, person, node[2]))
    return angle + 2 * pi if angle < -pi / 2 else angle


@kernel
def phases(node: Floats, crowd: Crowd) -> Floats:
    """Those of everybody."""
    return np.array([phase(node, crowd, person) for person in range(len(crowd.tracks))])


@kernel
def half_turns(angle_rad: float) -> int:
    """0 ahead, 1 behind, and so on around."""
    return int(floor((angle_rad + pi / 2) / pi))


@kernel
def side(first: Floats, last: Floats, winding_rad: float, crowd: Crowd, person: int) -> int:
    """The code (a Side) of a way from one node to another that turned by so much round a person."""
    start = phase(first, crowd, person)
    bend = _heading(crowd, person, last[2]) - _heading(crowd, person, first[2])
    passed = half_turns(start) - half_turns(start + winding_rad - bend)
    return min(max(passed, -1), 1)


@kernel
def _heading(crowd: Crowd, person: int, stage: float) -> float:
    headings = crowd.headings[person]
    k = min(int(floor(stage + SAME_STAGE)), len(headings) - 2)
    return float(headings[k] + (stage - k) * (headings[k + 1] - headings[k]))
