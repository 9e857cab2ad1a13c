"""People who walk to their goal and keep off each other, off what stands, and off the car: a social force model. Pure, arrays.

Source: Helbing and Molnar, "Social force model for pedestrian dynamics", Phys. Rev. E 51, 1995: relaxation time 0.5 s, repulsion
2.1 m2/s2 over 0.3 m, sight 200 degrees, at most 1.3 times the wanted speed. The car repels from the nearest point of its outline,
over a longer way, as a thing that does not give way (ours).
"""

from typing import NamedTuple

import numpy as np

from autonomy.planning.crossings.scenario import World, ride_goal_m
from autonomy.planning.horizon import Floats

STEP_S = 0.05
RELAXATION_S = 0.5
PUSH_M_S2, PUSH_RANGE_M = 7.0, 0.3  # 2.1 m2/s2 over 0.3 m
CAR_PUSH_M_S2, CAR_RANGE_M = 5.0, 0.7
UNSEEN = 0.5  # what is behind counts half
SIGHT_COS = float(np.cos(np.radians(100.0)))
HURRY = 1.3
ARRIVED_M = 0.5
TOGETHER_M = 1e-9


class Outline(NamedTuple):
    """The car, rear axle."""

    x_m: float
    y_m: float
    heading_rad: float
    front_m: float
    rear_m: float  # positive
    half_width_m: float


class People(NamedTuple):
    places_m: Floats  # (n, 2)
    velocities_m_s: Floats  # (n, 2)


def at_start(world: World) -> People:
    """Under way at their own speed: nobody needs a second to get going."""
    return People(world.positions_m.copy(), _towards(world.positions_m, world) * world.speeds_m_s[:, None])


def step(people: People, world: World, car: Outline, dt_s: float = STEP_S) -> People:
    """Everybody dt_s later."""
    places, velocities = people
    wanted = _towards(places, world) * world.speeds_m_s[:, None]
    force = (wanted - velocities) / RELAXATION_S
    pushed = _from_each_other(places, velocities, world) + _from_things(places, world) + _from_car(places, world, car)
    force = force + np.where(world.reacts[:, None], pushed, 0.0)
    velocities = velocities + force * dt_s
    speed = np.linalg.norm(velocities, axis=1, keepdims=True)
    velocities = velocities * np.minimum(1.0, HURRY * world.speeds_m_s[:, None] / np.maximum(speed, 1e-9))
    return People(places + velocities * dt_s, velocities)


def gaps_m(places_m: Floats, radii_m: Floats, car: Outline) -> Floats:
    """(n,) from each circle to the car's outline; negative: they touch."""
    away, _ = _off_outline(places_m, car)
    return away - radii_m


def _towards(places: Floats, world: World) -> Floats:
    """Unit vectors to the goals; zero for who has arrived."""
    way = _goals_m(places, world) - places
    distance = np.linalg.norm(way, axis=1, keepdims=True)
    return np.where(distance > ARRIVED_M, way / np.maximum(distance, 1e-9), 0.0)


def _goals_m(places: Floats, world: World) -> Floats:
    """(n, 2) where everybody is bound for: riders, who come last, along the street."""
    riders = world.crossing.riders
    if not riders:
        return world.goals_m
    rides = [ride_goal_m(world.road, rider, *place) for rider, place in zip(riders, places[-len(riders) :].tolist(), strict=True)]
    return np.concatenate((world.goals_m[: -len(riders)], np.array(rides)))


def _from_each_other(places: Floats, velocities: Floats, world: World) -> Floats:
    apart = places[:, None] - places[None]  # (n, n, 2) from the other to oneself
    first = np.sign(np.subtract.outer(np.arange(len(places)), np.arange(len(places))))  # who stand at one place part along x
    apart[..., 0] += np.where(np.abs(apart).max(axis=2) < TOGETHER_M, TOGETHER_M * first, 0.0)
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    unit = apart / np.maximum(distance, TOGETHER_M)[..., None]
    push = PUSH_M_S2 * np.exp((world.radii_m[:, None] + world.radii_m[None] - distance) / PUSH_RANGE_M)
    speed = np.linalg.norm(velocities, axis=1)
    ahead = -(unit * velocities[:, None]).sum(axis=2) >= speed[:, None] * SIGHT_COS  # the other lies in sight
    total: Floats = (push[..., None] * np.where(ahead, 1.0, UNSEEN)[..., None] * unit).sum(axis=1)
    return total


def _from_things(places: Floats, world: World) -> Floats:
    apart = places[:, None] - world.things_m[None]
    distance = np.maximum(np.linalg.norm(apart, axis=2), 1e-9)
    push = PUSH_M_S2 * np.exp((world.radii_m[:, None] + world.thing_radii_m[None] - distance) / PUSH_RANGE_M)
    total: Floats = (push[..., None] * apart / distance[..., None]).sum(axis=1)
    return total


def _from_car(places: Floats, world: World, car: Outline) -> Floats:
    away, unit = _off_outline(places, car)
    pushed: Floats = CAR_PUSH_M_S2 * np.exp((world.radii_m - away) / CAR_RANGE_M)[:, None] * unit
    return pushed


def _off_outline(places: Floats, car: Outline) -> tuple[Floats, Floats]:
    """Distance (n,) from the outline, 0 inside, and the unit vectors (n, 2) away from its nearest point."""
    c, s = np.cos(car.heading_rad), np.sin(car.heading_rad)
    dx, dy = places[:, 0] - car.x_m, places[:, 1] - car.y_m
    ahead, left = dx * c + dy * s, dy * c - dx * s
    off = np.stack(
        (ahead - np.clip(ahead, -car.rear_m, car.front_m), left - np.clip(left, -car.half_width_m, car.half_width_m)), axis=1
    )
    distance = np.linalg.norm(off, axis=1)
    aside = np.stack((np.zeros_like(left), np.sign(left)), axis=1)  # for who stands inside
    outward = np.where(distance[:, None] > 1e-9, off / np.maximum(distance, 1e-9)[:, None], aside)
    turned = np.stack((outward[:, 0] * c - outward[:, 1] * s, outward[:, 0] * s + outward[:, 1] * c), axis=1)
    return distance, turned
