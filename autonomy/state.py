"""What the stack remembers from cycle to cycle, and what it drives with. Plain data."""

from dataclasses import dataclass

from msgspec import Struct, field

from autonomy.car_shape import CarShape
from autonomy.control.mpcc.reference import Reference
from autonomy.control.mpcc.state import Setup as TrackerSetup
from autonomy.control.mpcc.state import TrackerState, set_up
from autonomy.control.speed import SpeedState
from autonomy.inputs import Inputs
from autonomy.localization.ekf import Estimate, Pose
from autonomy.perception.tracking import TrackList
from autonomy.planning.among_people import lane_of
from autonomy.planning.braking_planner import Plan
from autonomy.planning.reference_path import ReferencePath
from autonomy.planning.speed_limits import StopPoint
from autonomy.planning.topology import TopologyState
from autonomy.settings import AutonomySettings
from autonomy.uncertainty.monitor import MonitorState
from autonomy.uncertainty.waiting import Waiting
from wire.messages.automation import AutonomyStatus
from wire.road import Road, RoadPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class AmongPeople:
    """What the topology planner and the tracker behind it need besides."""

    lane: ReferencePath
    tracker: TrackerSetup


@dataclass(frozen=True, slots=True, kw_only=True)
class Setup:
    """What does not change during a drive."""

    road: Road
    shape: CarShape
    settings: AutonomySettings
    among_people: AmongPeople | None = None  # None: the braking planner alone


def setup_of(road: Road, shape: CarShape, settings: AutonomySettings) -> Setup:
    """Raises ValueError for a car that the tracker's model cannot follow."""
    among = None
    if settings.planner == "topology":
        among = AmongPeople(lane=lane_of(road), tracker=set_up(settings.tracker, shape))
    return Setup(road=road, shape=shape, settings=settings, among_people=among)


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where the car is in this cycle, in both coordinates."""

    pose: Pose
    at: RoadPoint


@dataclass(frozen=True, slots=True, kw_only=True)
class Way:
    """Through the people, for the tracker to follow."""

    found_ns: int
    reference: Reference | None  # None: nowhere, it stands


class StackState(Struct, frozen=True, kw_only=True):
    now_ns: int = 0
    sequence: int = 0
    used: Inputs = Inputs()  # of the last cycle: new is what differs from it
    estimate: Estimate | None = None
    place: Place | None = None
    tracks: TrackList = TrackList()
    plan: Plan | None = None
    plan_due_ns: int = 0
    topology: TopologyState = field(default_factory=TopologyState)
    way: Way | None = None  # the last one found among people
    tracker: TrackerState = TrackerState()
    monitor: MonitorState = MonitorState()
    looks: int = 0  # of the monitor, since start
    slowing: StopPoint | None = None  # of the open request
    waiting: Waiting = Waiting()  # for people
    driving: bool = False
    angle_rad: float = 0.0  # commanded last, road wheels
    speed: SpeedState = SpeedState()
    status_due_ns: int = 0
    status: AutonomyStatus | None = None  # published last
