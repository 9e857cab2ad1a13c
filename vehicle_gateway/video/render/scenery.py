"""What stands along the road that neither map nor scenario names: trees, hedges, street lamps, and where the sun stands.

Deterministic for the scenario's seed. All of it stands behind the kerb; none of it exists for the simulated world's physics.
"""

from dataclasses import dataclass
from math import cos, radians, sin

import numpy as np

from wire.road import Road
from wire.scenario import Scenario

BEFORE_M, AFTER_M = 40.0, 100.0  # the scenery goes on before the road's start and beyond its end
SUN_ELEVATION_RAD = radians(47.0)
SUN_AZIMUTH_RAD = radians(-62.0)  # map frame: behind the right shoulder of a car that starts towards +x
TREE_SPACING_M, FAR_TREE_SPACING_M = 10.5, 18.0
LAMP_SPACING_M = 27.0
LAMP_HEIGHT_M = 6.0
HEDGE_HEIGHT_M, HEDGE_DEPTH_M = 1.25, 0.8
HEDGE_LONGEST_M, HEDGE_IN_BEND_M, HEDGE_SHORTEST_M = 30.0, 8.0, 2.0  # of one piece
HEDGE_BEHIND_WALK_M, HEDGE_GAP_M = 0.7, 0.8  # from the sidewalk, from a house
KINDS_OF_TREE = 4


def sun_direction() -> tuple[float, float, float]:
    """Unit vector towards the sun, map frame."""
    flat = cos(SUN_ELEVATION_RAD)
    return flat * cos(SUN_AZIMUTH_RAD), flat * sin(SUN_AZIMUTH_RAD), sin(SUN_ELEVATION_RAD)


@dataclass(frozen=True, slots=True)
class Tree:
    x_m: float
    y_m: float
    height_m: float
    kind: int


@dataclass(frozen=True, slots=True)
class Lamp:
    x_m: float
    y_m: float
    towards_road_rad: float  # direction of its arm, map frame


@dataclass(frozen=True, slots=True)
class Hedge:
    """A box along the road between two stations; offset_m is that of its side towards the road."""

    first_m: float
    last_m: float
    offset_m: float
    starts_run: bool  # no other hedge before it
    ends_run: bool


@dataclass(frozen=True, slots=True)
class Scenery:
    trees: tuple[Tree, ...]
    lamps: tuple[Lamp, ...]
    hedges: tuple[Hedge, ...]


def plant(scenario: Scenario, road: Road) -> Scenery:
    """The same scenario gives the same scenery."""
    random = np.random.default_rng(scenario.seed)
    trees, hedges = [], []
    for side in (-1.0, 1.0):
        gaps = _gaps(scenario, road, side)
        hedges += _hedges(road, side, gaps)
        trees += _street_trees(road, side, gaps, random)
        trees += _far_trees(scenario, road, side, random)
    return Scenery(tuple(trees), tuple(_lamps(road)), tuple(hedges))


def _gaps(scenario: Scenario, road: Road, side: float) -> list[tuple[float, float]]:
    """Stretches (first, last station) of one side with no building near the sidewalk."""
    taken = sorted(
        (house.station_m - house.length_m / 2, house.station_m + house.length_m / 2)
        for house in scenario.buildings
        if house.offset_m * side > 0
    )
    gaps, at = [], -BEFORE_M
    for first, last in taken:
        if first > at:
            gaps.append((at, first))
        at = max(at, last)
    gaps.append((at, road.length_m + AFTER_M))
    return gaps


def _verge_m(road: Road) -> float:
    return road.half_width_m + road.map.sidewalk_width_m


def _hedges(road: Road, side: float, gaps: list[tuple[float, float]]) -> list[Hedge]:
    """Long pieces along straight road, short ones in a bend."""
    pieces = []
    offset = side * (_verge_m(road) + HEDGE_BEHIND_WALK_M)
    for first, last in gaps:
        cuts = _cuts(road, first + HEDGE_GAP_M, last - HEDGE_GAP_M)
        runs = list(zip(cuts[:-1], cuts[1:], strict=True))
        pieces += [Hedge(start, end, offset, i == 0, i == len(runs) - 1) for i, (start, end) in enumerate(runs)]
    return pieces


def _cuts(road: Road, first_m: float, last_m: float) -> list[float]:
    """Stations at which a hedge from first to last is cut; none when it would be shorter than HEDGE_SHORTEST_M."""
    if last_m - first_m < HEDGE_SHORTEST_M:
        return []
    cuts = [first_m]
    while cuts[-1] < last_m - HEDGE_SHORTEST_M:
        longest = HEDGE_LONGEST_M
        if any(road.curvature_1_m(cuts[-1] + longest * share) != 0.0 for share in (0.0, 0.25, 0.5, 0.75, 1.0)):
            longest = HEDGE_IN_BEND_M
        cuts.append(min(cuts[-1] + longest, last_m))
    cuts[-1] = last_m
    return cuts


def _tree(road: Road, station_m: float, offset_m: float, height_m: float, random: np.random.Generator) -> Tree:
    x, y, _ = road.to_world(station_m, offset_m)
    return Tree(x, y, height_m, int(random.integers(KINDS_OF_TREE)))


def _street_trees(road: Road, side: float, gaps: list[tuple[float, float]], random: np.random.Generator) -> list[Tree]:
    """One behind the hedge every few metres, where no building stands."""
    trees = []
    for first, last in gaps:
        for station in np.arange(first + 3.5, last - 3.4, TREE_SPACING_M):
            offset = side * (_verge_m(road) + 2.6 + random.uniform(0.0, 1.5))
            trees.append(_tree(road, float(station) + random.uniform(-1.5, 1.5), offset, random.uniform(5.5, 8.5), random))
    return trees


def _far_trees(scenario: Scenario, road: Road, side: float, random: np.random.Generator) -> list[Tree]:
    """Taller ones in the gardens behind, seen above hedges and between houses."""
    trees = []
    for station in np.arange(-BEFORE_M, road.length_m + AFTER_M, FAR_TREE_SPACING_M):
        at = float(station) + random.uniform(-4.0, 4.0)
        offset = side * (_verge_m(road) + random.uniform(11.0, 20.0))
        inside = any(
            house.offset_m * side > 0
            and abs(at - house.station_m) < house.length_m / 2 + 4.0
            and abs(offset) < abs(house.offset_m) + house.depth_m + 4.0
            for house in scenario.buildings
        )
        if not inside:
            trees.append(_tree(road, at, offset, random.uniform(8.0, 13.0), random))
    return trees


def _lamps(road: Road) -> list[Lamp]:
    """On alternate sides, just behind the kerb."""
    lamps = []
    for i, station in enumerate(np.arange(6.0 - LAMP_SPACING_M, road.length_m + AFTER_M, LAMP_SPACING_M)):
        side = 1.0 if i % 2 else -1.0
        x, y, heading = road.to_world(float(station), side * (road.half_width_m + 0.45))
        lamps.append(Lamp(x, y, heading - side * np.pi / 2))
    return lamps
