"""What one gateway cycle works on: its limits, its inputs, its state, its outputs. Structs only, recorded as they are.

Inputs hold only what arrived since the last cycle; the state holds the newest of everything. Recorded inputs, fed again in
order, give the same outputs.
"""

from typing import Annotated

from msgspec import Meta

from vehicle_gateway.actuation import ActuationDelay, ActuationLimits
from vehicle_gateway.authority import Authority
from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.corridor import Corridor, Odometry
from vehicle_gateway.failsafe import Cause, FailsafeLimits
from vehicle_gateway.free_way import Surroundings, Way
from vehicle_gateway.gate import GateLimits
from vehicle_gateway.guard import Eye, GuardLimits, Things
from vehicle_gateway.hand_over import HandOverLimits
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import Lease
from vehicle_gateway.link_quality import CapLimits, LoopAges, SpeedCap
from vehicle_gateway.place import Fix, PlaceLimits
from vehicle_gateway.rolling import Rolling, RollingLimits
from vehicle_gateway.safe_stop import StopLimits
from vehicle_gateway.zones import ZoneLimits
from wire.messages.automation import AutonomyCommand, AutonomyStatus, RoadMap, Scene, TakeoverRequest
from wire.messages.base import Count, Message, Name, Speed, Text, TimeNs
from wire.messages.operating import DriveCommand
from wire.messages.sensing import CameraStatus
from wire.messages.session import (
    HandOverReply,
    HandOverRequest,
    LeaseReply,
    LeaseRequest,
    SupervisionReply,
    SupervisionRequest,
)
from wire.messages.vehicle import Actuation, HandOver, Mode


class AuthorityLimits(Message):
    engage_autonomously: bool = False  # from STANDBY by itself, once, when the automation is healthy; never on a public road
    engage_needs_operator: bool = True  # sets off only when help is there: a lease holder with a fresh picture
    engage_after_s: Annotated[float, Meta(ge=0.0, le=60.0)] = 1.0
    override_ms: Annotated[float, Meta(ge=10.0, le=1000.0)] = 50.0  # architecture: seat and torque or brake for >= 50 ms
    seat_left_ms: Annotated[float, Meta(ge=50.0, le=5000.0)] = 500.0  # ours: a driver who shifts in the seat has not left it
    override_torque_nm: Annotated[float, Meta(ge=0.5, le=20.0)] = 3.0  # ours: above road shake, far below a pull
    override_brake: Annotated[float, Meta(ge=0.01, le=1.0)] = 0.1
    standstill_m_s: Annotated[float, Meta(ge=0.01, le=0.5)] = 0.05
    operator_brake_m_s2: Annotated[float, Meta(ge=-5.0, le=-0.1)] = -1.0  # harder than engine braking: a pressed pedal
    transition_s: Annotated[float, Meta(ge=0.0, le=10.0)] = 1.5  # smaller steps after control changed hands


class GatewayLimits(Message):
    authority: AuthorityLimits = AuthorityLimits()
    gate: GateLimits = GateLimits()
    failsafe: FailsafeLimits = FailsafeLimits()
    safe_stop: StopLimits = StopLimits()
    cap: CapLimits = CapLimits()
    hand_over: HandOverLimits = HandOverLimits()
    rolling: RollingLimits = RollingLimits()
    guard: GuardLimits = GuardLimits()
    place: PlaceLimits = PlaceLimits()
    zones: ZoneLimits = ZoneLimits()
    actuation: ActuationLimits = ActuationLimits()
    map: RoadMap | None = None  # the gateway's own; put here from the file that [vehicle_gateway] map names


class Inputs(Message):
    """What arrived since the last cycle; None and () for nothing. Authenticated and range-checked before."""

    feedback: Feedback | None = None
    command: DriveCommand | None = None
    command_ns: TimeNs = 0  # vehicle clock at arrival
    told_ns: dict[Name, TimeNs] = {}  # by camera, tower clock: since when earlier commands of this cycle told of the same picture
    autonomy: AutonomyCommand | None = None
    autonomy_status: AutonomyStatus | None = None
    scene: Scene | None = None
    cameras: tuple[CameraStatus, ...] = ()
    stop_number: Count = 0  # of the newest TowerStop; 0 when none came
    lease_requests: tuple[LeaseRequest, ...] = ()
    hand_over_requests: tuple[HandOverRequest, ...] = ()
    operators: tuple[Identity, ...] = ()  # who asks for the lease, one for each request; () in recordings from before
    holder_revoked: bool = False  # the certificate of the lease's holder is on the list of the revoked
    supervision_requests: tuple[SupervisionRequest, ...] = ()
    supervisors: tuple[Identity, ...] = ()  # one for each
    next_command: DriveCommand | None = None  # of the next operator: it drives nothing
    next_command_ns: TimeNs = 0
    next_told_ns: dict[Name, TimeNs] = {}
    next_revoked: bool = False  # the next operator's certificate is on the list of the revoked


class Picture(Message):
    """What the operator's commands say about one camera."""

    capture_ns: TimeNs  # newest capture stamp seen on the operator's screen
    advanced_ns: TimeNs  # when that stamp last became newer
    told_ns: TimeNs = 0  # the same on the tower's clock: when the first command was sent that told of it


class Successor(Message):
    """The next operator, named by a supervisor while another one drives, and what his own commands show: `succession`."""

    operator: Name = ""  # "": nobody is named
    until_ns: TimeNs = 0  # when he is none any more
    agreed_ns: TimeNs = 0  # when the driver passed the car on; 0: not yet
    lease: Lease = Lease()  # his own, beside the driver's
    command: DriveCommand | None = None
    command_ns: TimeNs = 0
    dead_man_ns: TimeNs = 0
    pictures: dict[Name, Picture] = {}
    loop_ages: LoopAges = LoopAges()
    question_number: Count = 0


class State(Message):
    boot_id: Name
    now_ns: TimeNs
    authority: Authority
    mode_since_ns: TimeNs
    cause: Text = ""
    lease: Lease = Lease()
    feedback: Feedback | None = None
    feedback_ns: TimeNs = 0
    command: DriveCommand | None = None
    command_ns: TimeNs = 0
    dead_man_ns: TimeNs = 0  # when the last valid command with the dead-man held arrived
    autonomy: AutonomyCommand | None = None
    autonomy_ns: TimeNs = 0
    autonomy_status: AutonomyStatus | None = None
    autonomy_status_ns: TimeNs = 0
    healthy_since_ns: TimeNs = 0  # 0: not healthy
    engaged: bool = False
    was_local: bool = False  # a person in the car drove when the gateway died
    cameras: dict[Name, CameraStatus] = {}
    pictures: dict[Name, Picture] = {}
    loop_ages: LoopAges = LoopAges()
    loop_age_ms: Annotated[float, Meta(ge=0)] = 0.0
    actuation: ActuationDelay = ActuationDelay()  # how late the car does what is applied
    slow_since_ns: TimeNs = 0  # since when the p95 has been above its limit; 0: it is not
    cap: SpeedCap = SpeedCap(cap_m_s=0.0, bad_ns=0)
    odometry: Odometry = Odometry()
    corridor: Corridor = Corridor()
    around: Surroundings = Surroundings()
    corridor_free: Count | None = None  # so many of the corridor's points are free now; None: all
    way: Way = Way()
    rolling: Rolling = Rolling()
    fix: Fix = Fix()  # where the newest scene has the car
    things: Things = Things()  # and what it tracks near it
    guard: Eye = Eye.BLIND
    on_no_stop: bool = False  # some part of the car is in a no-stop zone
    applied: Actuation = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
    hand_over: HandOver = HandOver(number=0, action="", state="", rule="")
    granted_ns: TimeNs = 0
    changed_hands_ns: TimeNs = 0  # when the driving source last changed
    remote_since_ns: TimeNs = 0
    guard_until_ns: TimeNs = 0
    bounces: Count = 0
    stop_number: Count = 0
    stop_pressed: bool = False
    stops: tuple[TimeNs, ...] = ()  # unplanned SAFE_STOPs of the last ten minutes
    override_since_ns: TimeNs = 0  # 0: nobody touches the controls in the car
    seat_left_ns: TimeNs = 0  # since when the driver's seat has been empty; 0: it is not
    question_number: Count = 0  # of the last hand-over question of this lease: an old one is not asked again
    causes: tuple[Cause, ...] = ()
    lease_note: Text = ""  # why the last lease was taken from its holder; "" once somebody has one again
    barred: dict[Name, TimeNs] = {}  # operators that get no lease before then
    offered_to: Name = ""  # whom a supervisor named: until then nobody else gets the lease
    offered_until_ns: TimeNs = 0
    successor: Successor = Successor()
    supervised_ns: TimeNs = 0  # stamp in the newest question of a supervisor that was obeyed: an old one is not obeyed again


class Outputs(Message):
    send: bool  # whether there is anything to put on CAN: not before the car has told how fast it is
    mode: Mode
    requested: Actuation
    applied: Actuation
    brake_hold: bool
    rules: tuple[Name, ...]
    events: tuple[Name, ...]  # those that changed the mode in this cycle
    causes: tuple[Cause, ...]
    cap_m_s: Speed
    guard: Eye = Eye.BLIND  # what the collision guard says of itself
    lease_replies: tuple[LeaseReply, ...] = ()  # without the key: the shell adds it
    hand_over_replies: tuple[HandOverReply, ...] = ()
    supervision_replies: tuple[SupervisionReply, ...] = ()


def open_request(state: State) -> TakeoverRequest | None:
    """The automation's open take-over request, if any."""
    return None if state.autonomy_status is None else state.autonomy_status.request


def initial_state(boot_id: str, now_ns: int, first_epoch: int, emergency_latched: bool) -> State:
    """The state before the first cycle: nobody drives; a latched emergency stop stays one."""
    mode = Mode.EMERGENCY_STOP if emergency_latched else Mode.STANDBY
    return State(
        boot_id=boot_id,
        now_ns=now_ns,
        authority=Authority(mode=mode, origin=mode),
        mode_since_ns=now_ns,
        lease=Lease(epoch=first_epoch),
        cause="emergency stop latched" if emergency_latched else "gateway started",
    )
