"""Everything the window knows at one instant: the newest of each message and the window's own state. Plain data."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TypeVar

from tower.window.age_history import Sample
from tower.window.checks import Check
from tower.window.course import Motion
from tower.window.drive_log import DriveLog
from tower.window.forecast import Forecast
from tower.window.keys import WindowKeys
from tower.window.looks import another_drives
from tower.window.picture_age import PictureSeen
from tower.window.picture_layout import FRONT
from tower.window.replay_ring import ReplayFrame
from wire.latest import Received
from wire.messages.automation import AutonomyStatus, PlannerView, RoadMap, Scene
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import GatewayStatus, VehicleDescription, VehicleState

M = TypeVar("M")
STATE_STALE_NS = 300_000_000  # ours: 15 periods of vehicle_state; older figures are not shown
OPERATOR_STALE_NS = 1_000_000_000  # ours: 20 periods of operator_status
SCENE_STALE_NS = 1_000_000_000  # ours: 10 periods of scene and planner_view


@dataclass(frozen=True, slots=True, kw_only=True)
class Sights:
    """Stamps of reception are the tower's clock, like now_ns."""

    now_ns: int
    status: Received[GatewayStatus] | None = None
    state: Received[VehicleState] | None = None
    operator: Received[OperatorStatus] | None = None
    autonomy: Received[AutonomyStatus] | None = None
    scene: Received[Scene] | None = None
    planner: Received[PlannerView] | None = None
    road_map: RoadMap | None = None
    description: VehicleDescription | None = None
    video_note: str = ""  # why the car gives no pictures, as it said; "" when it does, or has said nothing
    vehicle_id: str = ""  # of the car that is waited for, as configured
    pictures: Mapping[str, PictureSeen] = field(default_factory=dict)  # newest capture stamp by camera
    rear_wanted: bool = False
    history: tuple[Sample, ...] = ()
    motions: tuple[Motion, ...] = ()  # the car's own measurements of the last moments
    checks: tuple[Check, ...] = ()  # () when no checklist is wanted
    forecast: Forecast | None = None
    replay: ReplayFrame | None = None
    log: DriveLog
    keys: WindowKeys = WindowKeys()
    focus: bool = True
    operator_name: str = ""  # who sits here, as configured
    window_device: str = "keyboard"  # the one that the window reads, by its name
    recording: str = ""  # name of the session's folder

    @property
    def picture(self) -> PictureSeen | None:
        """Of the front camera."""
        return self.pictures.get(FRONT)

    @property
    def fresh_state(self) -> VehicleState | None:
        return fresh(self.state, self.now_ns, STATE_STALE_NS)

    @property
    def fresh_operator(self) -> OperatorStatus | None:
        return fresh(self.operator, self.now_ns, OPERATOR_STALE_NS)

    @property
    def another_drives(self) -> bool:
        """The car is driven from another cockpit than ours."""
        return self.status is not None and another_drives(self.status.message, self.fresh_operator, self.operator_name)

    @property
    def fresh_scene(self) -> Scene | None:
        return fresh(self.scene, self.now_ns, SCENE_STALE_NS)

    @property
    def fresh_planner(self) -> PlannerView | None:
        return fresh(self.planner, self.now_ns, SCENE_STALE_NS)

    @property
    def clock_offset_ns(self) -> int | None:
        """Vehicle clock minus tower clock; None before the cockpit's first exchange."""
        operator = self.operator
        return operator.message.clock_offset_ns if operator is not None and operator.message.clock_bound_ns > 0 else None


def fresh(received: Received[M] | None, now_ns: int, limit_ns: int) -> M | None:
    """The message, when it came no longer ago than that; both on the tower's clock."""
    return received.message if received is not None and now_ns - received.received_ns <= limit_ns else None
