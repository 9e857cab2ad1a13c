"""The chosen ways as trajectories: the car's middle on its spline, and the rear axle pulled along behind it. Kernels."""

from math import atan2, cos, hypot, sin
from typing import NamedTuple

import numpy as np

from autonomy.planning.guidance.clearance import Crowd
from autonomy.planning.guidance.graph import Graph, Ints
from autonomy.planning.guidance.line import wrapped
from autonomy.planning.guidance.search import DEPTH, Ways, polyline
from autonomy.planning.guidance.splines import FINE, MOST_POINTS, Tier, rounded
from autonomy.planning.horizon import STEPS, Floats
from autonomy.planning.kernels import kernel


class Drawn(NamedTuple):
    """One row for each way."""

    places: Floats  # (n, FINE STEPS + 1, 2) of the car's middle
    velocities: Floats  # (n, STEPS + 1, 2)
    points: Floats  # (n, MOST_POINTS, 2)
    counts: Ints  # (n,) control points; 0: no spline holds
    rear: Floats  # (n, STEPS + 1, 3) x_m, y_m, heading_rad of the rear axle


def blank(count: int) -> Drawn:
    return Drawn(
        np.empty((count, FINE * STEPS + 1, 2)),
        np.empty((count, STEPS + 1, 2)),
        np.empty((count, MOST_POINTS, 2)),
        np.zeros(count, np.int64),
        np.empty((count, STEPS + 1, 3)),
    )


@kernel
def draw_ways(
    graph: Graph, ways: Ways, rows: Ints, tiers: tuple[Tier, ...], crowd: Crowd, heading_rad: float, ahead_m: float, drawn: Drawn
) -> None:
    corners = np.empty((2 * DEPTH + 1, 5))
    for i in range(len(rows)):
        count = polyline(graph, ways, rows[i], corners)
        sides, places = ways.sides[rows[i]], drawn.places[i]
        drawn.counts[i] = rounded(corners[:count], sides, tiers, crowd, places, drawn.velocities[i], drawn.points[i])
        if drawn.counts[i] > 0:
            _pull(places, heading_rad, ahead_m, drawn.rear[i])


@kernel
def _pull(places: Floats, heading_rad: float, ahead_m: float, rear: Floats) -> None:
    """A rear axle on a drawbar: it moves only along the car (the tractrix, which is what a bicycle model does)."""
    heading = heading_rad
    x, y = places[0, 0] - ahead_m * cos(heading), places[0, 1] - ahead_m * sin(heading)
    for i in range(len(places)):
        dx, dy = places[i, 0] - x, places[i, 1] - y
        bar = hypot(dx, dy)
        if bar > 0.0:
            x, y = places[i, 0] - ahead_m * dx / bar, places[i, 1] - ahead_m * dy / bar
            heading += wrapped(atan2(dy, dx) - heading)
        if i % FINE == 0:
            rear[i // FINE, 0], rear[i // FINE, 1], rear[i // FINE, 2] = x, y, heading
