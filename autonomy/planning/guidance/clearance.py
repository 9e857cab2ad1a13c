"""Whether a straight stretch in x, y and time keeps clear of everybody, each where they are AT THE SAME TIME. Kernels.

Car and person both move straight from one stage to the next, so their relative motion is a straight line and the least
distance on it exact. Never compares metres with stages.
"""

from math import floor, sqrt
from typing import NamedTuple

from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel

SAME_STAGE = 1e-9


class Crowd(NamedTuple):
    """n people and things that matter, along the stages; between two stages they move straight."""

    tracks: Floats  # (n, STEPS + 1, 2) m
    headings: Floats  # (n, STEPS + 1) of the path where they are; continuous, so it may pass pi
    clearances: Floats  # (n,) m from the car's middle, kept by the graph
    contacts: Floats  # (n,) m, kept by what comes out: the same without the margin
    paces: Floats  # (n,) m, farthest that they move from one stage to the next


@kernel
def clear(one: Floats, other: Floats, crowd: Crowd, distances: Floats) -> bool:
    """Between two nodes (x_m, y_m, stage, ...) in either order; False when they share their stage, and for NaN."""
    first, last = (one, other) if one[2] < other[2] else (other, one)
    if not last[2] - first[2] > SAME_STAGE:
        return False
    for person in range(len(distances)):
        if not _clear_of(first, last, crowd.tracks[person], distances[person], crowd.paces[person]):
            return False
    return True


@kernel
def _clear_of(first: Floats, last: Floats, track: Floats, distance_m: float, pace_m: float) -> bool:
    """Goes from stage to stage, past those in which both together are too slow to meet."""
    stages = last[2] - first[2]
    vx, vy = (last[0] - first[0]) / stages, (last[1] - first[1]) / stages
    closing = sqrt(vx * vx + vy * vy) + pace_m
    stage = first[2]
    while stage < last[2] - SAME_STAGE:
        k = min(int(floor(stage + SAME_STAGE)), len(track) - 2)
        end = min(float(k + 1), last[2])
        rx, ry = apart(first, vx, vy, track, k, stage)
        qx, qy = apart(first, vx, vy, track, k, end)
        if not nearest_square(rx, ry, qx, qy) >= distance_m * distance_m:
            return False
        spare = sqrt(qx * qx + qy * qy) - distance_m
        stage = end + (max(floor(spare / closing), 0.0) if closing > 0.0 else stages)
    return True


@kernel
def apart(first: Floats, vx: float, vy: float, track: Floats, k: int, stage: float) -> tuple[float, float]:
    """From the person to the car, at a stage between k and k + 1."""
    share, since = stage - k, stage - first[2]
    return (
        first[0] + since * vx - track[k, 0] - share * (track[k + 1, 0] - track[k, 0]),
        first[1] + since * vy - track[k, 1] - share * (track[k + 1, 1] - track[k, 1]),
    )


@kernel
def nearest_square(rx: float, ry: float, qx: float, qy: float) -> float:
    """Square of the least distance from the origin to the line from r to q."""
    dx, dy = qx - rx, qy - ry
    long = dx * dx + dy * dy
    share = min(max(-(rx * dx + ry * dy) / long, 0.0), 1.0) if long > 0.0 else 0.0
    x, y = rx + share * dx, ry + share * dy
    return x * x + y * y


@kernel
def free(node: Floats, crowd: Crowd) -> bool:
    """Whether a node keeps clear at its own stage."""
    for person in range(len(crowd.clearances)):
        track, distance = crowd.tracks[person], crowd.clearances[person]
        k = min(int(floor(node[2])), track.shape[0] - 2)
        x, y = apart(node, 0.0, 0.0, track, k, node[2])
        if not x * x + y * y >= distance * distance:
            return False
    return True
