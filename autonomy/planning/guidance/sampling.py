"""Where the graph may put its nodes: the start, a grid of goals along the path, and places drawn by chance. Kernels.

A node is (x_m, y_m, stage, station_m, offset_m). Chance draws a whole stage in 1..N - 2 and then a place among those the
car can have reached by then; one drawn over the whole way would mostly lie where the car cannot be.
"""

import numpy as np

from autonomy.planning.guidance.chance import draw
from autonomy.planning.guidance.driving import farthest_m, shortest_m
from autonomy.planning.guidance.line import HIGH, LOW, Line, at, foot, place
from autonomy.planning.guidance.settings import Drive
from autonomy.planning.horizon import Floats
from autonomy.planning.kernels import kernel


@kernel
def lay_goals(
    line: Line, station_m: float, reach_m: float, drive: Drive, ahead: int, aside: int, goals: Floats, costs: Floats
) -> int:
    """Fills goals by growing cost |s - s_best| + |d| and returns how many there are. No goal stands where the road has no room.

    The nearest column stands where the car can stop (the public default, where it is now, cannot be reached by a moving car)
    and has one goal only; the others have one on the path and `aside` to each side.
    """
    count = 0
    best = station_m + reach_m
    stop = min(station_m + shortest_m(drive, drive.last * drive.step_s), best)
    for column in range(ahead):
        station = stop + (best - stop) * column / (ahead - 1)
        low, high = at(line, station, LOW), at(line, station, HIGH)
        middle = min(max(0.0, low), high)
        for row in range(-aside, aside + 1):
            if low <= high and (row == 0 or column > 0):
                offset = middle + row / max(aside, 1) * (high - middle if row > 0 else middle - low)
                _insert(goals, costs, count, station, offset, abs(best - station) + abs(offset))
                count += 1
    for goal in range(count):
        goals[goal, 0], goals[goal, 1] = place(line, goals[goal, 3], goals[goal, 4])
        goals[goal, 2] = drive.last
    return count


@kernel
def _insert(goals: Floats, costs: Floats, count: int, station_m: float, offset_m: float, cost_m: float) -> None:
    """Behind all that cost no more."""
    where = count
    while where > 0 and costs[where - 1] > cost_m:
        costs[where], goals[where, 3], goals[where, 4] = costs[where - 1], goals[where - 1, 3], goals[where - 1, 4]
        where -= 1
    costs[where], goals[where, 3], goals[where, 4] = cost_m, station_m, offset_m


@kernel
def on_line(line: Line, nodes: Floats) -> None:
    """Fills station and offset of nodes that have only their place."""
    for node in nodes:
        node[3], node[4], _ = foot(line, node[0], node[1], -1)


@kernel
def straight_on(line: Line, start: Floats, goals: Floats, drive: Drive, nodes: Floats) -> int:
    """Fills nodes half way to every goal on the path itself: what a car among nobody does. Returns how many."""
    count = 0
    for goal in goals:
        if abs(goal[4]) < 1e-9 and count < len(nodes):
            nodes[count, 2] = float(int(drive.last) // 2)
            share = nodes[count, 2] / drive.last
            nodes[count, 3], nodes[count, 4] = start[3] + share * (goal[3] - start[3]), (1.0 - share) * start[4]
            nodes[count, 0], nodes[count, 1] = place(line, nodes[count, 3], nodes[count, 4])
            count += 1
    return count


@kernel
def scatter(chance: np.uint64, line: Line, station_m: float, reach_m: float, drive: Drive, nodes: Floats) -> np.uint64:
    """Fills all nodes by chance, and returns its next state. NaN where the road has no room: never used."""
    for node in nodes:
        chance, by_stage = draw(chance)
        chance, by_station = draw(chance)
        chance, by_offset = draw(chance)
        node[2] = 1.0 + float(int(by_stage * (drive.last - 2.0)))
        after = node[2] * drive.step_s
        near = min(shortest_m(drive, after), reach_m)
        node[3] = station_m + near + by_station * (min(farthest_m(drive, after), reach_m) - near)
        low, high = at(line, node[3], LOW), at(line, node[3], HIGH)
        node[4] = low + by_offset * (high - low) if low <= high else np.nan
        node[0], node[1] = place(line, node[3], node[4])
    return chance
