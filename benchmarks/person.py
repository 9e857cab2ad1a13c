"""A person at the controls: eyes on what the window shows, a mind that knows the way, fingers that hold and tap. Pure.

Unlike the scripted operator this one is no device of the cockpit: it reaches the window only through real keys (or a real
gamepad's axes), decided by what the window is told and has on screen (`displayed_capture_ns`), never by a timetable.
"""

from dataclasses import dataclass, field, replace
from enum import StrEnum
from math import copysign

from tower.cockpit.delayed_view import DelayedView, Seen
from tower.cockpit.devices import View
from tower.cockpit.driving import Intent, Mind, Perceived, understood
from tower.cockpit.keyboard import KeyboardSettings, target_max_rad
from tower.cockpit.pedals import PedalSettings
from tower.cockpit.speed_choice import SpeedSettings
from tower.cockpit.way_around import WaySettings
from tower.devices.gamepad import STICK_DEAD_ZONE, STICK_EXPONENT
from wire.messages.automation import RoadMap
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import GatewayStatus, Mode
from wire.road import Road

AGAIN_S = 1.0  # a press that came to nothing is tried again after this
REACTION_S = 0.2  # of eye and hand
STEER_BAND_RAD = 0.006  # at the road wheels: closer than this to the wanted angle is close enough
PEDAL_BAND = 0.05
LIFT_OFF_BRAKE = 0.4  # when the picture stands still
STANDING = (Mode.STANDBY, Mode.STOPPED)
HELD = frozenset({Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK})


class Finger(StrEnum):
    DEAD_MAN = "dead_man"
    LEFT = "left"
    RIGHT = "right"
    THROTTLE = "throttle"
    BRAKE = "brake"
    ACCEPT = "accept"
    HAND_BACK = "hand_back"
    STOP = "stop"
    CLEAR = "clear"


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """One look at the screen."""

    seen: Seen | None  # the car as it was when the picture on screen was taken; None: no picture yet
    status: GatewayStatus | None
    operator: OperatorStatus | None
    frozen: bool
    now_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Person:
    mind: Mind = field(default_factory=Mind)
    intent: Intent = Intent()
    steered: tuple[tuple[float, float], ...] = ()  # (time, road wheel angle asked for), newest first
    road: tuple[RoadMap, Road] | None = None
    tapped_s: float = -AGAIN_S
    drove: bool = False
    sets_off: bool = False  # takes a car that stands and asks for nobody


@dataclass(frozen=True, slots=True)
class Hands:
    held: frozenset[Finger] = frozenset()
    tapped: Finger | None = None


def acted(person: Person, look: Look) -> tuple[Person, Hands]:
    """What the fingers do after this look."""
    mode = look.status.mode if look.status is not None else None
    stranded = (mode is Mode.STOPPED and person.drove) or (mode in STANDING and person.sets_off)
    if look.operator is None or look.status is None or not (mode in HELD or stranded):
        return replace(person, intent=Intent()), Hands()
    person = _thought(person, look, look.operator)
    held = {Finger.DEAD_MAN} | (_driving(person.intent, look.operator) if mode in (Mode.REMOTE, Mode.HANDING_BACK) else set())
    tapped = _tap(person, look, look.operator, look.status)
    drove = person.drove or mode is Mode.REMOTE
    sets_off = person.sets_off and not drove
    person = replace(person, drove=drove, sets_off=sets_off, tapped_s=look.now_s if tapped else person.tapped_s)
    return person, Hands(frozenset(held), tapped)


def _tap(person: Person, look: Look, operator: OperatorStatus, status: GatewayStatus) -> Finger | None:
    if look.now_s - person.tapped_s < AGAIN_S or look.frozen:
        return None
    if status.mode in (Mode.TAKEOVER_REQUESTED, *STANDING) and operator.wheel_phase == "ready":
        return Finger.ACCEPT
    wants_back = status.mode is Mode.REMOTE and status.hand_back_ready and person.mind.home
    return Finger.HAND_BACK if wants_back else None


def _thought(person: Person, look: Look, operator: OperatorStatus) -> Person:
    """With what the eyes add; a picture that stands still adds only fear."""
    steered = ((look.now_s, operator.road_wheel_angle_rad), *person.steered[:60])
    if look.seen is None or look.frozen:
        return replace(person, intent=replace(person.intent, throttle=0.0, brake=LIFT_OFF_BRAKE), steered=steered)
    road = person.road
    if road is None or road[0] != look.seen.road_map:
        road = (look.seen.road_map, Road(look.seen.road_map))
    perceived = Perceived(
        seen=look.seen,
        road=road[1],
        driving=look.seen.gateway_status.mode is Mode.REMOTE,
        horizon_s=look.seen.vehicle_state.loop_age_ms / 1e3 + REACTION_S,
        steered=[(look.now_s - at_s, angle) for at_s, angle in steered],
    )
    mind = understood(person.mind, perceived, WaySettings(), SpeedSettings(), PedalSettings())
    return replace(person, mind=mind, intent=mind.intent, steered=steered, road=road)


def _driving(intent: Intent, operator: OperatorStatus) -> set[Finger]:
    """Keys know only down and up: each is held until the control, as shown on screen, is where it is wanted."""
    wanted, is_ = intent.road_wheel_angle_rad, operator.road_wheel_angle_rad
    rows = (
        (Finger.LEFT, wanted > STEER_BAND_RAD and is_ < wanted),
        (Finger.RIGHT, wanted < -STEER_BAND_RAD and is_ > wanted),
        (Finger.THROTTLE, intent.throttle > operator.throttle + PEDAL_BAND),
        (Finger.BRAKE, intent.brake > operator.brake + PEDAL_BAND),
    )
    return {finger for finger, down in rows if down}


@dataclass(frozen=True, slots=True)
class Thumbs:
    """A gamepad's stick (left positive) and triggers (0 released), as a practised thumb holds them."""

    stick: float = 0.0
    throttle: float = 0.0
    brake: float = 0.0


def on_a_gamepad(person: Person, look: Look, hands: Hands) -> Thumbs:
    """Where stick and triggers are held; nowhere while the person does not drive."""
    if look.seen is None or look.status is None or look.status.mode is not Mode.REMOTE or Finger.DEAD_MAN not in hands.held:
        return Thumbs()
    car, speed_m_s = look.seen.description, look.seen.vehicle_state.speed_m_s
    sharpest_rad = target_max_rad(speed_m_s, car, KeyboardSettings()) / car.steering_ratio
    share = min(max(person.intent.road_wheel_angle_rad / sharpest_rad, -1.0), 1.0)
    stick = STICK_DEAD_ZONE + (1.0 - STICK_DEAD_ZONE) * abs(share) ** (1.0 / STICK_EXPONENT)
    return Thumbs(copysign(stick if abs(share) > 1e-3 else 0.0, share), person.intent.throttle, person.intent.brake)


class Eyes:
    """Remembers what arrived, and finds what belongs to the picture on screen."""

    def __init__(self) -> None:
        self._view = DelayedView()

    def look(self, view: View, operator: OperatorStatus | None, now_s: float) -> Look:
        """One look at `view`, whose window_status says which picture is on screen."""
        self._view.note(view)
        window = view.window_status.message if view.window_status is not None else None
        captures = [stamp for stamp in (window.displayed_capture_ns.values() if window else ()) if stamp]
        return Look(
            seen=self._view.at(max(captures)) if captures else None,
            status=view.gateway_status.message if view.gateway_status is not None else None,
            operator=operator,
            frozen=window is None or window.frozen,
            now_s=now_s,
        )
