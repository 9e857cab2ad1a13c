"""What one device's axes and buttons mean: the calibration that is saved per device, and from readings to control positions. Pure.

Inputs have names that are the same for evdev and SDL: "axis 0", "button 288", "hat 0 left" (a button, whatever the system
calls it). An input that has not reported yet is absent from the readings: the kernel's first value may be anything.
"""

from collections.abc import Iterable, Mapping
from math import radians
from typing import Annotated

from msgspec import Meta

from haptics.torque import clamp
from tower.devices.switches import FOR_BUTTONS, Control
from wire.messages.base import Message

InputName = Annotated[str, Meta(pattern=r"^(axis \d{1,3}|button \d{1,4}|hat \d (left|right|up|down))$")]
RawValue = Annotated[float, Meta(ge=-1e6, le=1e6)]  # as the device reports it: evdev counts, SDL -1..1
Levels = Mapping[str, float]  # newest value of every input that has reported; buttons 0 or 1

WHEEL, GAMEPAD = "wheel", "gamepad"
EVDEV, SDL = "evdev", "sdl"
BUTTON_NAMES = {control.name.lower(): control for control in FOR_BUTTONS}


class Steering(Message):
    axis: InputName
    left: RawValue  # reading at the left end
    right: RawValue
    rotation_deg: Annotated[float, Meta(ge=40.0, le=1440.0)] = 900.0  # of a wheel, from end to end
    dead_zone: Annotated[float, Meta(ge=0.0, le=0.5)] = 0.0  # of half the travel, around the middle: for sticks
    exponent: Annotated[float, Meta(ge=1.0, le=4.0)] = 1.0  # finer around the middle: for sticks


class Pedal(Message):
    axis: InputName  # an axis, or a button where a gamepad has one for it
    released: RawValue
    pressed: RawValue


class Profile(Message):
    """One device. Saved as TOML; `problems` says what the types cannot."""

    name: Annotated[str, Meta(min_length=1, max_length=48)]
    id: Annotated[str, Meta(pattern="^[0-9a-f]{4}:[0-9a-f]{4}$")]  # USB vendor:product
    kind: Annotated[str, Meta(pattern="^(wheel|gamepad)$")]
    through: Annotated[str, Meta(pattern="^(evdev|sdl)$")]
    steering: Steering
    throttle: Pedal
    brake: Pedal
    buttons: dict[InputName, str]  # to names of BUTTON_NAMES
    force_sign: Annotated[int, Meta(ge=-1, le=1)] = 1  # -1: a wheel that pulls the other way; 0: no forces


def problems(profile: Profile) -> tuple[str, ...]:
    """What makes the profile unusable, each with its fix; () when nothing does."""
    found = [
        f"buttons: {button!r} is {name!r}; allowed: {', '.join(BUTTON_NAMES)}"
        for button, name in profile.buttons.items()
        if name not in BUTTON_NAMES
    ]
    for needed in (Control.DEAD_MAN, Control.STOP):
        if needed.name.lower() not in profile.buttons.values():
            found.append(f"buttons: none is {needed.name.lower()!r}; teach one: tower devices learn")
    ends = {
        "steering": (profile.steering.left, profile.steering.right),
        "throttle": (profile.throttle.released, profile.throttle.pressed),
        "brake": (profile.brake.released, profile.brake.pressed),
    }
    found += [
        f"{name}: both ends read {low:g}; calibrate: tower devices calibrate" for name, (low, high) in ends.items() if low == high
    ]
    return tuple(found)


def noticed(levels: Levels, events: Iterable[tuple[str, float]]) -> tuple[dict[str, float], tuple[str, ...]]:
    """(readings after the events, buttons that went down, in order). A button that repeats is no press."""
    after, pressed = dict(levels), []
    for name, value in events:
        if not name.startswith("axis") and value > 0.5 >= after.get(name, 0.0):
            pressed.append(name)
        after[name] = value
    return after, tuple(pressed)


def travel(levels: Levels, pedal: Pedal) -> float | None:
    """Share of the pedal's travel in 0..1, 0 released; None before its first report."""
    value = levels.get(pedal.axis)
    if value is None:
        return None
    return min(max((value - pedal.released) / (pedal.pressed - pedal.released), 0.0), 1.0)


def steering_share(levels: Levels, steering: Steering) -> float | None:
    """-1 at the right end, +1 at the left one, dead zone and curve applied; None before the first report."""
    value = levels.get(steering.axis)
    if value is None:
        return None
    share = clamp((steering.left + steering.right - 2.0 * value) / (steering.right - steering.left), 1.0)
    beyond = max(abs(share) - steering.dead_zone, 0.0) / (1.0 - steering.dead_zone)
    return float(beyond**steering.exponent) * (1.0 if share > 0 else -1.0)


def wheel_angle_rad(levels: Levels, steering: Steering) -> float | None:
    """Angle of a steering wheel, left positive; None before the first report."""
    share = steering_share(levels, steering)
    return None if share is None else share * half_range_rad(steering)


def half_range_rad(steering: Steering) -> float:
    return radians(steering.rotation_deg) / 2.0


def held(levels: Levels, profile: Profile) -> frozenset[Control]:
    """What the buttons that are down now stand for."""
    return frozenset(BUTTON_NAMES[name] for button, name in profile.buttons.items() if levels.get(button, 0.0) > 0.5)


def meant(pressed: Iterable[str], profile: Profile) -> tuple[Control, ...]:
    """What the buttons that went down stand for, in order; others do nothing."""
    return tuple(BUTTON_NAMES[profile.buttons[button]] for button in pressed if button in profile.buttons)
