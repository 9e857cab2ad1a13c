"""The plan, 10 Hz: drive the own lane to the goal and stop in time for whoever is or will be in the way. Pure.

Comfortable braking by rule, firm when somebody steps out, the brakes' limit only where nothing less avoids a person. It
never uses the oncoming lane and never overtakes; inside the own lane it makes room for a static thing that leaves some.
Decelerations: near Autoware's comfortable (1.0) and moderate (1.5 m/s2) stops; UN R157 caps a planned stop at 4 m/s2.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import cos, inf, sin
from typing import Annotated

from msgspec import Meta

from autonomy.car_shape import CarShape
from autonomy.perception.prediction import OnRoad, on_road
from autonomy.perception.tracking import Track
from autonomy.planning.blockage import Blockage, closed_by, in_lane, lateral_room
from autonomy.planning.occupancy import Occupancy, occupancy
from autonomy.planning.route import Lane, Shift, bend_caps, own_lane, path_points
from autonomy.planning.speed_limits import SpeedCap, StopPoint, driving_time_s
from wire.messages.base import Message, Point
from wire.road import Pose, Road

Metres = Annotated[float, Meta(ge=0.0, le=200.0)]
Positive = Annotated[float, Meta(gt=0.0, le=10.0)]
BESIDE_SPEED_M_S = 1.0  # slower than this the car waits for somebody right beside it
PASSING_LEAST_M_S = 2.0
STANDS_M_S = 0.1  # slower: it stands
PASSING_TIME_S = 1.0  # between the car's rear and a person who comes, when the car could as well stop
PASSING_TIME_LEAST_S = 0.1  # when only firm braking could still stop it
TIGHT_SIDE_M = 0.1  # beside the car's body: no comfort, no contact
HORIZON_S = 60.0


class PlanningSettings(Message):
    acceleration_m_s2: Positive = 1.2
    comfort_m_s2: Positive = 1.2
    moderate_m_s2: Positive = 2.0  # above this the larger distance to a person is given up first
    firm_m_s2: Positive = 4.0  # planned at most
    emergency_m_s2: Positive = 7.0  # only when firm would still hit a person
    lateral_m_s2: Positive = 1.5  # in bends
    look_ahead_m: Metres = 90.0
    person_side_m: Metres = 0.5  # free on each side of the car for people
    person_gap_m: Metres = 2.5  # bumper to person at standstill, when there is time
    person_gap_least_m: Metres = 1.2
    static_side_m: Metres = 0.3
    static_gap_m: Metres = 7.0  # bumper to a closed lane at standstill: room to drive around it
    pass_slowly_m: Metres = 0.6  # a person nearer to the car's side is passed at 2 m/s
    pass_freely_m: Metres = 1.5  # farther: at the speed limit; between, in proportion


@dataclass(frozen=True, slots=True, kw_only=True)
class Plan:
    stamp_ns: int
    station_m: float  # of the car when planned
    shift: Shift
    stops: tuple[StopPoint, ...]
    caps: tuple[SpeedCap, ...]
    blocked: Blockage | None  # what stops the car: a closed lane or, when none, the nearest person waited for
    waited_for: frozenset[int]  # track numbers of everybody it would brake for
    in_lane: tuple[OnRoad, ...]  # every static thing in the own lane ahead, nearest first
    static: tuple[OnRoad, ...]
    drivable_s: float
    points: tuple[Point, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """Where the car is on the road, and what else is there."""

    now_ns: int
    road: Road
    shape: CarShape
    station_m: float
    speed_m_s: float
    tracks: tuple[Track, ...]  # confirmed
    slowing: StopPoint | None = None  # of an open take-over request
    pose: Pose | None = None  # of the rear axle; None: in the middle of its lane, along it


def plan(situation: Situation, previous: Plan | None, settings: PlanningSettings) -> Plan:
    road, shape, station = situation.road, situation.shape, situation.station_m
    lane = own_lane(road)
    things = [on_road(track, road, station) for track in situation.tracks]
    static = tuple(thing for thing in things if thing.track.static and thing.track.kind != "person")
    ahead = in_lane(static, lane, station - shape.rear_m, station + shape.front_m + settings.look_ahead_m)
    closed = closed_by(ahead, lane, shape.half_width_m, settings.static_side_m)
    shift = _shift(ahead, lane, situation, previous, settings)
    standing = [StopPoint(road.map.goal_station_m, settings.comfort_m_s2, "goal"), *_closed_stops(closed, situation, settings)]
    bends = bend_caps(road, lane.middle_m, settings.lateral_m_s2)
    movers = [thing for thing in things if thing not in static]
    inside = [thing for thing in movers if _is_inside(thing.track, situation)]
    stays = [(thing, _stay(thing, lane, situation, settings.person_side_m)) for thing in movers if thing not in inside]
    waits = [(_stop_at_once(thing, situation, previous, settings), thing) for thing in inside]
    waits += [(stop, thing) for thing, stay in stays for stop in _person_stops(thing, stay, lane, situation, previous, settings)]
    passing = tuple(
        cap for thing, stay in stays if stay is None for cap in _passing_caps(thing, lane.middle_m, situation, settings)
    )
    slowing = () if situation.slowing is None else (situation.slowing,)
    drivable = driving_time_s(
        station,
        situation.speed_m_s,
        settings.acceleration_m_s2,
        road.map.speed_limit_m_s,
        settings.comfort_m_s2,
        standing,
        bends,
        HORIZON_S,
    )
    return Plan(
        stamp_ns=situation.now_ns,
        station_m=station,
        shift=shift,
        stops=(*standing, *slowing, *(stop for stop, _ in waits)),
        caps=(*bends, *passing),
        blocked=closed or _waiting_for(waits),
        waited_for=frozenset(thing.track.number for _, thing in waits),
        in_lane=tuple(ahead),
        static=static,
        drivable_s=drivable if closed else max(drivable, 10.0),  # to the goal is as good as ten seconds
        points=path_points(road, lane, shift, station, min(station + 50.0, road.map.goal_station_m), 2.0),
    )


def _shift(ahead: Sequence[OnRoad], lane: Lane, situation: Situation, previous: Plan | None, settings: PlanningSettings) -> Shift:
    """Make room inside the lane for what stands within the next 40 m; back to its middle afterwards."""
    near = [thing for thing in ahead if thing.station_m < situation.station_m + 40.0]
    target = lateral_room(near, lane, situation.shape.half_width_m, settings.static_side_m)
    wanted = 0.0 if target is None else target
    if previous is None:
        return Shift(situation.station_m, wanted, wanted)
    if previous.shift.end_m == wanted:
        return previous.shift
    return Shift(situation.station_m, previous.shift.at(situation.station_m), wanted)


def _closed_stops(closed: Blockage | None, situation: Situation, settings: PlanningSettings) -> tuple[StopPoint, ...]:
    if closed is None:
        return ()
    station = closed.station_m - situation.shape.front_m - settings.static_gap_m
    distance = station - situation.station_m
    needed = _needed(situation.speed_m_s, distance)
    if needed > settings.moderate_m_s2:  # seen late: half the distance will do
        station += settings.static_gap_m / 2
        needed = max(_needed(situation.speed_m_s, station - situation.station_m), settings.moderate_m_s2)
    return (StopPoint(station, min(max(needed, settings.comfort_m_s2), settings.firm_m_s2), "static"),)


def _stay(thing: OnRoad, lane: Lane, situation: Situation, side_m: float) -> Occupancy | None:
    half = situation.shape.half_width_m + side_m
    return occupancy(thing, lane.middle_m - half, lane.middle_m + half, situation.road.half_width_m)


def _is_inside(track: Track, situation: Situation) -> bool:
    """Whether its middle is reported inside the car's outline: no way past somebody comes so near."""
    road, shape = situation.road, situation.shape
    x, y, heading = situation.pose or road.to_world(situation.station_m, own_lane(road).middle_m)
    dx, dy, c, s = track.x_m - x, track.y_m - y, cos(heading), sin(heading)
    return -shape.rear_m < dx * c + dy * s < shape.front_m and abs(dy * c - dx * s) < shape.half_width_m


def _stop_at_once(thing: OnRoad, situation: Situation, previous: Plan | None, settings: PlanningSettings) -> StopPoint:
    """They are never taken to be passed: the car does not roll on over somebody. Firmly at most: no braking avoids them any more,
    and it may be a ghost, which the gateway's guard takes it for.
    """
    waited = previous is not None and thing.track.number in previous.waited_for
    stands = situation.speed_m_s < STANDS_M_S
    deceleration = settings.comfort_m_s2 if stands else settings.firm_m_s2 if waited else settings.moderate_m_s2
    return StopPoint(situation.station_m, deceleration, "standing" if thing.track.static else "person")


def _person_stops(
    thing: OnRoad, stay: Occupancy | None, lane: Lane, situation: Situation, previous: Plan | None, settings: PlanningSettings
) -> tuple[StopPoint, ...]:
    if stay is None or stay.near_station_m > situation.station_m + settings.look_ahead_m:
        return ()
    if _passed_before(stay, situation, settings) or _gone_before(stay, situation, settings):
        return ()
    gap = stay.near_station_m - situation.station_m - situation.shape.front_m
    distance, deceleration = _person_braking(gap, situation.speed_m_s, settings)
    if deceleration > settings.firm_m_s2 and _clears(_stay(thing, lane, situation, TIGHT_SIDE_M), situation):
        return ()  # braking now would stop the car in the person's way
    if previous is None or thing.track.number not in previous.waited_for:
        deceleration = min(deceleration, settings.moderate_m_s2)  # one plan's breath of noise is no emergency
    cause = "standing" if thing.track.static else "person"
    return (StopPoint(situation.station_m + distance, deceleration, cause),)


def _clears(tight: Occupancy | None, situation: Situation) -> bool:
    """Whether the car as fast as it is leaves the way of a person before they are in it, if only just."""
    if tight is None:
        return False
    to_rear = tight.far_station_m + situation.shape.rear_m - situation.station_m
    return situation.speed_m_s > 2.0 and to_rear / situation.speed_m_s < tight.from_s


def _passed_before(stay: Occupancy, situation: Situation, settings: PlanningSettings) -> bool:
    """Whether the car is past before the stay begins: already beside it and rolling, or surely faster.

    The time that has to lie between shrinks as stopping becomes hard: a decision to pass is not taken back when too late.
    """
    shape, speed = situation.shape, situation.speed_m_s
    to_rear = stay.far_station_m + shape.rear_m + 0.5 - situation.station_m
    if to_rear < 0.0:
        return True
    if stay.far_station_m < situation.station_m + shape.front_m - 0.3 and speed > BESIDE_SPEED_M_S:
        return True
    gap = stay.near_station_m - situation.station_m - shape.front_m - settings.person_gap_least_m
    hard = (_needed(speed, gap) - settings.moderate_m_s2) / (settings.firm_m_s2 - settings.moderate_m_s2)
    between_s = PASSING_TIME_S - (PASSING_TIME_S - PASSING_TIME_LEAST_S) * min(max(hard, 0.0), 1.0)
    return speed > 2.0 and to_rear / speed + between_s < stay.from_s


def _gone_before(stay: Occupancy, situation: Situation, settings: PlanningSettings) -> bool:
    """Whether the way is free again before a car at the speed limit could be there."""
    gap = stay.near_station_m - situation.station_m - situation.shape.front_m - settings.person_gap_m
    return gap / situation.road.map.speed_limit_m_s > stay.until_s + 0.5


def _person_braking(gap_m: float, speed_m_s: float, settings: PlanningSettings) -> tuple[float, float]:
    """(distance to standstill, deceleration): comfortably with the large gap, else firmly with the least one."""
    needed = _needed(speed_m_s, gap_m - settings.person_gap_m)
    if needed <= settings.moderate_m_s2:
        return max(gap_m - settings.person_gap_m, 0.0), max(needed, settings.comfort_m_s2)
    distance = max(gap_m - settings.person_gap_least_m, 0.0)
    needed = max(_needed(speed_m_s, distance), settings.moderate_m_s2)
    if needed <= settings.firm_m_s2:
        return distance, needed
    avoids = _needed(speed_m_s, gap_m - 0.3) <= settings.firm_m_s2
    return distance, settings.firm_m_s2 if avoids else settings.emergency_m_s2


def _needed(speed_m_s: float, distance_m: float) -> float:
    """Deceleration to standstill within a distance; standing, none is needed however near it is."""
    if speed_m_s < STANDS_M_S:
        return 0.0
    return speed_m_s**2 / (2 * distance_m) if distance_m > 0.05 else inf


def _passing_caps(thing: OnRoad, middle_m: float, situation: Situation, settings: PlanningSettings) -> tuple[SpeedCap, ...]:
    """Slower past a person close beside the way, who does not cross it (slowing for one who does only spends the time)."""
    shape, radius = situation.shape, thing.track.radius_m
    beside = abs(thing.offset_m - middle_m) - shape.half_width_m - radius
    share = (beside - settings.pass_slowly_m) / (settings.pass_freely_m - settings.pass_slowly_m)
    if share >= 1.0 or thing.station_m + radius < situation.station_m - shape.rear_m:
        return ()
    limit = situation.road.map.speed_limit_m_s
    speed = min(PASSING_LEAST_M_S + max(share, 0.0) * (limit - PASSING_LEAST_M_S), limit)
    return (SpeedCap(thing.station_m - radius - shape.front_m - 1.0, thing.station_m + radius + shape.rear_m, speed),)


def _waiting_for(waits: Sequence[tuple[StopPoint, OnRoad]]) -> Blockage | None:
    if not waits:
        return None
    stop, thing = min(waits, key=lambda wait: wait[0].station_m)
    return Blockage(
        station_m=thing.station_m - thing.track.radius_m,
        kind="person",
        numbers=(thing.track.number,),
        place=(thing.track.x_m, thing.track.y_m),
    )
