"""What each part of the window shows, rounded as it is shown: two equal views draw the same picture, so a part is drawn
again only when its view has changed. Plain data; no messages' meaning is decided here.
"""

from dataclasses import dataclass
from enum import StrEnum

from tower.window.age_history import Sample
from tower.window.checks import Check
from tower.window.course import XY, Strip
from tower.window.drive_log import Stretch
from tower.window.looks import Look
from tower.window.picture_age import PictureState
from tower.window.replay_ring import ReplayFrame
from wire.messages.automation import RoadMap, Scene
from wire.messages.base import Gear, Point
from wire.messages.vehicle import CameraCalibration, Mode


class Tone(StrEnum):
    CALM = "calm"
    GOOD = "good"
    WARN = "warn"
    BAD = "bad"


@dataclass(frozen=True, slots=True, kw_only=True)
class BannerView:
    look: Look
    cause: str  # why, as the car says it; "" when a card says it
    hint: str  # what the operator can do
    tone: Tone


@dataclass(frozen=True, slots=True, kw_only=True)
class DialView:
    fresh: bool
    speed_km_h: float  # in steps of 0.25
    cap_km_h: float | None  # in steps of 0.5; None when nothing caps
    scale_km_h: int
    gear: Gear
    lamps: str  # lights and wipers that are on, as the car says
    left_lit: bool
    right_lit: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ControlsView:
    """Signed shares of the full travel in [-1, 1]: steering left positive, acceleration positive, braking negative."""

    fresh: bool
    steer_requested: float
    steer_applied: float
    steer_text: str
    drive_requested: float
    drive_applied: float
    drive_text: str
    rule_text: str  # what became of the request
    limited: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Figure:
    label: str
    text: str
    tone: Tone


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkView:
    bars: int  # 0..4
    word: str
    figures: tuple[Figure, ...]
    samples: tuple[Sample, ...]
    now_ns: int  # of the newest sample
    motion: str  # until the car answers, with its bound; a dash while the operator does not drive


@dataclass(frozen=True, slots=True, kw_only=True)
class ChecklistView:
    items: tuple[Check, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class BriefingView:
    replay: ReplayFrame | None
    figures: tuple[Figure, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class OperatorView:
    name: str
    lease: str
    lease_tone: Tone
    dead_man: bool
    dead_man_text: str
    note: str


@dataclass(frozen=True, slots=True)
class Step:
    text: str
    done: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class CardView:
    """The one thing that matters now, above the horizon."""

    title: str
    tone: Tone
    reasons: tuple[tuple[str, str], ...] = ()  # (channel, words)
    remaining_text: str = ""
    remaining_share: float | None = None  # of the budget, 1 full; in steps of 1/200
    steps: tuple[Step, ...] = ()
    action: str = ""  # what to do now
    note: str = ""
    wheel_error_deg: float | None = None  # operator's wheel minus the car's, left positive; None: not shown
    wheel_aligned: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class MapView:
    road_map: RoadMap | None
    scene: Scene | None  # None when there is none or it is old
    trouble: Point | None  # place of the open request
    car_length_m: float
    car_width_m: float


class LineKind(StrEnum):  # drawn in this order
    UNCERTAINTY = "uncertainty"  # a ring: two deviations around where a person will be
    PERSON = "person"  # where it goes
    GUIDANCE = "guidance"
    NOT_FEASIBLE = "not feasible"
    TRAJECTORY = "trajectory"
    CHOSEN = "chosen"


@dataclass(frozen=True, slots=True, kw_only=True)
class PlannedLine:
    points: tuple[XY, ...]
    kind: LineKind
    colour: int | None  # number of a guidance class's colour; None: of no class


@dataclass(frozen=True, slots=True, kw_only=True)
class RoadView:
    """On the road in the picture. Metres in the car's own frame at the picture's capture stamp, rear axle, ISO 8855."""

    camera: CameraCalibration
    until_stop: Strip | None  # from where a command given now takes effect to where the car could stand
    whole: Strip | None  # the same and farther on at this angle of the wheel
    stop_text: str
    driving: bool  # False: the path is a preview, the operator does not drive yet
    corridor: Strip | None  # the way the car stops along by itself, as far as it is free
    stopping: bool  # it does so now; else it would, were everybody silent from now on
    blind_end: tuple[XY, XY] | None  # across it, where the car would stand
    place: tuple[float, float] | None  # of the open request
    place_text: str
    planned: tuple[PlannedLine, ...] = ()  # while the car drives by a planner that tells; the chosen one last


@dataclass(frozen=True, slots=True, kw_only=True)
class PictureView:
    state: PictureState
    title: str  # "" when nothing stands over the picture
    detail: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraView:
    """One camera's picture: its size, and what stands over it when it is not live."""

    shape: tuple[int, int]  # width and height, pixels
    state: PictureState
    tag: str  # "" when it is live


@dataclass(frozen=True, slots=True, kw_only=True)
class EndView:
    title: str
    rows: tuple[tuple[str, str, Mode | None], ...]  # label, figure, the mode whose colour it has in the bar
    stretches: tuple[Stretch, ...]
    recording: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewModel:
    picture: PictureView  # of the front camera
    cameras: dict[str, CameraView]  # those to be shown, by name; the front one among them
    road: RoadView | None
    banner: BannerView
    dial: DialView
    controls: ControlsView
    link: LinkView
    operator: OperatorView
    map: MapView
    card: CardView | None
    briefing: BriefingView | None
    checklist: ChecklistView | None
    end: EndView | None
    help_open: bool
    toast: str
