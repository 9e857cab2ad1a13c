"""A planner drives through a crossing: car and people step by step, what the planner is told of the people, and the verdict. Pure.

The car is the kinematic bicycle with a lag of its actuators; the planner is told everybody it can see, at constant velocity, with
a deviation that grows. Beyond the 4 s of the paper's predictions the same goes on to the horizon's end, wider: a person who is not
predicted there would be free room. Nothing here knows a planner: it takes what is seen and says acceleration and steering rate.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, sin, tan
from typing import NamedTuple

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.planning.crossings.people import STEP_S as PEOPLE_S
from autonomy.planning.crossings.people import Outline, People, at_start, gaps_m, step
from autonomy.planning.crossings.replayed import PEOPLE_MAX
from autonomy.planning.crossings.scenario import World
from autonomy.planning.horizon import PLAN_PERIOD_S, STEP_S, STEPS, CarState, Floats, Predictions

SPREAD_M_S = 0.3  # each axis: sigma_k = 0.3 m/s dt sqrt(k), as the method's authors
SEEN_M = 40.0
LAG_S = 0.1  # of acceleration and steering
EDGE_M = 0.3  # a corner so far beyond the road's edge is a collision with it
TRACK_0 = 1000  # numbers of recorded people, then of things: never those of the crossers
THING_0 = TRACK_0 + PEOPLE_MAX


class Seen(NamedTuple):
    """What the planner is told."""

    time_s: float
    car: CarState
    predictions: Predictions


class Asked(NamedTuple):
    acceleration_m_s2: float
    steering_rate_rad_s: float
    braking: bool = False  # it had no plan


Planner = Callable[[Seen], Asked]


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    duration_s: float
    collided: bool  # with a person, a thing, or the edge of the road (EDGE_M)
    timed_out: bool
    mean_speed_m_s: float
    closest_m: float | None  # to anybody; None: there was nobody
    off_road_m: float  # the farthest a corner was beyond the edge
    braked: int  # cycles without a plan


@dataclass(frozen=True, slots=True)
class Moment:
    """For drawing."""

    time_s: float
    car: CarState
    places_m: Floats


def drive(world: World, shape: CarShape, planner: Planner, start_speed_m_s: float = 0.5) -> tuple[Verdict, list[Moment]]:
    """From the start of the road to the goal, a collision, or the end of the time."""
    x, y, heading = world.road.to_world(0.0)
    car = CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=start_speed_m_s, road_wheel_angle_rad=0.0, station_m=0.0)
    people, steps, time_s, pulled = at_start(world), 0, 0.0, (0.0, 0.0)
    moments, closest, off_road, braked = [], np.inf, 0.0, 0
    while car.station_m < world.crossing.goal_m and time_s < world.crossing.time_limit_s - 1e-9:
        moments.append(Moment(time_s, car, everybody(world, people, time_s)[1]))
        asked = planner(Seen(time_s, car, predictions(world, people, car, time_s)))
        braked += asked.braking
        for _ in range(round(PLAN_PERIOD_S / PEOPLE_S)):
            car, pulled = _moved(car, asked, pulled, shape, world, PEOPLE_S)
            people = step(people, world, outline_of(car, shape))
            steps += 1
            time_s = steps * PEOPLE_S
            _, places, _, radii = everybody(world, people, time_s)
            closest = min(closest, float(gaps_m(places, radii, outline_of(car, shape)).min(initial=np.inf)))
            off_road = max(off_road, _beyond_edge_m(car, shape, world))
        if closest < 0.0 or off_road > EDGE_M:
            break
    travelled = max(car.station_m, 0.0)
    reached = car.station_m >= world.crossing.goal_m
    hit = closest < 0.0 or off_road > EDGE_M
    verdict = Verdict(
        duration_s=time_s,
        collided=hit,
        timed_out=not reached and not hit,
        mean_speed_m_s=travelled / time_s if time_s else 0.0,
        closest_m=closest if np.isfinite(closest) else None,
        off_road_m=off_road,
        braked=braked,
    )
    return verdict, moments


def outline_of(car: CarState, shape: CarShape) -> Outline:
    return Outline(car.x_m, car.y_m, car.heading_rad, shape.front_m, shape.rear_m, shape.half_width_m)


def everybody(world: World, people: People, time_s: float) -> tuple[tuple[int, ...], Floats, Floats, Floats]:
    """Numbers, places (n, 2), velocities (n, 2), radii (n,): crossers and riders, recorded people, things."""
    numbers = list(range(len(people.places_m)))
    places, velocities, radii = [people.places_m], [people.velocities_m_s], [world.radii_m]
    if world.tracks is not None:
        there, at, moving = world.tracks.at(time_s)
        numbers += [TRACK_0 + number for number in there]
        places, velocities, radii = [*places, at], [*velocities, moving], [*radii, np.full(len(there), 0.3)]
    numbers += [THING_0 + k for k in range(len(world.things_m))]
    places, velocities = [*places, world.things_m], [*velocities, np.zeros_like(world.things_m)]
    return tuple(numbers), np.concatenate(places), np.concatenate(velocities), np.concatenate([*radii, world.thing_radii_m])


def predictions(world: World, people: People, car: CarState, time_s: float) -> Predictions:
    """Of everybody in sight: constant velocity, a deviation that grows with the root of time; what stands does not spread."""
    numbers, places, velocities, radii = everybody(world, people, time_s)
    near = np.hypot(places[:, 0] - car.x_m, places[:, 1] - car.y_m) < SEEN_M
    seen = [k for k in np.flatnonzero(near) if not is_hidden(world, car, places[k])]
    stages = np.arange(STEPS + 1)
    means = places[seen][None] + stages[:, None, None] * STEP_S * velocities[seen][None]
    moves = np.array([numbers[k] < THING_0 for k in seen], float)
    variance = (SPREAD_M_S * STEP_S) ** 2 * stages[:, None] * moves[None]
    covariances = variance[:, :, None, None] * np.eye(2)
    return Predictions(
        numbers=tuple(numbers[k] for k in seen), positions_m=means, covariances_m2=covariances, radii_m=radii[seen].astype(float)
    )


def is_hidden(world: World, car: CarState, place_m: Floats) -> bool:
    """Whether a wall stands between the driver's place (2 m before the rear axle) and this one."""
    eye = (car.x_m + 2.0 * cos(car.heading_rad), car.y_m + 2.0 * sin(car.heading_rad))
    for wall in world.crossing.occluders:
        a, b = (world.road.to_world(wall.station_m + half, wall.offset_m)[:2] for half in (-wall.length_m / 2, wall.length_m / 2))
        if _cross(eye, place_m, a, b):
            return True
    return False


def _cross(p: tuple[float, float], q: Floats, a: tuple[float, float], b: tuple[float, float]) -> bool:
    def side(u: tuple[float, float] | Floats, v: tuple[float, float] | Floats, w: tuple[float, float] | Floats) -> float:
        return float((v[0] - u[0]) * (w[1] - u[1]) - (v[1] - u[1]) * (w[0] - u[0]))

    return side(p, q, a) * side(p, q, b) < 0 and side(a, b, p) * side(a, b, q) < 0


def _moved(
    car: CarState, asked: Asked, pulled: tuple[float, float], shape: CarShape, world: World, dt_s: float
) -> tuple[CarState, tuple[float, float]]:
    """The car dt_s later, and what its actuators do by then."""
    share = dt_s / (LAG_S + dt_s)
    acceleration = pulled[0] + share * (asked.acceleration_m_s2 - pulled[0])
    rate = pulled[1] + share * (asked.steering_rate_rad_s - pulled[1])
    bound = shape.road_wheel_angle_max_rad
    angle = min(max(car.road_wheel_angle_rad + rate * dt_s, -bound), bound)
    speed = max(car.speed_m_s + acceleration * dt_s, 0.0)
    mean, turn = (speed + car.speed_m_s) / 2, (angle + car.road_wheel_angle_rad) / 2
    heading = car.heading_rad + mean * tan(turn) / shape.wheelbase_m * dt_s
    middle = (heading + car.heading_rad) / 2
    x, y = car.x_m + mean * dt_s * cos(middle), car.y_m + mean * dt_s * sin(middle)
    station = world.road.to_road(x, y, car.station_m).station_m
    moved = CarState(x_m=x, y_m=y, heading_rad=heading, speed_m_s=speed, road_wheel_angle_rad=angle, station_m=station)
    return moved, (acceleration, rate)


def _beyond_edge_m(car: CarState, shape: CarShape, world: World) -> float:
    """How far the outermost corner is off the road."""
    beyond = 0.0
    for ahead in (shape.front_m, -shape.rear_m):
        for left in (shape.half_width_m, -shape.half_width_m):
            c, s = cos(car.heading_rad), sin(car.heading_rad)
            at = world.road.to_road(car.x_m + ahead * c - left * s, car.y_m + ahead * s + left * c, car.station_m)
            beyond = max(beyond, abs(at.offset_m) - world.crossing.half_width_m)
    return beyond
