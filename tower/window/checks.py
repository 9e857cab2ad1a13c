"""The pre-drive checklist: every item passes on a measurement, none by a tick. Pure.

A failed or open item is shown, told in WindowStatus.checks and recorded; it holds nobody up: whether the operator may drive is the
car's decision, by its own rules. Wheel and brake are measured anew when the device changes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum, StrEnum

from tower.window.forecast import LOOP_AGE_FREE_MS, Minute
from tower.window.picture_age import PictureState
from tower.window.sounds import Trial
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import VehicleDescription

TURNED_RAD = 0.35  # ours, 20 deg at the steering wheel: no hand gets there by resting on it
CENTRED_RAD = 0.09  # 5 deg
KEY_TURNED = 0.3  # of a key or a stick
PRESSED, RELEASED = 0.5, 0.05  # of the brake's travel
LATENCY_S = 5  # how many seconds of the link have to be known
_SECOND_NS = 1_000_000_000


class CheckState(StrEnum):
    PENDING = "pending"
    PASSED = "passed"
    FAILED = "failed"


@dataclass(frozen=True, slots=True)
class Check:
    name: str
    text: str  # what to do, or what was measured
    state: CheckState


class Turn(IntEnum):
    """How far the wheel's check has come."""

    LEFT = 0
    BACK = 1
    RIGHT = 2
    DONE = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Checks:
    """What has been measured so far."""

    device: str = ""
    turn: Turn = Turn.LEFT
    wrong_way: bool = False
    brake_pressed: bool = False
    brake_released: bool = False
    stop_first: int | None = None  # number of the last STOP before the checks began
    stop_state: str = ""  # of a STOP pressed since


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """What the checklist looks at now."""

    standing: bool  # the car is known to stand
    pictures: Mapping[str, PictureState]  # by camera
    description: VehicleDescription | None
    minute: Minute
    now_ns: int
    trial: Trial  # of the sound


def checked(checks: Checks, operator: OperatorStatus) -> Checks:
    """With the cockpit's newest word."""
    if operator.device != checks.device:
        checks = replace(checks, device=operator.device, turn=Turn.LEFT, wrong_way=False, brake_pressed=False, brake_released=False)
    pressed = checks.brake_pressed or operator.brake >= PRESSED
    first = operator.stop_number if checks.stop_first is None else checks.stop_first
    return replace(
        _turned(checks, _side(operator)),
        brake_pressed=pressed,
        brake_released=checks.brake_released or (pressed and operator.brake <= RELEASED),
        stop_first=first,
        stop_state=_stop_state(checks.stop_state, operator, first),
    )


def _side(operator: OperatorStatus) -> int:
    """+1: left came back, -1: right, 0: the middle. A wheel that the torque turns to the car's angle says nothing of the hands."""
    if abs(operator.steer_asked) >= KEY_TURNED:
        return 1 if operator.steer_asked > 0 else -1
    angle = operator.steering_wheel_angle_rad if operator.wheel_phase == "idle" else 0.0
    return 0 if abs(angle) < TURNED_RAD else 1 if angle > 0 else -1


def _turned(checks: Checks, side: int) -> Checks:
    """Left, back to the middle, right. The wrong side fails until the wheel is back in the middle; then it is asked for again."""
    wanted = {Turn.LEFT: 1, Turn.BACK: 0, Turn.RIGHT: -1, Turn.DONE: side}[checks.turn]
    if side == wanted and not checks.wrong_way:
        return replace(checks, turn=Turn(min(checks.turn + 1, Turn.DONE)))
    if side == 0:
        return replace(checks, wrong_way=False)
    wrong = side == -wanted and checks.turn in (Turn.LEFT, Turn.RIGHT)
    return replace(checks, wrong_way=checks.wrong_way or wrong)


def _stop_state(before: str, operator: OperatorStatus, first: int) -> str:
    """A confirmation stays, whatever is cleared afterwards."""
    if operator.stop_number == first or before == "confirmed":
        return before
    return operator.stop_state or before


def items(checks: Checks, measured: Measured) -> tuple[Check, ...]:
    """In the order in which they are best done."""
    return (
        _wheel(checks),
        _brake(checks),
        _stop(checks, measured.standing),
        _sound(measured.trial),
        _cameras(measured),
        _latency(measured),
    )


_TURN_TEXTS = {Turn.LEFT: "turn it left", Turn.BACK: "let it go back", Turn.RIGHT: "turn it right", Turn.DONE: "works"}


def _wheel(checks: Checks) -> Check:
    if checks.wrong_way:
        came = "right" if checks.turn is Turn.LEFT else "left"
        return Check("wheel", f"came {came}!", CheckState.FAILED)
    return Check("wheel", _TURN_TEXTS[checks.turn], CheckState.PASSED if checks.turn is Turn.DONE else CheckState.PENDING)


def _brake(checks: Checks) -> Check:
    if checks.brake_released:
        return Check("brake", "works", CheckState.PASSED)
    return Check("brake", "let it go" if checks.brake_pressed else "press it", CheckState.PENDING)


def _stop(checks: Checks, standing: bool) -> Check:
    """Only at standstill: pressed in motion it does what it says."""
    if checks.stop_state == "confirmed":
        return Check("STOP", "confirmed", CheckState.PASSED)
    if checks.stop_state == "unconfirmed":
        return Check("STOP", "no answer!", CheckState.FAILED)
    return Check("STOP", "press it" if standing else "at standstill", CheckState.PENDING)


def _sound(trial: Trial) -> Check:
    return {
        Trial.SILENT: Check("sound", "no device!", CheckState.FAILED),
        Trial.PLAYED: Check("sound", "played", CheckState.PASSED),
        Trial.FILED: Check("sound", "into a file", CheckState.PASSED),
        Trial.WAITING: Check("sound", "not tried yet", CheckState.PENDING),
        Trial.PLAYING: Check("sound", "this is it", CheckState.PENDING),
    }[trial]


def _cameras(measured: Measured) -> Check:
    if measured.description is None:
        return Check("cameras", "no car yet", CheckState.PENDING)
    required = [camera.name for camera in measured.description.cameras if camera.required]
    missing = [name for name in required if measured.pictures.get(name) is not PictureState.LIVE]
    if missing:
        none_yet = all(measured.pictures.get(name, PictureState.NONE) is PictureState.NONE for name in missing)
        return Check("cameras", f"{', '.join(missing)}: {'none' if none_yet else 'old'}!", CheckState.FAILED)
    return Check("cameras", f"{len(required)} fresh", CheckState.PASSED)


def _latency(measured: Measured) -> Check:
    """The worst of the last five seconds against the age above which the car caps the speed."""
    now_s = measured.now_ns // _SECOND_NS
    ages = [age for second, age in measured.minute.seconds if now_s - second <= LATENCY_S]
    if len(ages) < LATENCY_S:
        return Check("latency", "measuring", CheckState.PENDING)
    worst = max(ages)
    good = worst <= LOOP_AGE_FREE_MS
    return Check("latency", f"{worst} ms{'' if good else '!'}", CheckState.PASSED if good else CheckState.FAILED)


def told(all_items: tuple[Check, ...]) -> dict[str, str]:
    """For WindowStatus."""
    return {check.name: check.state.value for check in all_items}
