"""The ways through the graph from the start to a goal: depth first, the best of each class, the best few of those. Kernels."""

from typing import NamedTuple

import numpy as np

from autonomy.planning.guidance.clearance import Crowd
from autonomy.planning.guidance.graph import CONNECTOR, GOAL, Graph, Ints, same
from autonomy.planning.guidance.winding import side
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel

DEPTH = 6  # connectors in one way, at most
CLASSES = 64  # kept while searching
VISITS = 4000  # then it ends with what it has: graphs of this size have less than a hundred ways


class Ways(NamedTuple):
    """The best way of each class; only the first rows that `search` returned are filled."""

    connectors: Ints  # (CLASSES, DEPTH)
    lengths: Ints  # (CLASSES,) how many of them
    sides: Ints  # (CLASSES, n) codes
    costs: Floats  # (CLASSES, 2) m of the goal, then m2/s of the edges: compared in this order


def no_ways(people: int) -> Ways:
    return Ways(
        np.empty((CLASSES, DEPTH), np.int64),
        np.empty(CLASSES, np.int64),
        np.empty((CLASSES, people), np.int64),
        np.empty((CLASSES, 2)),
    )


@kernel
def search(graph: Graph, crowd: Crowd, ways: Ways) -> int:
    """How many classes there are."""
    stack, nexts = np.empty(DEPTH, np.int64), np.zeros(DEPTH, np.int64)
    windings, efforts = np.zeros((DEPTH + 1, len(crowd.tracks))), np.zeros(DEPTH + 1)
    found, depth, end = 0, 0, 0
    nexts[0] = 1 + len(graph.costs_m)
    for _ in range(VISITS):
        connector = nexts[depth]
        if connector == len(graph.nodes):
            if depth == 0:
                break
            depth -= 1
            end = graph.links[stack[depth], 0]
            continue
        nexts[depth] += 1
        if graph.kinds[connector] != CONNECTOR or graph.links[connector, 0] != end:
            continue
        stack[depth] = connector
        efforts[depth + 1] = efforts[depth] + graph.efforts[connector]
        windings[depth + 1] = windings[depth] + graph.windings[connector, 0] + graph.windings[connector, 1]
        after = graph.links[connector, 1]
        if graph.kinds[after] == GOAL:
            found = _keep(graph, crowd, ways, found, stack, depth + 1, windings[depth + 1], efforts[depth + 1])
        elif depth + 1 < DEPTH:
            depth, end = depth + 1, after
            nexts[depth] = 1 + len(graph.costs_m)
    return found


@kernel
def _keep(graph: Graph, crowd: Crowd, ways: Ways, found: int, stack: Ints, length: int, windings: Floats, effort: float) -> int:
    """Puts a way where its class is, if it is better than the one there, or behind the others; returns how many there are then.

    Once there are CLASSES of them nothing is put anywhere any more: no row is left to note another way's sides in.
    """
    if found == CLASSES:
        return found
    goal = graph.links[stack[length - 1], 1]
    sides = ways.sides[found]
    for person in range(len(sides)):
        sides[person] = side(graph.nodes[0], graph.nodes[goal], windings[person], crowd, person)
    row = 0
    while row < found and not same(ways.sides[row], sides):
        row += 1
    cost = graph.costs_m[goal - 1]
    if row == found or cost < ways.costs[row, 0] or (cost == ways.costs[row, 0] and effort < ways.costs[row, 1]):
        ways.costs[row, 0], ways.costs[row, 1], ways.lengths[row] = cost, effort, length
        ways.connectors[row, :length] = stack[:length]
    return max(found, row + 1)


@kernel
def cheapest(ways: Ways, found: int, most: int) -> Ints:
    """Rows of the best classes, best first; of equals the one found first."""
    rows = np.empty(min(found, most), np.int64)
    for place in range(len(rows)):
        best = -1
        for row in range(found):
            taken = False
            for other in rows[:place]:
                taken |= other == row
            if not taken and (best < 0 or _less(ways.costs[row], ways.costs[best])):
                best = row
        rows[place] = best
    return rows


@kernel
def _less(one: Floats, other: Floats) -> bool:
    return bool(one[0] < other[0] or (one[0] == other[0] and one[1] < other[1]))


@kernel
def polyline(graph: Graph, ways: Ways, row: int, corners: Floats) -> int:
    """Fills the corners (2 DEPTH + 1, 5), nodes from the start to the goal, and returns how many there are."""
    corners[0] = graph.nodes[0]
    for i in range(ways.lengths[row]):
        connector = ways.connectors[row, i]
        corners[2 * i + 1] = graph.nodes[connector]
        corners[2 * i + 2] = graph.nodes[graph.links[connector, 1]]
    return int(2 * ways.lengths[row] + 1)
