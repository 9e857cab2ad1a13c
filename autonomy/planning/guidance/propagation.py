"""The graph of the last cycle, one cycle later: what it found is tried first, so that a class found once stays. Pure.

Node times drop by the time that has passed. A connector whose time is over would take its class with it, so another is put
on the way it belonged to, half way through the horizon.
"""

from collections.abc import Sequence

import numpy as np

from autonomy.planning.guidance.graph import CONNECTOR, GUARD, Graph, Ints
from autonomy.planning.horizon import STEPS, Floats

FIRST = 1.0  # stage: a node must lie ahead of the car by a step
HALF = STEPS // 2


def carried(nodes: Floats, stages: float, most: int) -> Floats:
    """Nodes (n, 3) after so many stages, at most so many."""
    later: Floats = nodes - np.array([0.0, 0.0, stages])
    return later[(later[:, 2] >= FIRST) & (later[:, 2] < STEPS)][:most]


def to_carry(graph: Graph, ways: Sequence[Ints], places: Sequence[Floats], stages: float) -> Floats:
    """Nodes (n, 3) for the next cycle, which comes after so many stages: those of the ways, best first, then the others.

    ways: rows of each way's connectors; places (STEPS + 1, 2): each way's trajectory.
    """
    used = [row for way in ways for row in way.tolist()]
    live = [row for row in range(1 + len(graph.costs_m), len(graph.nodes)) if graph.kinds[row] in (CONNECTOR, GUARD)]
    rows = list(dict.fromkeys([*used, *live]))
    kept = graph.nodes[rows, :3]
    expiring = [place for way, place in zip(ways, places, strict=True) if graph.nodes[way[0], 2] - stages < FIRST]
    again = np.array([[*place[HALF], HALF] for place in expiring]).reshape(-1, 3)
    return np.concatenate((again, kept))
