"""The referee: the truth about a drive from the simulated world alone - collisions, closest gap, goal, distance. Pure.

A contact counts once, when it begins, whatever the car touches and however long; it is over when 0.2 m lie between.
Kerbs are no collision. Nobody who drives sees any of this.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import hypot, inf

from msgspec import Struct
from msgspec.structs import replace

from vehicle_gateway.simulation.people import RADIUS_M, Walker
from vehicle_gateway.simulation.powertrain import Car
from vehicle_gateway.simulation.shapes import Outline, Polygon, corners, point_gap_m, polygon_gap_m
from vehicle_gateway.simulation.site import StaticObject, object_corners
from wire.messages.sensing import Referee
from wire.road import Road

GOAL_WITHIN_M = 3.0  # before the goal's station
GOAL_BELOW_M_S = 0.3
APART_M = 0.2  # ends a contact
CLOSEST_UNKNOWN_M = 1e5  # nothing was near yet (the range of the message)


@dataclass(frozen=True, slots=True)
class Obstacle:
    """Something static: a circle (a cone), or a convex polygon inside its circle."""

    kind: str
    x_m: float
    y_m: float
    radius_m: float
    polygon: Polygon | None


class RefereeState(Struct, frozen=True):
    collisions: int = 0
    collided_with: str = ""
    touching: frozenset[str] = frozenset()
    closest_m: float = CLOSEST_UNKNOWN_M
    distance_m: float = 0.0
    goal_reached: bool = False


def obstacles(objects: Sequence[StaticObject], buildings: Sequence[Polygon]) -> tuple[Obstacle, ...]:
    static = [
        Obstacle(thing.kind, thing.x_m, thing.y_m, thing.radius_m, None if thing.kind == "cone" else object_corners(thing))
        for thing in objects
    ]
    return (*static, *(_building(polygon) for polygon in buildings))


def _building(polygon: Polygon) -> Obstacle:
    x, y = sum(x for x, _ in polygon) / len(polygon), sum(y for _, y in polygon) / len(polygon)
    return Obstacle("building", x, y, max(hypot(px - x, py - y) for px, py in polygon), polygon)


def judge(
    state: RefereeState,
    outline: Outline,
    people: Sequence[Walker],
    static: Sequence[Obstacle],
    station_m: float,
    goal_station_m: float,
    speed_m_s: float,
    dt_s: float,
) -> RefereeState:
    """The verdict after the car moved on by dt_s (made for 50 to 200 Hz)."""
    gaps = dict(_gaps(outline, people, static, state.closest_m))
    touching = frozenset(name for name, gap in gaps.items() if gap <= 0.0 or (name in state.touching and gap < APART_M))
    new = sorted(touching - state.touching)
    closest = min(gaps.values(), default=inf)
    goal = station_m >= goal_station_m - GOAL_WITHIN_M and abs(speed_m_s) < GOAL_BELOW_M_S
    return replace(
        state,
        collisions=state.collisions + len(new),
        touching=touching,
        closest_m=min(state.closest_m, max(closest, 0.0)),
        collided_with=new[-1].partition(" ")[0] if new else state.collided_with,
        distance_m=state.distance_m + abs(speed_m_s) * dt_s,
        goal_reached=state.goal_reached or goal,
    )


def _gaps(outline: Outline, people: Sequence[Walker], static: Sequence[Obstacle], closest_m: float) -> list[tuple[str, float]]:
    """(name, gap) of everybody, and of the static things near enough to matter."""
    gaps = [(f"person {i}", point_gap_m(outline, person.x_m, person.y_m) - RADIUS_M) for i, person in enumerate(people)]
    shape = corners(outline)
    for i, thing in enumerate(static):
        around = point_gap_m(outline, thing.x_m, thing.y_m) - thing.radius_m
        if around > max(closest_m, APART_M):
            continue  # its circle is farther than anything that counts
        gap = around if thing.polygon is None else polygon_gap_m(shape, thing.polygon)
        gaps.append((f"{thing.kind} {i}", gap))
    return gaps


def report(state: RefereeState, car: Car, road: Road, now_ns: int, elapsed_s: float, near_station_m: float) -> Referee:
    place = road.to_road(car.body.x_m, car.body.y_m, near_station_m)
    return Referee(
        stamp_ns=now_ns,
        elapsed_s=elapsed_s,
        station_m=place.station_m,
        offset_m=place.offset_m,
        x_m=car.body.x_m,
        y_m=car.body.y_m,
        speed_m_s=car.body.vx_m_s,
        distance_m=state.distance_m,
        collisions=state.collisions,
        collided_with=state.collided_with,
        goal_reached=state.goal_reached,
        closest_m=state.closest_m,
    )


def tells_news(before: RefereeState, after: RefereeState) -> bool:
    """Whether something happened that must not wait for the next regular report."""
    return before.collisions != after.collisions or before.goal_reached != after.goal_reached
