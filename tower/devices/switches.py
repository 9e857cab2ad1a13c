"""What an operator can do with a key or a button, and what a press of it latches: gear, lights, wipers, counters. Pure.

One table for keyboard, gamepad and wheel, so that a press means the same on each. Never reads a device.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol

from wire.messages.base import Gear, Indicators, Lights, Wipers


class Control(StrEnum):
    STEER_LEFT = "steer left"
    STEER_RIGHT = "steer right"
    THROTTLE = "throttle"
    BRAKE = "brake"
    DEAD_MAN = "dead-man: hold to drive"
    ACCEPT = "take over"
    HAND_BACK = "hand back to the car"
    RETURN = "drive again, within the guard"
    STOP = "STOP"
    CLEAR = "clear a stop"
    ENGAGE = "let the car drive"
    LEFT = "indicate left"
    RIGHT = "indicate right"
    HAZARD = "hazard lights"
    HORN = "horn"
    LIGHTS = "lights: low, high, off"
    WIPERS = "wipers: off, slow, fast"
    GEAR = "gear, at standstill"
    HELP = "these keys"
    FULL_SCREEN = "full screen"
    QUIT = "quit, asks first"


DRIVING = frozenset({Control.STEER_LEFT, Control.STEER_RIGHT, Control.THROTTLE, Control.BRAKE, Control.DEAD_MAN})
# What a button of a wheel or gamepad may do: driving is by axes, and the window's own keys stay on the keyboard.
FOR_BUTTONS = tuple(
    control
    for control in Control
    if control not in DRIVING - {Control.DEAD_MAN} | {Control.HELP, Control.FULL_SCREEN, Control.QUIT}
)
COUNTERS = {
    Control.ACCEPT: "accept_presses",
    Control.HAND_BACK: "hand_back_presses",
    Control.RETURN: "return_presses",
    Control.STOP: "stop_presses",
    Control.CLEAR: "clear_presses",
    Control.ENGAGE: "engage_presses",
}
_NEXT_GEAR = {Gear.DRIVE: Gear.REVERSE, Gear.REVERSE: Gear.NEUTRAL, Gear.NEUTRAL: Gear.PARK, Gear.PARK: Gear.DRIVE}
_NEXT_LIGHTS = {Lights.LOW: Lights.HIGH, Lights.HIGH: Lights.OFF, Lights.OFF: Lights.LOW}
_NEXT_WIPERS = {Wipers.OFF: Wipers.SLOW, Wipers.SLOW: Wipers.FAST, Wipers.FAST: Wipers.OFF}


class Latched(Protocol):
    """What a press may change: `Switches`, and the message of the window."""

    @property
    def gear(self) -> Gear: ...
    @property
    def indicators(self) -> Indicators: ...
    @property
    def hazard(self) -> bool: ...
    @property
    def lights(self) -> Lights: ...
    @property
    def wipers(self) -> Wipers: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Switches:
    gear: Gear = Gear.DRIVE
    indicators: Indicators = Indicators.OFF
    hazard: bool = False
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    accept_presses: int = 0
    hand_back_presses: int = 0
    return_presses: int = 0
    stop_presses: int = 0
    clear_presses: int = 0
    engage_presses: int = 0


def changes(latched: Latched, press: Control, standing: bool) -> dict[str, Any]:
    """The fields that one press changes, with their new values; {} for a control that only counts while it is held.

    standing  the car is known to be slower than 0.3 m/s: only then may the gear change
    """
    if press in COUNTERS:
        name = COUNTERS[press]
        return {name: getattr(latched, name) + 1}
    if press is Control.GEAR:
        return {"gear": _NEXT_GEAR[latched.gear]} if standing else {}
    return _toggles(latched).get(press, {})


def _toggles(latched: Latched) -> dict[Control, dict[str, Any]]:
    return {
        Control.LEFT: {"indicators": _switched(latched.indicators, Indicators.LEFT)},
        Control.RIGHT: {"indicators": _switched(latched.indicators, Indicators.RIGHT)},
        Control.HAZARD: {"hazard": not latched.hazard},
        Control.LIGHTS: {"lights": _NEXT_LIGHTS[latched.lights]},
        Control.WIPERS: {"wipers": _NEXT_WIPERS[latched.wipers]},
    }


def _switched(now: Indicators, wanted: Indicators) -> Indicators:
    return Indicators.OFF if now is wanted else wanted
