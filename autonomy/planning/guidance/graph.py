"""The visibility graph in x, y and time: guards, connectors, and of connectors that pass everybody alike only the best. Kernels.

Source: the visibility PRM of T-MPC (the paper, III-D, and its reference 17). A candidate that sees (keeps clear on a straight
line from) no guard and no goal becomes a guard; one that sees two guards and no goal connects them; one that sees one guard and a
goal connects the guard to the cheapest goal. Start is the first guard. Everything else is dropped.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from autonomy.planning.guidance.clearance import Crowd, clear, free
from autonomy.planning.guidance.driving import effort, joins
from autonomy.planning.guidance.settings import Drive
from autonomy.planning.guidance.winding import side, turned
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel

Ints = NDArray[np.int64]
GUARD, GOAL, CONNECTOR, REPLACED = range(4)
NONE = -1


class Graph(NamedTuple):
    """Node 0 is the start, then come the goals, then the rest as it was found."""

    nodes: Floats  # (most, 5) x_m, y_m, stage, station_m, offset_m
    kinds: Ints  # (most,)
    links: Ints  # (most, 2) of a connector: the node before and the node after
    windings: Floats  # (most, 2, n) of a connector: winding angles of its two edges round everybody
    efforts: Floats  # (most,) of a connector: m2/s, both edges
    sides: Ints  # (most, n) of a connector: code from the node before to the node after
    costs_m: Floats  # (goals,) growing


def empty_graph(start: Floats, goals: Floats, costs_m: Floats, candidates: int, people: int) -> Graph:
    most = 1 + len(goals) + candidates
    graph = Graph(
        nodes=np.empty((most, 5)),
        kinds=np.full(most, GUARD),
        links=np.full((most, 2), NONE),
        windings=np.empty((most, 2, people)),
        efforts=np.empty(most),
        sides=np.empty((most, people), np.int64),
        costs_m=costs_m,
    )
    graph.nodes[0] = start
    graph.nodes[1 : len(goals) + 1] = goals
    graph.kinds[1 : len(goals) + 1] = GOAL
    return graph


def trimmed(graph: Graph, count: int) -> Graph:
    """Without the rows that `grow` left empty."""
    return Graph._make((*(column[:count] for column in graph[:-1]), graph.costs_m))


@kernel
def grow(graph: Graph, candidates: Floats, crowd: Crowd, drive: Drive) -> int:
    """Takes the candidates in their order; returns how many nodes the graph has now."""
    count = 1 + len(graph.costs_m)
    seen = np.empty(3, np.int64)
    for candidate in candidates:
        if not free(candidate, crowd):  # also what is not a number
            continue
        graph.nodes[count] = candidate
        guards = _guards_seen(graph, count, crowd, seen)
        if guards == 0 and not _sees_a_goal(graph, count, crowd):
            graph.kinds[count] = GUARD
            count += 1
        elif guards == 1:
            goal = _cheapest_goal(graph, seen[0], count, crowd, drive)
            count += _connect(graph, seen[0], count, goal, crowd, drive)
        elif guards == 2 and not _sees_a_goal(graph, count, crowd):
            first, last = (seen[0], seen[1]) if graph.nodes[seen[0], 2] < graph.nodes[seen[1], 2] else (seen[1], seen[0])
            if joins(graph.nodes[first], graph.nodes[count], graph.nodes[last], drive):
                count += _connect(graph, first, count, last, crowd, drive)
    return count


@kernel
def _guards_seen(graph: Graph, candidate: int, crowd: Crowd, seen: Ints) -> int:
    """How many, at most three; which, into `seen`."""
    guards = 0
    for node in range(candidate):
        if graph.kinds[node] == GUARD and clear(graph.nodes[node], graph.nodes[candidate], crowd, crowd.clearances):
            seen[guards] = node
            guards += 1
            if guards == 3:
                break
    return guards


@kernel
def _sees_a_goal(graph: Graph, candidate: int, crowd: Crowd) -> bool:
    for goal in range(1, 1 + len(graph.costs_m)):
        if clear(graph.nodes[candidate], graph.nodes[goal], crowd, crowd.clearances):
            return True
    return False


@kernel
def _cheapest_goal(graph: Graph, guard: int, candidate: int, crowd: Crowd, drive: Drive) -> int:
    for goal in range(1, 1 + len(graph.costs_m)):
        drives = joins(graph.nodes[guard], graph.nodes[candidate], graph.nodes[goal], drive)
        if drives and clear(graph.nodes[candidate], graph.nodes[goal], crowd, crowd.clearances):
            return goal
    return NONE


@kernel
def _connect(graph: Graph, first: int, candidate: int, last: int, crowd: Crowd, drive: Drive) -> int:
    """Makes the candidate a connector, in place of an equivalent worse one, and returns 1; 0 when there is a better one."""
    if last == NONE:
        return 0
    nodes = graph.nodes
    graph.links[candidate, 0], graph.links[candidate, 1] = first, last
    graph.efforts[candidate] = effort(nodes[first], nodes[candidate], drive) + effort(nodes[candidate], nodes[last], drive)
    for person in range(len(crowd.tracks)):
        before = turned(nodes[first], nodes[candidate], crowd.tracks[person])
        after = turned(nodes[candidate], nodes[last], crowd.tracks[person])
        graph.windings[candidate, 0, person], graph.windings[candidate, 1, person] = before, after
        graph.sides[candidate, person] = side(nodes[first], nodes[last], before + after, crowd, person)
    for other in range(1 + len(graph.costs_m), candidate):
        if graph.kinds[other] == CONNECTOR and _equivalent(graph, other, candidate):
            if not _better(graph, candidate, other):
                return 0
            graph.kinds[other] = REPLACED
    graph.kinds[candidate] = CONNECTOR
    return 1


@kernel
def _equivalent(graph: Graph, one: int, other: int) -> bool:
    """Same guard before, same guard or any goal after, and everybody passed alike."""
    if graph.links[one, 0] != graph.links[other, 0]:
        return False
    after, beyond = graph.links[one, 1], graph.links[other, 1]
    if after != beyond and not (graph.kinds[after] == GOAL and graph.kinds[beyond] == GOAL):
        return False
    return same(graph.sides[one], graph.sides[other])


@kernel
def same(one: Ints, other: Ints) -> bool:
    unlike = 0
    for person in range(len(one)):
        unlike += one[person] != other[person]
    return unlike == 0


@kernel
def _better(graph: Graph, one: int, other: int) -> bool:
    """A cheaper goal; with goals that cost the same, or a guard after, less effort."""
    after, beyond = graph.links[one, 1], graph.links[other, 1]
    if graph.kinds[after] == GOAL and graph.costs_m[after - 1] != graph.costs_m[beyond - 1]:
        return bool(graph.costs_m[after - 1] < graph.costs_m[beyond - 1])
    return bool(graph.efforts[one] < graph.efforts[other])
