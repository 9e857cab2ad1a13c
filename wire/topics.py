"""The one topic table: key, type, rate, who may publish, who may read, how it travels, whether it is recorded.

Everything else is derived from it: subscriptions, access control at both hubs (`wire.access`), what the recorder writes.
A level is a state: the newest counts and a lost one heals. An event counts each time and is never put in a one-slot `Latest`.
"""

from dataclasses import dataclass
from enum import StrEnum

from wire.messages import audit, automation, health, operating, sensing, session, steps, vehicle
from wire.messages.base import Message


class Role(StrEnum):
    """Who a process is: the common name of its certificate."""

    VEHICLE_HUB = "vehicle-hub"
    VIDEO = "video"
    SIMULATE = "simulate"
    AUTONOMY = "autonomy"
    RECORDER = "recorder"
    TOWER_HUB = "tower-hub"  # a person's device
    TOWER_SCRIPT = "tower-script"  # the scripted operator; a real car refuses it
    WINDOW = "window"
    CAR_OBSERVER = "car-observer"  # looks on at the car's hub (`vehicle-gateway status`, the demo's supervisor)
    TOWER_SUPERVISOR = "tower-supervisor"  # a person above the operators: takes a lease away, releases a car; never drives
    TOWER_OBSERVER = "tower-observer"  # looks on at the tower's hub: sees what the window is told, sends nothing


PROGRAMS: dict[Role, str] = {  # the command that a role's process is: how it names itself in its health and its log
    Role.VEHICLE_HUB: "vehicle-gateway run",
    Role.VIDEO: "vehicle-gateway video",
    Role.SIMULATE: "vehicle-gateway simulate",
    Role.AUTONOMY: "autonomy run",
    Role.RECORDER: "recordings record",
    Role.TOWER_HUB: "tower cockpit",
    Role.TOWER_SCRIPT: "tower cockpit",
    Role.WINDOW: "tower window",
    Role.CAR_OBSERVER: "tower demo",
    Role.TOWER_OBSERVER: "tower observer",
    Role.TOWER_SUPERVISOR: "tower supervise",
}
ECU = "vehicle-gateway ecu"  # has no role: it is on CAN alone, and the gateway passes its health on
CAR = frozenset({Role.VEHICLE_HUB, Role.VIDEO, Role.SIMULATE, Role.AUTONOMY, Role.RECORDER, Role.CAR_OBSERVER})
TOWER = frozenset({Role.TOWER_HUB, Role.TOWER_SCRIPT, Role.WINDOW, Role.TOWER_OBSERVER, Role.TOWER_SUPERVISOR})
COCKPITS = frozenset({Role.TOWER_HUB, Role.TOWER_SCRIPT})
SCREENS = frozenset({Role.WINDOW, Role.TOWER_OBSERVER})
STATE_SEERS = SCREENS | {Role.TOWER_SUPERVISOR}  # what the car does and who holds it, without what is on the road


def certificate_names(role: Role, vehicle_id: str) -> tuple[str, ...]:
    """The common names under which a role may come for one vehicle: what was issued for this car speaks for no other.

    The bare name of a car's role exists only beside the authority itself, which could issue any.
    """
    return (str(role), f"{role}.{vehicle_id}") if role in CAR else (str(role),)


def role_of(common_name: str) -> Role | None:
    """The role that a certificate of this name may come as; None for a name that is none of ours."""
    bare = common_name.partition("~")[0].partition(".")[0]
    return Role(bare) if bare in list(Role) else None


def owner_of(common_name: str) -> str:
    """Whose own certificate a tower's is: "ann" of tower-hub.ann; "" of one that everybody at that tower uses."""
    return common_name.partition("~")[0].partition(".")[2]


class Travel(StrEnum):
    """Priority, reliability and congestion as one choice; BLOCK and DROP never share a priority (zenoh #2584)."""

    COMMAND = "command"  # REAL_TIME, best effort (a QUIC datagram), drop: late is worse than lost
    STATE = "state"  # INTERACTIVE_HIGH, best effort, drop
    BULK = "bulk"  # DATA, reliable, drop: larger than a datagram, or wanted whole in the recording
    RECORD = "record"  # DATA_LOW, reliable, block: for a thread that may wait, so that the recording is whole
    EVENT = "event"  # INTERACTIVE_LOW, reliable, block: every one counts


class Kind(StrEnum):
    LEVEL = "level"
    EVENT = "event"


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    name: str
    type: type[Message] | None  # None: bytes as wire.picture defines them
    rate_hz: float  # nominal; 0: on change
    publishers: frozenset[Role]
    readers: frozenset[Role]
    travel: Travel
    kind: Kind = Kind.LEVEL
    recorded: bool = True

    @property
    def origin_is_car(self) -> bool:
        return self.publishers <= CAR

    @property
    def crosses_link(self) -> bool:
        """Whether somebody on the other site reads it. The recorder sits in the car, so recorded tower topics cross."""
        other = TOWER if self.origin_is_car else CAR
        return bool(self.readers & other)


def _topic(
    name: str,
    type_: type[Message] | None,
    rate_hz: float,
    publishers: frozenset[Role] | set[Role] | Role,
    readers: frozenset[Role] | set[Role],
    travel: Travel,
    kind: Kind = Kind.LEVEL,
    recorded: bool = True,
) -> Topic:
    speakers = frozenset({publishers}) if isinstance(publishers, Role) else frozenset(publishers)
    listeners = frozenset(readers) | ({Role.RECORDER} if recorded else set())
    return Topic(
        name=name,
        type=type_,
        rate_hz=rate_hz,
        publishers=speakers,
        readers=listeners,
        travel=travel,
        kind=kind,
        recorded=recorded,
    )


R, T, K = Role, Travel, Kind
TOPICS: dict[str, Topic] = {
    topic.name: topic
    for topic in (
        # tower -> car
        _topic("drive_command", operating.DriveCommand, 100, COCKPITS, {R.VEHICLE_HUB}, T.COMMAND),
        _topic("tower_stop", operating.TowerStop, 0, COCKPITS, {R.VEHICLE_HUB}, T.EVENT, K.EVENT),
        _topic("operator_status", operating.OperatorStatus, 20, COCKPITS, SCREENS, T.STATE),
        _topic("window_status", operating.WindowStatus, 30, R.WINDOW, COCKPITS | {R.TOWER_OBSERVER}, T.STATE),
        _topic("operator_input", operating.OperatorInput, 60, R.WINDOW, COCKPITS, T.COMMAND, recorded=False),
        _topic("torque_steps", steps.TorqueSteps, 10, COCKPITS, set(), T.BULK, K.EVENT),
        _topic("clock_ping", operating.ClockPing, 5, COCKPITS, {R.VEHICLE_HUB}, T.COMMAND, recorded=False),
        # car -> tower
        _topic("clock_pong", operating.ClockPong, 5, R.VEHICLE_HUB, COCKPITS, T.COMMAND, recorded=False),
        _topic(
            "vehicle_state", vehicle.VehicleState, 50, R.VEHICLE_HUB, COCKPITS | STATE_SEERS | {R.VIDEO, R.CAR_OBSERVER}, T.COMMAND
        ),
        _topic(
            "gateway_status",
            vehicle.GatewayStatus,
            20,
            R.VEHICLE_HUB,
            COCKPITS | STATE_SEERS | {R.AUTONOMY, R.VIDEO, R.CAR_OBSERVER},
            T.STATE,
        ),
        _topic("vehicle_description", vehicle.VehicleDescription, 1, R.VEHICLE_HUB, COCKPITS | SCREENS, T.BULK),
        _topic("autonomy_status", automation.AutonomyStatus, 20, R.AUTONOMY, {R.VEHICLE_HUB} | SCREENS, T.STATE),
        _topic("scene", automation.Scene, 10, R.AUTONOMY, {R.VEHICLE_HUB} | SCREENS | COCKPITS, T.BULK),
        _topic("planner_view", automation.PlannerView, 10, R.AUTONOMY, SCREENS, T.BULK),
        _topic("road_map", automation.RoadMap, 1, R.AUTONOMY, SCREENS | COCKPITS, T.BULK),
        _topic("camera_status", sensing.CameraStatus, 5, R.VIDEO, {R.VEHICLE_HUB, R.CAR_OBSERVER}, T.STATE),
        # inside the car
        _topic("autonomy_command", automation.AutonomyCommand, 100, R.AUTONOMY, {R.VEHICLE_HUB}, T.COMMAND),
        _topic("imu", sensing.Imu, 100, R.SIMULATE, {R.AUTONOMY}, T.STATE),
        _topic("gnss", sensing.Gnss, 10, R.SIMULATE, {R.AUTONOMY}, T.STATE),
        _topic("wheel_speeds", sensing.WheelSpeeds, 50, R.SIMULATE, {R.AUTONOMY}, T.STATE),
        _topic("object_list", sensing.ObjectList, 10, R.SIMULATE, {R.AUTONOMY}, T.BULK),
        _topic("gateway_cycle", vehicle.GatewayCycle, 100, R.VEHICLE_HUB, set(), T.RECORD, K.EVENT),
        _topic("audit", audit.AuditRecord, 0, R.VEHICLE_HUB, set(), T.RECORD, K.EVENT),
        _topic("monitor_step", steps.MonitorStep, 10, R.AUTONOMY, set(), T.BULK, K.EVENT),
        _topic("video", None, 30, R.VIDEO, set(), T.BULK, K.EVENT),
        _topic("played_video", None, 30, R.VEHICLE_HUB, {R.VIDEO}, T.BULK, K.EVENT, recorded=False),  # a recording, played
        _topic("world_state", sensing.WorldState, 54, R.SIMULATE, {R.VIDEO}, T.STATE, recorded=False),
        _topic("referee", sensing.Referee, 10, R.SIMULATE, {R.CAR_OBSERVER}, T.STATE),
        # both sites
        _topic("car_health", health.LoopHealth, 1, CAR, {R.VIDEO, R.CAR_OBSERVER}, T.STATE, K.EVENT),
        _topic("tower_health", health.LoopHealth, 1, COCKPITS | {R.WINDOW}, {R.CAR_OBSERVER}, T.STATE, K.EVENT),
    )
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Query:
    name: str
    request: type[Message]
    reply: type[Message]
    server: Role
    askers: frozenset[Role]


QUERIES: dict[str, Query] = {
    query.name: query
    for query in (
        Query(name="lease", request=session.LeaseRequest, reply=session.LeaseReply, server=R.VEHICLE_HUB, askers=COCKPITS),
        Query(
            name="hand_over",
            request=session.HandOverRequest,
            reply=session.HandOverReply,
            server=R.VEHICLE_HUB,
            askers=COCKPITS,
        ),
        Query(
            name="supervision",
            request=session.SupervisionRequest,
            reply=session.SupervisionReply,
            server=R.VEHICLE_HUB,
            askers=frozenset({R.TOWER_SUPERVISOR}),
        ),
        Query(
            name="video_session",
            request=session.VideoOffer,
            reply=session.VideoAnswer,
            server=R.VIDEO,
            askers=frozenset({R.WINDOW}),
        ),
    )
}


def key(vehicle_id: str, name: str) -> str:
    """The Zenoh key of a topic or query of one vehicle."""
    return f"rot/{vehicle_id}/{name}"
