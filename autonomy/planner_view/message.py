"""A decision as the message `planner_view`: what an operator's window draws on the road, and Foxglove of a drive. Pure."""

from math import atan2, hypot, isfinite, sqrt

from autonomy.planner_view.colours import Given, give
from autonomy.planning.horizon import STEP_S, Floats, Predictions
from autonomy.planning.topology import Candidate, Decision
from wire.messages.automation import PlannedWay, PlannerView, PredictedPerson, PredictedPlace, WayPoints

SECOND = round(1.0 / STEP_S)  # stages
PEOPLE_MAX = 64  # of the message


def planner_view(decision: Decision, people: Predictions | None, given: Given, stamp_ns: int) -> PlannerView:
    """people: whom it was made among; None: nobody looked."""
    told = (*decision.candidates, decision.chosen) if decision.braking else decision.candidates
    return PlannerView(
        stamp_ns=stamp_ns,
        ways=tuple(_way(each, each is decision.chosen, given) for each in told),
        people=_people(people) if people is not None else (),
    )


def next_view(before: Given, decision: Decision, people: Predictions | None, stamp_ns: int) -> tuple[Given, PlannerView]:
    """The view of the next plan of a drive; classes keep the colours that they were `given`."""
    given = give(before, (each.identity for each in decision.candidates))
    return given, planner_view(decision, people, given, stamp_ns)


def _people(people: Predictions) -> tuple[PredictedPerson, ...]:
    """The nearest first, as they were told; who is no number is left out, as the planner brakes for him."""
    told = (_person(people, k) for k in range(min(people.count, PEOPLE_MAX)))
    return tuple(person for person in told if all(isfinite(at.x_m + at.y_m + at.long_m + at.wide_m) for at in person.places))


def _person(people: Predictions, k: int) -> PredictedPerson:
    means, covariances = people.positions_m[::SECOND, k], people.covariances_m2[::SECOND, k]
    stages = 1 if (means == means[0]).all() else len(means)
    return PredictedPerson(
        number=people.numbers[k],
        radius_m=float(people.radii_m[k]),
        places=tuple(_place(means[stage].tolist(), covariances[stage].ravel().tolist()) for stage in range(stages)),
    )


def _place(mean_m: list[float], covariance_m2: list[float]) -> PredictedPlace:
    """Axes of the ellipse of one deviation: the eigenvalues of a symmetric 2 x 2 matrix, in closed form."""
    along_x, mixed, _, along_y = covariance_m2
    middle, half = (along_x + along_y) / 2.0, hypot((along_x - along_y) / 2.0, mixed)
    return PredictedPlace(
        x_m=mean_m[0],
        y_m=mean_m[1],
        long_m=sqrt(max(middle + half, 0.0)),
        wide_m=sqrt(max(middle - half, 0.0)),
        axis_rad=atan2(2.0 * mixed, along_x - along_y) / 2.0,
    )


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
