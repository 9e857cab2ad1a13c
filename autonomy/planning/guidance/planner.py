"""The guidance planner: from people's predictions to a few ways that pass them differently. Pure, and deterministic for a seed.

`guide` plans for a disc at the car's middle among discs (means only: what is uncertain is the local planner's), on a grid of
goals along the path, and promises no more than a start for an optimiser: no dynamics beyond speed, acceleration and slant of
straight edges, no shape of the car, and of the road only that every node has room. Bad input is answered by fewer ways or
none, with the reason. It never raises and never decides which way is taken.
Source: the paper, III-D; T-MPC (its reference 17); winding numbers (its reference 38).
"""

from dataclasses import replace

import numpy as np

from autonomy.planning.guidance.admission import Scene, admitted
from autonomy.planning.guidance.drawing import Drawn, blank, draw_ways
from autonomy.planning.guidance.graph import Graph, Ints, empty_graph, grow, trimmed
from autonomy.planning.guidance.identities import known_now, name, remembered
from autonomy.planning.guidance.outcome import code_of, guidance_of
from autonomy.planning.guidance.propagation import carried, to_carry
from autonomy.planning.guidance.sampling import lay_goals, on_line, scatter, straight_on
from autonomy.planning.guidance.search import Ways, cheapest, no_ways, search
from autonomy.planning.guidance.settings import GuidanceSettings
from autonomy.planning.guidance.splines import FINE, tiers
from autonomy.planning.guidance.state import Guidances, GuidanceState, KnownClass, Lack, Searched
from autonomy.planning.guidance.winding import phases
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, CarState, Floats, Predictions
from autonomy.planning.reference_path import ReferencePath


def guide(
    state: GuidanceState,
    car: CarState,
    path: ReferencePath,
    predictions: Predictions,
    settings: GuidanceSettings,
    elapsed_s: float = PLAN_PERIOD_S,
) -> tuple[GuidanceState, Guidances]:
    """elapsed_s: since the last call. Predictions begin at the car's own stamp."""
    scene, lack = admitted(car, path, predictions, settings)
    if scene is None:
        return replace(state, nodes=np.empty((0, 3))), Guidances(lack=lack)
    stages = elapsed_s / STEP_S
    old = carried(state.nodes, stages, settings.samples // 2)
    chance, graph = _graph(state.chance, old, scene, settings)
    ways, rows, drawn = _ways(graph, scene, settings)
    return _told(replace(state, chance=chance), graph, ways, rows, drawn, scene, stages)


def _graph(chance: int, old: Floats, scene: Scene, settings: GuidanceSettings) -> tuple[int, Graph]:
    """The next state of chance, and the graph. Tried in turn: nodes of the last cycle, the path itself, chance."""
    line, start, drive, crowd = scene.line, scene.start, scene.drive, scene.who.crowd
    most = settings.goals_ahead * (2 * settings.goals_aside + 1)
    goals, costs = np.empty((most, 5)), np.empty(most)
    laid = lay_goals(line, start[3], scene.reach_m, drive, settings.goals_ahead, settings.goals_aside, goals, costs)
    candidates = np.empty((settings.samples, 5))
    candidates[: len(old), :3] = old
    on_line(line, candidates[: len(old)])
    fresh = candidates[len(old) :]
    fresh = fresh[straight_on(line, start, goals[:laid], drive, fresh) :]
    after = scatter(np.uint64(chance), line, start[3], scene.reach_m, drive, fresh)
    graph = empty_graph(start, goals[:laid], costs[:laid], settings.samples, len(crowd.tracks))
    return int(after), trimmed(graph, grow(graph, candidates, crowd, drive))


def _ways(graph: Graph, scene: Scene, settings: GuidanceSettings) -> tuple[Ways, Ints, Drawn]:
    """All classes, the rows of the best that hold as splines, best first, and those drawn."""
    crowd = scene.who.crowd
    ways = no_ways(len(crowd.tracks))
    rows = cheapest(ways, search(graph, crowd, ways), settings.trajectories)
    drawn = blank(len(rows))
    draw_ways(graph, ways, rows, tiers(), crowd, scene.heading_rad, settings.ahead_m, drawn)
    holds = drawn.counts > 0
    return ways, rows[holds], Drawn._make(column[holds] for column in drawn)


def _told(
    state: GuidanceState, graph: Graph, ways: Ways, rows: Ints, drawn: Drawn, scene: Scene, stages: float
) -> tuple[GuidanceState, Guidances]:
    """The ways with their names, and what the next cycle has to know."""
    who = scene.who
    codes = tuple(code_of(who.numbers, ways.sides[row]) for row in rows)
    seen = tuple(zip(who.numbers, phases(scene.start, who.crowd).tolist(), strict=True))
    known = known_now(state.classes, state.phases, seen)
    names, next_identity = name(codes, known, state.next_identity)
    found = tuple(KnownClass(identity=identity, code=code) for identity, code in zip(names, codes, strict=True))
    connectors = tuple(ways.connectors[row, : ways.lengths[row]] for row in rows)
    after = GuidanceState(
        chance=state.chance,
        nodes=to_carry(graph, connectors, [places[::FINE] for places in drawn.places], stages),
        classes=remembered(found, known),
        phases=seen,
        next_identity=next_identity,
    )
    costs = ways.costs[rows, 0].tolist()
    told = tuple(guidance_of(each.identity, each.code, drawn, row, costs[row]) for row, each in enumerate(found))
    lack = None if told else Lack.NO_WAY
    searched = Searched(graph=graph, connectors=connectors)
    return after, Guidances(ways=told, lack=lack, left_out=who.left_out, searched=searched)
