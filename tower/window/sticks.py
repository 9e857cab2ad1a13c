"""Which of the window's devices the operator uses - keyboard, gamepad, a wheel through SDL - and what it says. Pure.

Whoever is touched has the controls, unless a driving control of the one in use is held. A device that was in use and is gone
leaves everything released, and says so until another is touched.
"""

from collections.abc import Iterable, Mapping, Set
from dataclasses import dataclass

from tower.devices.profile import WHEEL, Levels, Profile, held, steering_share, travel, wheel_angle_rad
from tower.devices.switches import DRIVING, Control
from wire.messages.operating import InputKind, OperatorInput

KEYBOARD = "keyboard"
STICK_TOUCHED_FROM = 0.5  # of its travel: a thumb that rests on it is no wish to drive
PEDAL_TOUCHED_FROM = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Hands:
    """What one device says now."""

    device: str
    kind: InputKind = InputKind.KEYBOARD
    steer: float = 0.0  # left positive
    angle_rad: float = 0.0  # of a wheel
    throttle: float = 0.0
    brake: float = 0.0
    dead_man: bool = False
    horn: bool = False
    reported: bool = True  # pedals, and a wheel, have said where they are
    touched: bool = False  # a driving control is held
    unplugged: str = ""


def of_keys(down: Set[Control]) -> Hands:
    return Hands(
        device=KEYBOARD,
        steer=float((Control.STEER_LEFT in down) - (Control.STEER_RIGHT in down)),
        throttle=float(Control.THROTTLE in down),
        brake=float(Control.BRAKE in down),
        dead_man=Control.DEAD_MAN in down,
        horn=Control.HORN in down,
        touched=bool(down & DRIVING),
    )


def of_stick(levels: Levels, profile: Profile, name: str) -> Hands:
    """levels: of a device that has not reported an axis, the axis is absent."""
    is_wheel = profile.kind == WHEEL
    steer = 0.0 if is_wheel else steering_share(levels, profile.steering) or 0.0
    throttle, brake = travel(levels, profile.throttle), travel(levels, profile.brake)
    angle = wheel_angle_rad(levels, profile.steering) if is_wheel else None
    down = held(levels, profile)
    pressed = max(throttle or 0.0, brake or 0.0) > PEDAL_TOUCHED_FROM
    return Hands(
        device=name,
        kind=InputKind.WHEEL if is_wheel else InputKind.GAMEPAD,
        steer=steer,
        angle_rad=angle or 0.0,
        throttle=throttle or 0.0,
        brake=brake or 0.0,
        dead_man=Control.DEAD_MAN in down,
        horn=Control.HORN in down,
        reported=throttle is not None and brake is not None and (angle is not None or not is_wheel),
        touched=Control.DEAD_MAN in down or pressed or abs(steer) > STICK_TOUCHED_FROM,
    )


def in_use(keys: Hands, sticks: Iterable[Hands], previous: OperatorInput) -> Hands:
    """The device that has the controls, and what it says."""
    all_ = {hands.device: hands for hands in (keys, *sticks)}
    current = all_.get(previous.device) or _gone(previous)
    if current.touched:
        return current
    return next((hands for hands in all_.values() if hands.touched), current)


def _gone(previous: OperatorInput) -> Hands:
    return Hands(
        device=previous.device,
        kind=previous.kind,
        angle_rad=previous.steering_wheel_angle_rad,
        reported=False,
        unplugged=previous.device,
    )


def without_focus(hands: Hands) -> Hands:
    """Nothing is held in a window that has no focus; a wheel stays where it is."""
    return Hands(
        device=hands.device, kind=hands.kind, angle_rad=hands.angle_rad, reported=hands.reported, unplugged=hands.unplugged
    )


def touches(hands: Hands, previous: OperatorInput) -> int:
    """Counts each touch after all had been let go, and each by another device."""
    before = previous.device == hands.device and was_touched(previous)
    return previous.touches + (hands.touched and not before)


def was_touched(previous: OperatorInput) -> bool:
    if previous.kind is InputKind.KEYBOARD:
        return previous.dead_man or any((previous.steer, previous.throttle, previous.brake))
    pressed = max(previous.throttle, previous.brake) > PEDAL_TOUCHED_FROM
    return previous.dead_man or pressed or abs(previous.steer) > STICK_TOUCHED_FROM


def honest(first: Mapping[str, float], levels: Levels, axis: str, value: float) -> bool:
    """Whether a reading of an axis is one: SDL makes up the first value of an axis, so it counts from its first change on."""
    return axis in levels or first.get(axis, value) != value
