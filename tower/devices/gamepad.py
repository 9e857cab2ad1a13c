"""Gamepads: a profile from SDL's own mapping of the pad, so that every pad SDL knows drives without calibration. Pure.

Left stick steers, right trigger is the throttle, left trigger the brake, the left bumper is the dead-man control.
A mapping's value is "a2" (axis), "+a2" / "-a2" (half of it), "a2~" (inverted), "b5" (button) or "h0.4" (hat and its bit).
"""

from collections.abc import Mapping

from tower.devices.profile import GAMEPAD, SDL, Pedal, Profile, Steering

STICK_DEAD_ZONE = 0.1  # of half the travel: worn sticks rest up to this far off
STICK_EXPONENT = 1.8  # a thumb has 20 mm where a wheel has two turns
_HAT_BITS = {"1": "up", "2": "right", "4": "down", "8": "left"}  # SDL_HAT_*
_ACTIONS = {
    "leftshoulder": "dead_man",
    "rightshoulder": "horn",
    "a": "accept",
    "b": "stop",
    "x": "hand_back",
    "y": "return",
    "start": "gear",
    "back": "engage",
    "leftstick": "lights",
    "rightstick": "wipers",
    "dpleft": "left",
    "dpright": "right",
    "dpup": "hazard",
    "dpdown": "clear",
}


def profile_of(mapping: Mapping[str, str], name: str, identity: str) -> Profile | None:
    """The profile of a pad; None when its mapping lacks stick, triggers or bumper: then it has to be calibrated.

    mapping   as SDL gives it: {"leftx": "a0", "lefttrigger": "a2", "a": "b0", ...}
    identity  USB vendor:product
    """
    stick, throttle, brake = (mapping.get(each, "") for each in ("leftx", "righttrigger", "lefttrigger"))
    steering, pedals = _axis_of(stick), (_pedal(throttle), _pedal(brake))
    buttons = {_button(mapping[key]): action for key, action in _ACTIONS.items() if _button(mapping.get(key, ""))}
    if steering is None or pedals[0] is None or pedals[1] is None or "dead_man" not in buttons.values():
        return None
    left, right = (1.0, -1.0) if stick.endswith("~") else (-1.0, 1.0)
    return Profile(
        name=name[:48] or "gamepad",
        id=identity,
        kind=GAMEPAD,
        through=SDL,
        steering=Steering(axis=steering, left=left, right=right, dead_zone=STICK_DEAD_ZONE, exponent=STICK_EXPONENT),
        throttle=pedals[0],
        brake=pedals[1],
        buttons=buttons,
    )


def _axis_of(value: str) -> str | None:
    number = value.strip("+-~").removeprefix("a")
    return f"axis {number}" if value.strip("+-~").startswith("a") and number.isdigit() else None


def _pedal(value: str) -> Pedal | None:
    axis = _axis_of(value)
    if axis is None:
        button = _button(value)
        return Pedal(axis=button, released=0.0, pressed=1.0) if button else None
    released, pressed = {"+": (0.0, 1.0), "-": (0.0, -1.0)}.get(value[0], (-1.0, 1.0))
    return (
        Pedal(axis=axis, released=pressed, pressed=released)
        if value.endswith("~")
        else Pedal(axis=axis, released=released, pressed=pressed)
    )


def _button(value: str) -> str:
    if value.startswith("b") and value[1:].isdigit():
        return f"button {value[1:]}"
    hat, dot, bit = value.removeprefix("h").partition(".")
    return f"hat {hat} {_HAT_BITS[bit]}" if value.startswith("h") and dot and bit in _HAT_BITS else ""
