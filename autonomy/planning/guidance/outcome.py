"""From the kernels' arrays to what is handed out. Pure."""

from collections.abc import Sequence

import numpy as np

from autonomy.planning.guidance.drawing import Drawn
from autonomy.planning.guidance.graph import CONNECTOR, Graph, Ints
from autonomy.planning.guidance.splines import FINE
from autonomy.planning.guidance.state import Code, GraphView, Guidance
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import STEP_S

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


def view_of(graph: Graph, connectors: Sequence[Ints]) -> GraphView:
    """connectors: those of each way, in the order of the ways."""
    live = np.flatnonzero(graph.kinds == CONNECTOR)
    edges = np.concatenate((np.stack((graph.links[live, 0], live), 1), np.stack((live, graph.links[live, 1]), 1)))
    ways = tuple((0, *(int(node) for row in way for node in (row, graph.links[row, 1]))) for way in connectors)
    return GraphView(nodes=graph.nodes[:, :3] * np.array([1.0, 1.0, STEP_S]), kinds=graph.kinds, edges=edges, ways=ways)
