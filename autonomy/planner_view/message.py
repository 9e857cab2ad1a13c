"""A decision as the message `planner_view`: what an operator's window draws on the road. Pure."""

from autonomy.planner_view.colours import Given, give
from autonomy.planning.horizon import Floats
from autonomy.planning.topology import Candidate, Decision
from wire.messages.automation import PlannedWay, PlannerView, WayPoints


def planner_view(decision: Decision, given: Given, stamp_ns: int) -> PlannerView:
    told = (*decision.candidates, decision.chosen) if decision.braking else decision.candidates
    return PlannerView(stamp_ns=stamp_ns, ways=tuple(_way(each, each is decision.chosen, given) for each in told))


def next_view(before: Given, decision: Decision, stamp_ns: int) -> tuple[Given, PlannerView]:
    """The view of the next plan of a drive; classes keep the colours that they were `given`."""
    given = give(before, (each.identity for each in decision.candidates))
    return given, planner_view(decision, given, stamp_ns)


def _way(candidate: Candidate, chosen: bool, given: Given) -> PlannedWay:
    found, guidance = candidate.trajectory, candidate.guidance
    return PlannedWay(
        identity=candidate.identity,
        colour=given.get(candidate.identity, 0),
        guidance=_points(guidance.rear_axle_m) if guidance else (),
        trajectory=() if found.refused else _points(found.states[:, :2]),
        feasible=found.feasible,
        chosen=chosen,
    )


def _points(places_m: Floats) -> WayPoints:
    return tuple((float(x), float(y)) for x, y in places_m)
