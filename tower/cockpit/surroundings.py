"""What stands and what moves around the car, in road coordinates, and the memory of what stands. Pure.

side_m is measured across the road from the centre line, positive towards the ONCOMING lane: the same for both sides of driving.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, sin
from typing import NamedTuple

from wire.messages.automation import Scene, TrackedObject
from wire.road import Road

FURNITURE = frozenset({"cone", "barrier"})  # stands whatever the noise of its track says
AGE_MIN_S = 0.3  # a track younger than this may be a ghost
FORGET_AFTER_NS = 1_500_000_000  # not seen where it should be seen
PLAIN_VIEW_M = (4.0, 22.0)  # ahead of the rear axle: what stands here is seen
BEHIND_M = 25.0  # forgotten when passed by this much


class Standing(NamedTuple):
    station_m: float
    side_m: float
    radius_m: float


class Moving(NamedTuple):
    station_m: float
    side_m: float
    radius_m: float
    along_m_s: float  # along the road
    across_m_s: float  # towards the oncoming lane
    is_vehicle: bool


@dataclass(frozen=True, slots=True)
class Memory:
    """Standing things by the tracker's number, and when they were seen last (vehicle clock)."""

    things: Mapping[int, tuple[Standing, int]]

    @property
    def standing(self) -> tuple[Standing, ...]:
        return tuple(thing for thing, _ in self.things.values())


def is_standing(thing: TrackedObject) -> bool:
    return thing.kind in FURNITURE or (thing.static and thing.kind != "person")


def remembered(memory: Memory, scene: Scene, road: Road, station_m: float) -> Memory:
    """With what the scene shows standing; what was passed, or is gone from plain view, is forgotten."""
    kept = {number: item for number, item in memory.things.items() if not _is_gone(item, scene.stamp_ns, station_m)}
    for thing in scene.objects:
        if is_standing(thing) and thing.age_s >= AGE_MIN_S:
            at = road.to_road(thing.x_m, thing.y_m, station_m)
            kept[thing.number] = (Standing(at.station_m, -road.own_side * at.offset_m, thing.radius_m), scene.stamp_ns)
    return Memory(kept)


def movers(scene: Scene, road: Road, station_m: float) -> tuple[Moving, ...]:
    return tuple(_moving(thing, road, station_m) for thing in scene.objects if not is_standing(thing))


def _is_gone(item: tuple[Standing, int], now_ns: int, station_m: float) -> bool:
    thing, seen_ns = item
    ahead = thing.station_m - station_m
    hidden = now_ns - seen_ns > FORGET_AFTER_NS and PLAIN_VIEW_M[0] < ahead < PLAIN_VIEW_M[1]
    return hidden or ahead < -BEHIND_M


def _moving(thing: TrackedObject, road: Road, station_m: float) -> Moving:
    at = road.to_road(thing.x_m, thing.y_m, station_m)
    c, s = cos(at.heading_rad), sin(at.heading_rad)
    vx, vy = thing.velocity_x_m_s, thing.velocity_y_m_s
    return Moving(
        at.station_m,
        -road.own_side * at.offset_m,
        thing.radius_m,
        vx * c + vy * s,
        -road.own_side * (vy * c - vx * s),
        thing.kind == "vehicle",
    )
