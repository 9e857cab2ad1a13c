"""From the kernels' arrays to what is handed out. Pure."""

from dataclasses import dataclass

import numpy as np

from autonomy.planning.guidance.drawing import Drawn
from autonomy.planning.guidance.graph import CONNECTOR, Ints
from autonomy.planning.guidance.splines import FINE
from autonomy.planning.guidance.state import Code, Guidance, Searched
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import STEP_S, Floats

SIDES = {int(side): side for side in Side}


def code_of(numbers: tuple[int, ...], sides: Ints) -> Code:
    return tuple(sorted((number, SIDES[side]) for number, side in zip(numbers, sides.tolist(), strict=True)))


def guidance_of(identity: int, code: Code, drawn: Drawn, row: int, cost_m: float) -> Guidance:
    velocities = drawn.velocities[row]
    return Guidance(
        identity=identity,
        code=code,
        middle_m=drawn.places[row, ::FINE],
        speeds_m_s=np.hypot(velocities[:, 0], velocities[:, 1]),
        rear_axle_m=drawn.rear[row, :, :2],
        headings_rad=drawn.rear[row, :, 2],
        points_m=drawn.points[row, : drawn.counts[row]],
        cost_m=cost_m,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class GraphView:
    nodes: Floats  # (n, 3) x_m, y_m, s from now
    kinds: Ints  # (n,) graph.GUARD, GOAL, CONNECTOR, REPLACED
    edges: Ints  # (m, 2) rows of nodes
    ways: tuple[tuple[int, ...], ...]  # rows of the nodes of each way, from the start to its goal


def view_of(searched: Searched) -> GraphView:
    """For a plot: not made in the loop."""
    graph = searched.graph
    live = np.flatnonzero(graph.kinds == CONNECTOR)
    edges = np.concatenate((np.stack((graph.links[live, 0], live), 1), np.stack((live, graph.links[live, 1]), 1)))
    ways = tuple((0, *(int(node) for row in way for node in (row, graph.links[row, 1]))) for way in searched.connectors)
    return GraphView(nodes=graph.nodes[:, :3] * np.array([1.0, 1.0, STEP_S]), kinds=graph.kinds, edges=edges, ways=ways)
