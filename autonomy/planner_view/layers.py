"""What there is to draw of one cycle, as points in the map frame: the same for a picture, Foxglove and whoever else draws. Pure."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.planner_view.colours import Given, colour
from autonomy.planner_view.watched import Cycle
from autonomy.planning.crossings.drive import THING_0, TRACK_0
from autonomy.planning.crossings.scenario import PERSON_RADIUS_M, World
from autonomy.planning.guidance.outcome import view_of
from autonomy.planning.guidance.state import Code
from autonomy.planning.guidance.winding import Side
from autonomy.planning.horizon import STEP_S, Floats, Predictions
from autonomy.planning.topology import BRAKING, UNGUIDED, Candidate, Decision
from wire.planner_colours import Rgb

EDGE_STEP_M = 1.0
SECOND = round(1.0 / STEP_S)  # stages
ROUND = np.linspace(0.0, 2.0 * np.pi, 49)[:-1]
WORDS = {Side.LEFT: "left of", Side.RIGHT: "right of", Side.NON_PASSING: "behind"}
NAMES = {UNGUIDED: "without guidance", BRAKING: "braking: no plan"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Street:
    left_m: Floats  # (n, 2)
    right_m: Floats
    goal_m: Floats  # (2, 2) across
    walls_m: Floats  # (w, 2, 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    label: str  # the same in a legend
    radius_m: float
    stands: bool  # a thing
    means_m: Floats  # (STEPS + 1, 2)
    two_sigma_m: Floats  # (seconds, points, 2) around the means of every second


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """A candidate: its guidance, and what was made of it."""

    identity: int
    name: str
    does: str  # whom it passes where; "" without guidance
    colour: Rgb
    guidance_m: Floats | None  # (STEPS + 1, 2) of the rear axle, as the trajectory
    trajectory_m: Floats  # (STEPS + 1, 2); nothing when it was refused
    feasible: bool
    chosen: bool
    cost: float


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    time_s: float
    speed_m_s: float
    station_m: float  # of the rear axle along the road
    street: Street
    people: tuple[Person, ...]
    unseen_m: Floats  # (n, 2) of people whom the planner is not told of
    graph_m: Floats  # (m, 2, 2) edges that guidance looked through
    ways: tuple[Way, ...]
    car_m: Floats  # (4, 2) outline now
    swept_m: Floats  # (k, 4, 2) and along the chosen trajectory, each second


def view(world: World, street: Street, cycle: Cycle, given: Given, shape: CarShape) -> View:
    car, people = cycle.seen.car, cycle.seen.predictions
    poses = cycle.decision.chosen.trajectory.states[::SECOND, :3]
    return View(
        time_s=cycle.seen.time_s,
        speed_m_s=car.speed_m_s,
        station_m=car.station_m,
        street=street,
        people=tuple(_person(people, k) for k in range(people.count)),
        unseen_m=_unseen(cycle.places_m, people),
        graph_m=_edges(cycle.decision),
        ways=_ways(cycle.decision, given),
        car_m=outline(np.array((car.x_m, car.y_m, car.heading_rad)), shape),
        swept_m=np.array([outline(pose, shape) for pose in poses[1:]]),
    )


def street_of(world: World, before_m: float = 20.0, beyond_m: float = 30.0) -> Street:
    """The road goes straight on before its start and beyond its end."""
    half, road = world.crossing.half_width_m, world.road
    stations = np.arange(-before_m, road.length_m + beyond_m, EDGE_STEP_M)
    left, right = (np.array([road.to_world(float(s), offset)[:2] for s in stations]) for offset in (half, -half))
    goal = np.array([road.to_world(world.crossing.goal_m, offset)[:2] for offset in (half, -half)])
    walls = [
        [road.to_world(wall.station_m + end, wall.offset_m)[:2] for end in (-wall.length_m / 2, wall.length_m / 2)]
        for wall in world.crossing.occluders
    ]
    return Street(left_m=left, right_m=right, goal_m=goal, walls_m=np.array(walls, float).reshape(-1, 2, 2))


def outline(pose: Floats, shape: CarShape) -> Floats:
    """(4, 2) corners of the car whose rear axle is at x_m, y_m, heading_rad."""
    x, y, heading = pose
    ahead, left = np.array((cos(heading), sin(heading))), np.array((-sin(heading), cos(heading)))
    corners = [(shape.front_m, 1.0), (shape.front_m, -1.0), (-shape.rear_m, -1.0), (-shape.rear_m, 1.0)]
    return np.array([(x, y) + along * ahead + side * shape.half_width_m * left for along, side in corners])


def circle(centre_m: Floats, radius_m: float) -> Floats:
    return np.asarray(centre_m + radius_m * np.stack((np.cos(ROUND), np.sin(ROUND)), axis=1), float)


def _person(people: Predictions, k: int) -> Person:
    means, covariances = people.positions_m[:, k], people.covariances_m2[:, k]
    stands = people.numbers[k] >= THING_0
    seconds = () if stands else range(SECOND, len(means), SECOND)
    rings = [two_sigma(means[stage], covariances[stage]) for stage in seconds]
    return Person(
        label=label(people.numbers[k]),
        radius_m=float(people.radii_m[k]),
        stands=stands,
        means_m=means,
        two_sigma_m=np.array(rings).reshape(-1, len(ROUND), 2),
    )


def two_sigma(mean_m: Floats, covariance_m2: Floats) -> Floats:
    """Points of the ellipse two deviations around the mean."""
    variances, axes = np.linalg.eigh(covariance_m2)
    half = 2.0 * np.sqrt(np.maximum(variances, 0.0))
    return np.asarray(mean_m + np.stack((np.cos(ROUND), np.sin(ROUND)), axis=1) * half @ axes.T, float)


def _unseen(places_m: Floats, people: Predictions) -> Floats:
    apart = np.linalg.norm(places_m[:, None] - people.positions_m[0][None], axis=2)
    return np.asarray(places_m[apart.min(axis=1, initial=np.inf) > PERSON_RADIUS_M / 10])


def _edges(decision: Decision) -> Floats:
    searched = decision.guidances.searched
    if searched is None:
        return np.empty((0, 2, 2))
    graph = view_of(searched)
    return np.asarray(graph.nodes[graph.edges, :2])


def _ways(decision: Decision, given: Given) -> tuple[Way, ...]:
    """The chosen one first: it is drawn thick, and who is of its mind is seen on it."""
    there = [*decision.candidates, *([decision.chosen] if decision.braking else [])]
    ordered = sorted(there, key=lambda each: each is not decision.chosen)
    return tuple(_way(each, each is decision.chosen, given) for each in ordered)


def _way(candidate: Candidate, chosen: bool, given: Given) -> Way:
    found, guidance = candidate.trajectory, candidate.guidance
    return Way(
        identity=candidate.identity,
        name=NAMES.get(candidate.identity, f"class {candidate.identity}"),
        does=told(guidance.code) if guidance else "",
        colour=colour(given, candidate.identity),
        guidance_m=guidance.rear_axle_m if guidance else None,
        trajectory_m=np.empty((0, 2)) if found.refused else found.states[:, :2],
        feasible=found.feasible,
        chosen=chosen,
        cost=found.cost,
    )


def told(code: Code) -> str:
    """Whom it passes on which side, and behind whom it stays."""
    by_side = ((words, [label(number) for number, each in code if each is side]) for side, words in WORDS.items())
    does = [f"{words} {', '.join(numbers)}" for words, numbers in by_side if numbers]
    return "; ".join(does) or "nobody to pass"


def label(number: int) -> str:
    """Things, recorded people and people: T0, R0, 0."""
    return f"T{number - THING_0}" if number >= THING_0 else f"R{number - TRACK_0}" if number >= TRACK_0 else str(number)
