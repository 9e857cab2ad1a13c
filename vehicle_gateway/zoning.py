"""The zones of the gateway's map around this car: where it is on the road, whether the way out is free, who is slow. Pure.

The geometry is in `zones.py`. The map is part of the limits, so a recording replays with the zones it was driven with.
"""

from math import cos, pi, sin
from typing import NamedTuple

from vehicle_gateway.authority import Source, driving_source
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.gate import Bound
from vehicle_gateway.guard import Motion, motion_of
from vehicle_gateway.guarding import is_backwards
from vehicle_gateway.measure import NEVER_MS
from vehicle_gateway.place import Place, place_of
from vehicle_gateway.remembered import remembered
from vehicle_gateway.state import GatewayLimits, State
from vehicle_gateway.zones import OnRoad, Stretch, bounds_of, exit_of, gap_m, is_behind, is_inside, overlaps
from wire.messages.automation import Zone, ZoneKind
from wire.messages.vehicle import VehicleDescription
from wire.rear_view import REAR
from wire.road import Road, wrap_angle

BEFORE_ROAD_M = -1.0  # ours: a car that begins at station 0 has its tail there
NEXT_M = 30.0  # ours: the exit of a no-stop zone counts from here on
SOFT = (Cause.LOOP_TOO_SLOW,)  # the driver is there and sees, only late: a no-stop zone is left first


road_of = remembered(Road)


class Zoned(NamedTuple):
    bounds: tuple[Bound, ...]
    on_no_stop: bool  # some part of the car is in a no-stop zone


def zones_of(state: State, now_ns: int, vehicle: VehicleDescription, limits: GatewayLimits) -> Zoned:
    """What the zones allow whoever drives; a person in the car is not told."""
    road_map, feedback = limits.map, state.feedback
    if road_map is None or not road_map.zones or feedback is None or driving_source(state.authority) is Source.LOCAL:
        return Zoned((), False)
    backwards = is_backwards(state, feedback.speed_m_s)
    motion = motion_of(feedback.speed_m_s, state.applied.road_wheel_angle_rad, backwards, vehicle)
    road, place = road_of(road_map), place_of(state.fix, state.odometry, now_ns, limits.place)
    at = None if place is None else on_road(road, place, motion.curvature_1_m, backwards)
    no_stop = [zone for zone in road_map.zones if zone.kind is ZoneKind.NO_STOP]
    may_enter = at is None or all(_may_enter(zone, at, motion, road, state, now_ns, vehicle, limits) for zone in no_stop)
    soft = bool(no_stop) and is_softly_faulty(state, vehicle, limits)
    on_no_stop = at is not None and any(is_inside(zone, at, motion) for zone in no_stop)
    return Zoned(bounds_of(road_map.zones, road, at, motion, may_enter, soft, limits.zones), on_no_stop)


def on_road(road: Road, place: Place, curvature_1_m: float, backwards: bool) -> OnRoad:
    """Backwards, the way it drives is turned by half a circle, and what bends to the left bends to its right."""
    station, offset, heading = road.to_road(place.x_m, place.y_m)
    turned = wrap_angle(place.heading_rad - heading + (pi if backwards else 0.0))
    return OnRoad(station, offset, turned, -curvature_1_m if backwards else curvature_1_m, place.deviation_m)


def _may_enter(
    zone: Zone,
    at: OnRoad,
    motion: Motion,
    road: Road,
    state: State,
    now_ns: int,
    vehicle: VehicleDescription,
    limits: GatewayLimits,
) -> bool:
    """A zone that is not next says nothing; the next one asks for a healthy link and room behind it."""
    if is_behind(zone, at, motion) or not overlaps(zone, at, motion) or not 0.0 <= gap_m(zone, at, motion) <= NEXT_M:
        return True
    return is_link_healthy(state, vehicle, limits) and is_exit_clear(zone, at, motion, road, state, now_ns, limits)


def is_link_healthy(state: State, vehicle: VehicleDescription, limits: GatewayLimits) -> bool:
    """Of an operator who drives: commands in time, a loop that is not slow, young pictures to the sides."""
    if driving_source(state.authority) is not Source.OPERATOR:
        return True
    return (
        not state.causes
        and state.loop_ages.p95_ms() <= limits.cap.loop_age_slow_ms
        and side_picture_ms(state, vehicle) <= limits.zones.side_picture_old_ms
    )


def is_softly_faulty(state: State, vehicle: VehicleDescription, limits: GatewayLimits) -> bool:
    """The driver is there and sees the way ahead, only late, or he no longer sees what comes from the side."""
    if any(cause in state.causes for cause in SOFT):
        return True
    driven = driving_source(state.authority) is Source.OPERATOR
    return driven and side_picture_ms(state, vehicle) > limits.zones.side_picture_old_ms


def side_picture_ms(state: State, vehicle: VehicleDescription) -> float:
    """How old the oldest side picture on the operator's screen was, as his last command told; never seen is worst.

    By the time of its capture, so a camera that hangs, one that is lost and one that is far behind are the same. A required
    camera has a rule of its own (`picture_lost`), and the rear one runs only while it is wanted.
    """

    def age_ms(name: str) -> float:
        picture = state.pictures.get(name)
        return NEVER_MS if picture is None else max(state.command_ns - picture.capture_ns, 0) / 1e6

    sides = (camera.name for camera in vehicle.cameras if not camera.required and camera.name != REAR)
    return max(map(age_ms, sides), default=0.0)


def is_exit_clear(zone: Zone, at: OnRoad, motion: Motion, road: Road, state: State, now_ns: int, limits: GatewayLimits) -> bool:
    """Nothing tracked in the zone or behind it, where the car would go; with old evidence nobody knows."""
    if (now_ns - state.around.seen_ns) / 1e6 > limits.guard.age_max_ms:
        return False
    stretch = exit_of(zone, at, motion, limits.zones)
    if not (stretch.from_m >= BEFORE_ROAD_M and stretch.to_m <= road.length_m):  # beyond the map nobody knows
        return False
    x, y, c, s = box_of(stretch, road, state)
    half_length, half_width = (stretch.to_m - stretch.from_m) / 2, (stretch.left_m - stretch.right_m) / 2
    for thing in (*state.around.standing, *state.around.moving):
        dx, dy = thing.x_m - x, thing.y_m - y
        grown = thing.radius_m + thing.deviation_m
        if abs(dx * c + dy * s) < half_length + grown and abs(dy * c - dx * s) < half_width + grown:
            return False
    return True


def box_of(stretch: Stretch, road: Road, state: State) -> tuple[float, float, float, float]:
    """Middle, cosine and sine of the stretch as a straight box in the odometry frame, where the things are kept."""
    fix = state.fix
    x, y, heading = road.to_world((stretch.from_m + stretch.to_m) / 2, (stretch.right_m + stretch.left_m) / 2)
    turn = fix.odometry.heading_rad - fix.heading_rad
    c, s, dx, dy = cos(turn), sin(turn), x - fix.x_m, y - fix.y_m
    along = heading + turn
    return fix.odometry.x_m + dx * c - dy * s, fix.odometry.y_m + dx * s + dy * c, cos(along), sin(along)
