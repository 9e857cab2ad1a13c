"""Geofence, speed zones and no-stop zones of the gateway's own map, as bounds for the gate. Pure.

A zone is a strip along the road, so everything is reckoned in stations and offsets: how far the car's leading end is from a
zone, how far it may go on before its outline leaves the allowed strips. Each bound is the speed from which comfortable braking
still keeps the rule; nothing here steers, and a car that cannot stop before a no-stop zone any more does not stop in it.
Without a place there is walking pace, wherever the map has zones.
"""

from collections.abc import Iterator
from math import cos, sin, sqrt
from typing import Annotated, NamedTuple

from msgspec import Meta, Struct

from vehicle_gateway.gate import Bound
from vehicle_gateway.guard import Motion
from vehicle_gateway.safe_stop import speed_for_distance_m_s, stopping_distance_m
from wire.messages.automation import Zone, ZoneKind
from wire.messages.base import Message
from wire.road import Road

FENCE, SPEED, NO_STOP, LOST = "geofence", "speed zone", "no-stop zone", "place unknown"
STEP_M, STEPS_MAX = 2.5, 12  # 30 m ahead: from 40 km/h a stop with the firm braking below takes 29 m
FASTER_M_S = 1.5  # so much faster the car may become before the fence is seen
SETTLES_S = 0.2  # ours: how fast the speed follows a bound; below half of `reaction_s` it does not overshoot


class ZoneLimits(Message):
    comfortable_m_s2: Annotated[float, Meta(ge=0.3, le=4.0)] = 1.0  # Autoware "comfortable": before a speed zone
    firm_m_s2: Annotated[float, Meta(ge=0.5, le=4.0)] = 2.5  # Autoware "emergency": before the fence and a no-stop zone
    jerk_m_s3: Annotated[float, Meta(ge=0.5, le=20.0)] = 5.0  # as the safe stop
    reaction_s: Annotated[float, Meta(ge=0.4, le=1.0)] = 0.5  # ours: a cycle, CAN, the brakes, and the bound above
    margin_m: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.5  # ours: what is left before an edge
    exit_m: Annotated[float, Meta(ge=0.0, le=20.0)] = 1.0  # ours: free behind a no-stop zone, besides the car's length
    walking_m_s: Annotated[float, Meta(ge=0.3, le=2.0)] = 5 / 3.6
    side_picture_old_ms: Annotated[float, Meta(ge=300.0, le=5000.0)] = (
        1000.0  # ours: 450 ms between pictures of a camera that gives way (a sixth of 13.5 Hz), 500 ms of the slowest loop
    )
    too_late_m_s2: Annotated[float, Meta(ge=1.0, le=8.0)] = 4.0  # UN R157: who would have to brake harder goes on


class OnRoad(Struct, frozen=True):
    """The car in the coordinates of its map's road."""

    station_m: float  # of the rear axle
    offset_m: float
    heading_rad: float  # of the way it drives, against the road's own direction
    turning_1_m: float  # curvature of the way it drives, left positive
    deviation_m: float

    @property
    def direction(self) -> float:
        """1.0: drives towards greater stations, -1.0: towards smaller ones."""
        return 1.0 if cos(self.heading_rad) >= 0.0 else -1.0


class Stretch(NamedTuple):
    """A part of the road, for what stands behind a zone."""

    from_m: float
    to_m: float
    right_m: float
    left_m: float


def leading_m(at: OnRoad, motion: Motion) -> float:
    """Station of the end of the car that leads."""
    return at.station_m + at.direction * motion.front_m


def gap_m(zone: Zone, at: OnRoad, motion: Motion) -> float:
    """From the leading end to the edge of the zone it meets first; negative inside and behind."""
    front = leading_m(at, motion)
    return zone.from_station_m - front if at.direction > 0.0 else front - zone.to_station_m


def is_behind(zone: Zone, at: OnRoad, motion: Motion) -> bool:
    """The whole car has left it."""
    back = at.station_m - at.direction * motion.rear_m
    return back > zone.to_station_m if at.direction > 0.0 else back < zone.from_station_m


def overlaps(zone: Zone, at: OnRoad, motion: Motion) -> bool:
    """Whether the car's present strip of the road runs through the zone."""
    return at.offset_m - motion.half_width_m < zone.left_m and at.offset_m + motion.half_width_m > zone.right_m


def is_inside(zone: Zone, at: OnRoad, motion: Motion) -> bool:
    return overlaps(zone, at, motion) and gap_m(zone, at, motion) < 0.0 and not is_behind(zone, at, motion)


def bounds_of(
    zones: tuple[Zone, ...],
    road: Road,
    at: OnRoad | None,
    motion: Motion,
    may_enter: bool,
    soft_fault: bool,
    limits: ZoneLimits,
) -> tuple[Bound, ...]:
    """What the zones allow here.

    at          None: nobody knows where the car is
    may_enter   the link is healthy and behind the next no-stop zone there is room for the whole car
    soft_fault  the link is slow, or a side camera old: what is inside a no-stop zone leaves it at walking pace
    """
    if not zones:
        return ()
    if at is None:
        walk_m_s2 = (limits.walking_m_s - motion.speed_m_s) / SETTLES_S
        return (Bound(LOST, max(walk_m_s2, -limits.comfortable_m_s2)),)  # gently: the next scene may tell where we are
    rules = {ZoneKind.SPEED: _speed_m_s, ZoneKind.NO_STOP: _no_stop_m_s}
    bounds = [
        _bound(SPEED if zone.kind is ZoneKind.SPEED else NO_STOP, most, motion, limits)
        for zone in zones
        if zone.kind in rules and overlaps(zone, at, motion) and not is_behind(zone, at, motion)
        if (most := rules[zone.kind](zone, at, motion, may_enter, soft_fault, limits)) is not None
    ]
    allowed = [zone for zone in zones if zone.kind is ZoneKind.ALLOWED]
    if allowed:
        bounds.append(_bound(FENCE, _fence_m_s(allowed, road, at, motion, limits), motion, limits))
    return tuple(bounds)


def _bound(rule: str, most_m_s: float, motion: Motion, limits: ZoneLimits) -> Bound:
    return Bound(rule, max((most_m_s - motion.speed_m_s) / SETTLES_S, -limits.too_late_m_s2))


def _speed_m_s(zone: Zone, at: OnRoad, motion: Motion, _: bool, __: bool, limits: ZoneLimits) -> float | None:
    """Falls before the zone, so that its limit holds at its edge."""
    inside_m_s = limits.walking_m_s if zone.speed_m_s is None else zone.speed_m_s
    room = gap_m(zone, at, motion) - at.deviation_m - limits.margin_m - motion.speed_m_s * SETTLES_S
    return sqrt(inside_m_s**2 + 2 * limits.comfortable_m_s2 * max(room, 0.0))


def _no_stop_m_s(zone: Zone, at: OnRoad, motion: Motion, may_enter: bool, soft_fault: bool, limits: ZoneLimits) -> float | None:
    """Before it, unless it may be entered: a stop. Inside: no bound, with a soft fault walking pace."""
    room = gap_m(zone, at, motion)
    if room < 0.0:
        return limits.walking_m_s if soft_fault else None
    needed = motion.speed_m_s**2 / (2 * max(room, 0.01))
    if may_enter or (motion.speed_m_s > limits.walking_m_s and needed > limits.too_late_m_s2):
        return None  # whoever cannot stop before it any more does not stop in it
    return _stops_within(room - limits.margin_m - at.deviation_m, limits)


def _fence_m_s(allowed: list[Zone], road: Road, at: OnRoad, motion: Motion, limits: ZoneLimits) -> float:
    """The speed from which the car stops inside; outside, walking pace: somebody has to bring it back."""
    looked_m = stopping_distance_m(motion.speed_m_s + FASTER_M_S, limits.reaction_s, limits.firm_m_s2, limits.jerk_m_s3)
    steps = min(int((looked_m + limits.margin_m + at.deviation_m) / STEP_M) + 1, STEPS_MAX)
    room = allowed_m(allowed, road, at, motion, steps)
    return limits.walking_m_s if room is None else _stops_within(room - limits.margin_m - at.deviation_m, limits)


def _stops_within(room_m: float, limits: ZoneLimits) -> float:
    return speed_for_distance_m_s(room_m, limits.reaction_s, limits.firm_m_s2, limits.jerk_m_s3)


def allowed_m(allowed: list[Zone], road: Road, at: OnRoad, motion: Motion, steps: int = STEPS_MAX) -> float | None:
    """How far the car may go on along its arc until its leading end leaves the allowed strips; None: it is outside already."""
    before_m = None
    for number, (station, offset) in enumerate(leading_end(road, at, motion, steps)):
        now_m = min([outside_m(zone, station, offset, motion) for zone in allowed])
        if now_m > 0.0:
            return None if before_m is None else STEP_M * (number - 1 + before_m / (before_m - now_m))
        before_m = now_m
    return STEP_M * steps


def outside_m(zone: Zone, station_m: float, offset_m: float, motion: Motion) -> float:
    """By how much the leading end is outside the strip; negative inside."""
    half = motion.half_width_m
    return max(
        zone.from_station_m - station_m,
        station_m - zone.to_station_m,
        zone.right_m - offset_m + half,
        offset_m + half - zone.left_m,
    )


def leading_end(road: Road, at: OnRoad, motion: Motion, steps: int) -> Iterator[tuple[float, float]]:
    """Station and offset of the leading end's middle, every STEP_M along the arc, the road's own bends taken into account."""
    station, offset, heading, front = at.station_m, at.offset_m, at.heading_rad, motion.front_m
    for _ in range(steps + 1):
        bend, c, s = road.curvature_1_m(station), cos(heading), sin(heading)
        yield station + c * front, offset + s * front - bend * (c * front) ** 2 / 2
        turned = (at.turning_1_m - bend * c) * STEP_M
        middle = heading + turned / 2
        station, offset, heading = station + cos(middle) * STEP_M, offset + sin(middle) * STEP_M, heading + turned


def exit_of(zone: Zone, at: OnRoad, motion: Motion, limits: ZoneLimits) -> Stretch:
    """The road behind the zone that the whole car needs, where it drives now."""
    need = motion.front_m + motion.rear_m + limits.exit_m
    low = zone.from_station_m if at.direction > 0.0 else zone.from_station_m - need
    high = zone.to_station_m + need if at.direction > 0.0 else zone.to_station_m
    return Stretch(low, high, at.offset_m - motion.half_width_m, at.offset_m + motion.half_width_m)
