"""What the stack remembers from cycle to cycle, and what it drives with. Plain data."""

from dataclasses import dataclass

from autonomy.car_shape import CarShape
from autonomy.control.speed import SpeedState
from autonomy.inputs import Inputs
from autonomy.localization.ekf import Estimate, Pose
from autonomy.perception.tracking import TrackList
from autonomy.planning.braking_planner import Plan
from autonomy.planning.speed_limits import StopPoint
from autonomy.settings import AutonomySettings
from autonomy.uncertainty.monitor import MonitorState
from wire.messages.automation import AutonomyStatus
from wire.road import Road, RoadPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What does not change during a drive."""

    road: Road
    shape: CarShape
    settings: AutonomySettings


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where the car is in this cycle, in both coordinates."""

    pose: Pose
    at: RoadPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class StackState:
    now_ns: int = 0
    sequence: int = 0
    used: Inputs = Inputs()  # of the last cycle: new is what differs from it
    estimate: Estimate | None = None
    place: Place | None = None
    tracks: TrackList = TrackList()
    plan: Plan | None = None
    plan_due_ns: int = 0
    monitor: MonitorState = MonitorState()
    looks: int = 0  # of the monitor, since start
    slowing: StopPoint | None = None  # of the open request
    waiting_since_ns: int | None = None  # standing for a person
    driving: bool = False
    angle_rad: float = 0.0  # commanded last, road wheels
    speed: SpeedState = SpeedState()
    status_due_ns: int = 0
    status: AutonomyStatus | None = None  # published last
