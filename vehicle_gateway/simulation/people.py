"""People in the simulated street: they follow their way points and do not walk into the car. Pure.

They walk in road coordinates, so that a way along the sidewalk follows the bend. They do not look out for a car driving
towards them: keeping clear of them is the driver's task. Their walking speed varies a little, from the scenario's seed.
"""

from collections.abc import Sequence
from math import atan2, hypot
from random import Random

from msgspec import Struct
from msgspec.structs import replace

from vehicle_gateway.simulation.shapes import Outline, point_gap_m
from wire.messages.sensing import MovingPerson
from wire.road import Road, wrap_angle
from wire.scenario import Person

RADIUS_M = 0.3  # of the circle a person takes up
KEEPS_CLEAR_M = 1.2  # of the car's outline, measured from the person's middle
SPEED_VARIES = 0.1  # walking speed is within +- this share of the scenario's
STRIDE_M = 1.4  # two steps: one turn of the gait


class Walker(Struct, frozen=True, kw_only=True):
    """One person's state."""

    person: Person
    walks_at_m_s: float  # the scenario's speed with this person's variation
    station_m: float
    offset_m: float
    heading_rad: float  # map frame
    x_m: float
    y_m: float
    towards: int = 1  # way point
    forward: bool = True  # along the way; false on the way back
    started: bool = False
    speed_m_s: float = 0.0
    phase: float = 0.0  # of the gait, 0 to 1


def people_at_start(people: Sequence[Person], road: Road, random: Random) -> tuple[Walker, ...]:
    """Everybody on the first way point, looking towards the second."""
    return tuple(_walker(person, road, random.uniform(1 - SPEED_VARIES, 1 + SPEED_VARIES)) for person in people)


def _walker(person: Person, road: Road, speed_factor: float) -> Walker:
    station, offset = person.way[0]
    x, y, _ = road.to_world(station, offset)
    to_x, to_y, _ = road.to_world(*person.way[min(1, len(person.way) - 1)])
    return Walker(
        person=person,
        walks_at_m_s=person.speed_m_s * speed_factor,
        station_m=station,
        offset_m=offset,
        heading_rad=atan2(to_y - y, to_x - x),
        x_m=x,
        y_m=y,
    )


def step_people(people: Sequence[Walker], car: Outline, dt_s: float, road: Road) -> tuple[Walker, ...]:
    """Everybody dt_s later."""
    return tuple(_step(walker, car, dt_s, road) for walker in people)


def _step(walker: Walker, car: Outline, dt_s: float, road: Road) -> Walker:
    if not walker.started:
        if hypot(walker.x_m - car.x_m, walker.y_m - car.y_m) > walker.person.starts_when_car_within_m:
            return walker
        walker = replace(walker, started=True)
    moved = _advance(walker, walker.walks_at_m_s * dt_s, road)
    if moved is None or _would_walk_into(car, walker, moved):
        return walker if walker.speed_m_s == 0.0 else replace(walker, speed_m_s=0.0)
    return moved


def _would_walk_into(car: Outline, before: Walker, after: Walker) -> bool:
    gap = point_gap_m(car, after.x_m, after.y_m)
    return gap < KEEPS_CLEAR_M and gap < point_gap_m(car, before.x_m, before.y_m)


def _advance(walker: Walker, distance_m: float, road: Road) -> Walker | None:
    """`distance_m` further along the way; None at its end. A way point is passed within one step, not cut."""
    if distance_m <= 0.0:
        return None
    target = _next_target(walker)
    if target is None:
        return None
    walker = target
    to_station, to_offset = walker.person.way[walker.towards]
    stretch = max(1.0 - road.curvature_1_m(walker.station_m) * walker.offset_m, 0.1)  # metres per metre of station
    along, across = (to_station - walker.station_m) * stretch, to_offset - walker.offset_m
    share = min(distance_m / max(hypot(along, across), 1e-9), 1.0)
    station = to_station if share == 1.0 else walker.station_m + (to_station - walker.station_m) * share
    offset = to_offset if share == 1.0 else walker.offset_m + across * share
    x, y, road_heading = road.to_world(station, offset)
    return replace(
        walker,
        station_m=station,
        offset_m=offset,
        x_m=x,
        y_m=y,
        speed_m_s=walker.walks_at_m_s,
        heading_rad=wrap_angle(road_heading + atan2(across, along)),
        phase=(walker.phase + distance_m / STRIDE_M) % 1.0,
    )


def _next_target(walker: Walker) -> Walker | None:
    """The walker with a way point ahead that is not reached yet; None at the end of a way without return."""
    last = len(walker.person.way) - 1
    if last == 0:
        return None
    if (walker.station_m, walker.offset_m) != walker.person.way[walker.towards]:
        return walker
    onward = walker.towards + (1 if walker.forward else -1)
    if 0 <= onward <= last:
        return replace(walker, towards=onward)
    if not walker.person.returns:
        return None
    return replace(walker, forward=not walker.forward, towards=walker.towards + (-1 if walker.forward else 1))


def seen_by_camera(walker: Walker) -> MovingPerson:
    return MovingPerson(
        x_m=walker.x_m, y_m=walker.y_m, heading_rad=walker.heading_rad, speed_m_s=walker.speed_m_s, phase=walker.phase
    )
