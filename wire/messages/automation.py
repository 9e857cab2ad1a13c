"""What the embedded automated stack says: its command, its doubt, its view of the scene, the map it drives by."""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from wire.messages.base import (
    Angle,
    CommandAcceleration,
    Count,
    Indicators,
    Length,
    Message,
    Name,
    Path,
    Point,
    Position,
    Rate,
    Ratio,
    RoadWheelAngle,
    Seconds,
    Speed,
    Text,
    TimeNs,
)

STOPPING_CORRIDOR_M = 30.0  # length of Scene.stopping_corridor on a free road: a stop from 30 km/h with 1.5 m/s2 takes 23 m


class Reason(Message):
    """One channel of doubt that speaks up."""

    channel: Name  # planner, map, localization, perception, ...
    text: Text  # in words for the operator


class TakeoverRequest(Message):
    number: Count  # counts requests since start of the stack
    raised_ns: TimeNs
    reasons: Annotated[tuple[Reason, ...], Meta(min_length=1, max_length=16)]
    budget_s: Seconds  # from raised_ns; the automation slows so that it ends at standstill
    place: Point  # where the trouble is, map frame


class AutonomyCommand(Message):
    """100 Hz. What the automation would do; the gateway decides whether it may."""

    stamp_ns: TimeNs
    sequence: Count
    road_wheel_angle_rad: RoadWheelAngle
    acceleration_m_s2: CommandAcceleration
    indicators: Indicators = Indicators.OFF


class Evidence(Message):
    channel: Name
    level: Ratio  # 0 no doubt, 1 certain trouble
    high: bool  # after hysteresis
    text: Text


class Doubt(StrEnum):
    NOMINAL = "nominal"
    CAUTION = "caution"
    REQUEST = "request"


class AutonomyStatus(Message):
    """20 Hz level. Health, doubt and whether it could drive now."""

    stamp_ns: TimeNs
    sequence: Count
    healthy: bool  # localized, sensors fresh, plan fresh
    health_note: Text
    doubt: Doubt
    evidence: Annotated[tuple[Evidence, ...], Meta(max_length=32)]
    request: TakeoverRequest | None  # open while doubt is REQUEST
    clear_s: Seconds  # for how long no channel was high (a hand-back needs >= 3 s)
    drivable_s: Seconds  # for how long the present plan is drivable from the present state (needs >= 10 s)
    state_matched: bool  # lateral offset, heading and speed are within what the tracking controller takes over
    match_note: Text
    goal_reached: bool


class TrackedObject(Message):
    number: Count  # the tracker's own identity
    kind: Name  # person, cone, barrier, vehicle, unknown
    x_m: Position
    y_m: Position
    velocity_x_m_s: Speed
    velocity_y_m_s: Speed
    radius_m: Length
    deviation_m: Length  # one standard deviation of the position, larger axis
    static: bool
    age_s: Seconds


class Scene(Message):
    """10 Hz, crosses the link: what the car believes. For the window, the scripted operator and the recording."""

    stamp_ns: TimeNs  # vehicle clock: time the pose is valid for
    x_m: Position  # rear axle, map frame
    y_m: Position
    heading_rad: Angle
    speed_m_s: Speed
    yaw_rate_rad_s: Rate
    deviation_m: Length
    station_m: Length  # along the route
    offset_m: Position  # from the centre line of the road, left positive
    objects: Annotated[tuple[TrackedObject, ...], Meta(max_length=500)]
    plan: Path  # the path the automation would drive, () when it has none
    stopping_corridor: Path  # checked against road edge and objects, from the car on; () when unhealthy


WayPoints = Annotated[tuple[Point, ...], Meta(max_length=100)]  # ours: a horizon has 36
WAYS_MAX = 16  # ours: four classes, one trajectory without guidance, and braking


class PlannedWay(Message):
    """One candidate of the planner among people. Places are of the rear axle, map frame, one for each stage of the horizon."""

    identity: Annotated[int, Meta(ge=-2, le=2**53)]  # of its guidance class; -1 without guidance, -2 braking
    colour: Annotated[int, Meta(ge=0, le=15)]  # number of a class's colour, which it keeps while it is there; 0 for the others
    guidance: WayPoints  # () without one
    trajectory: WayPoints  # () when there is none
    feasible: bool
    chosen: bool


class PredictedPlace(Message):
    """A Gaussian in the map frame."""

    x_m: Position
    y_m: Position
    long_m: Length  # one standard deviation along the longer axis of its ellipse
    wide_m: Length  # and across it
    axis_rad: Angle  # of the longer one, from x


class PredictedPerson(Message):
    """Whom the planner reckoned with, or a thing."""

    number: Count  # the tracker's own
    radius_m: Length
    places: Annotated[tuple[PredictedPlace, ...], Meta(min_length=1, max_length=16)]  # now, and each second; of a thing: now


class PlannerView(Message):
    """10 Hz, crosses the link: what the planner among people thought, to look at; nobody drives by it."""

    stamp_ns: TimeNs  # vehicle clock: time the plan starts from
    people: Annotated[tuple[PredictedPerson, ...], Meta(max_length=64)] = ()
    ways: Annotated[tuple[PlannedWay, ...], Meta(max_length=WAYS_MAX)]


class RoadMap(Message):
    """The map the automation drives by, 1 Hz, and what a map file holds (TOML). See wire.road.Road for the geometry.

    The centre line divides the two directions of traffic. It starts at `start` and runs through `segments`.
    """

    name: Name
    start: Point
    start_heading_rad: Angle
    segments: Annotated[tuple["RoadSegment", ...], Meta(min_length=1, max_length=100)]
    lane_width_m: Annotated[float, Meta(ge=2.0, le=6.0)]
    sidewalk_width_m: Annotated[float, Meta(ge=0.0, le=10.0)]
    drives_on: Annotated[str, Meta(pattern="^(left|right)$")]
    speed_limit_m_s: Annotated[float, Meta(gt=0.0, le=40.0)]
    goal_station_m: Length
    zones: Annotated[tuple["Zone", ...], Meta(max_length=50)] = ()  # for the gateway, whoever drives


class ZoneKind(StrEnum):
    ALLOWED = "allowed"  # the geofence: with one of these the car stays inside them, with none it may go anywhere
    SPEED = "speed"  # no faster than speed_m_s
    NO_STOP = "no_stop"  # level crossing, junction: entered only with a clear exit and a healthy link


class Zone(Message):
    """A strip along the road: from station to station, between two offsets from the centre line."""

    kind: ZoneKind
    name: Name  # for people: "school", "level crossing"
    from_station_m: Length
    to_station_m: Length
    right_m: Annotated[float, Meta(ge=-200.0, le=200.0)]  # offset of its right edge, left positive
    left_m: Annotated[float, Meta(ge=-200.0, le=200.0)]
    speed_m_s: Annotated[float, Meta(ge=0.5, le=40.0)] | None = None  # of a speed zone only


class RoadSegment(Message):
    length_m: Annotated[float, Meta(gt=0.0, le=5000.0)]
    curvature_1_m: Annotated[float, Meta(ge=-0.2, le=0.2)] = 0.0  # left positive, 0 straight
    slope_rad: Annotated[float, Meta(ge=-0.3, le=0.3)] = 0.0  # uphill along the road positive; felt by the car, not drawn
