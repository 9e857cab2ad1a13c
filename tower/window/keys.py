"""Keyboard -> OperatorInput, by level. Pure: held controls, presses since the last call and the previous input go in.

Without focus everything is released and no press counts. Ratios are the bare levels of the keys: steering and pedal curves
live in the cockpit. The bindings are the one table that the key help and the pygame codes come from.
"""

from collections.abc import Iterable, Set
from dataclasses import dataclass
from enum import StrEnum

import msgspec

from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.operating import OperatorInput

SHIFT_BELOW_M_S = 0.3  # architecture: gears change below it
QUIT_WITHIN_NS = 2_000_000_000  # ours: a second Esc within it quits


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


@dataclass(frozen=True, slots=True)
class Binding:
    control: Control
    label: str  # for people
    keys: tuple[str, ...]  # names of pygame.key.key_code


BINDINGS: tuple[Binding, ...] = (
    Binding(Control.DEAD_MAN, "Shift", ("left shift", "right shift")),
    Binding(Control.ACCEPT, "Enter", ("return", "enter")),
    Binding(Control.STEER_LEFT, "A or Left", ("a", "left")),
    Binding(Control.STEER_RIGHT, "D or Right", ("d", "right")),
    Binding(Control.THROTTLE, "W or Up", ("w", "up")),
    Binding(Control.BRAKE, "S or Down", ("s", "down")),
    Binding(Control.STOP, "Space", ("space",)),
    Binding(Control.CLEAR, "C", ("c",)),
    Binding(Control.HAND_BACK, "B", ("b",)),
    Binding(Control.RETURN, "R", ("r",)),
    Binding(Control.ENGAGE, "E", ("e",)),
    Binding(Control.LEFT, "Comma", (",",)),
    Binding(Control.RIGHT, "Period", (".",)),
    Binding(Control.HAZARD, "H", ("h",)),
    Binding(Control.HORN, "J", ("j",)),
    Binding(Control.LIGHTS, "L", ("l",)),
    Binding(Control.WIPERS, "V", ("v",)),
    Binding(Control.GEAR, "G", ("g",)),
    Binding(Control.HELP, "F1 or ?", ("f1", "?", "/")),
    Binding(Control.FULL_SCREEN, "F11", ("f11",)),
    Binding(Control.QUIT, "Esc", ("escape",)),
)

_DRIVING = frozenset({Control.STEER_LEFT, Control.STEER_RIGHT, Control.THROTTLE, Control.BRAKE, Control.DEAD_MAN})
_COUNTERS = {
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


def released(now_ns: int) -> OperatorInput:
    """The input at start: nothing held, nothing pressed, gear in drive."""
    return OperatorInput(
        stamp_ns=now_ns,
        sequence=0,
        focus=False,
        device="keyboard",
        touched=False,
        steer=0.0,
        throttle=0.0,
        brake=0.0,
        dead_man=False,
        gear=Gear.DRIVE,
        indicators=Indicators.OFF,
        hazard=False,
        horn=False,
        accept_presses=0,
        hand_back_presses=0,
        return_presses=0,
        stop_presses=0,
        clear_presses=0,
        engage_presses=0,
    )


def next_input(
    held: Set[Control], presses: Iterable[Control], previous: OperatorInput, *, focus: bool, standing: bool, now_ns: int
) -> OperatorInput:
    """The next input to publish.

    held      controls that are down now
    presses   key-down edges since the last call, in order
    standing  the car is known to be slower than 0.3 m/s: the gear may change
    now_ns    tower clock
    """
    down = held if focus else frozenset()
    latched = previous
    for press in presses if focus else ():
        latched = _press(latched, press, standing)
    return msgspec.structs.replace(
        latched,
        stamp_ns=now_ns,
        sequence=previous.sequence + 1,
        focus=focus,
        touched=previous.touched or bool(down & _DRIVING),
        steer=float((Control.STEER_LEFT in down) - (Control.STEER_RIGHT in down)),
        throttle=float(Control.THROTTLE in down),
        brake=float(Control.BRAKE in down),
        dead_man=Control.DEAD_MAN in down,
        horn=Control.HORN in down,
    )


def _press(latched: OperatorInput, press: Control, standing: bool) -> OperatorInput:
    replace = msgspec.structs.replace
    if press in _COUNTERS:
        name = _COUNTERS[press]
        return replace(latched, **{name: getattr(latched, name) + 1})
    if press is Control.LEFT:
        return replace(latched, indicators=_toggled(latched.indicators, Indicators.LEFT))
    if press is Control.RIGHT:
        return replace(latched, indicators=_toggled(latched.indicators, Indicators.RIGHT))
    if press is Control.HAZARD:
        return replace(latched, hazard=not latched.hazard)
    if press is Control.LIGHTS:
        return replace(latched, lights=_NEXT_LIGHTS[latched.lights])
    if press is Control.WIPERS:
        return replace(latched, wipers=_NEXT_WIPERS[latched.wipers])
    if press is Control.GEAR and standing:
        return replace(latched, gear=_NEXT_GEAR[latched.gear])
    return latched


def _toggled(now: Indicators, wanted: Indicators) -> Indicators:
    return Indicators.OFF if now is wanted else wanted


@dataclass(frozen=True, slots=True)
class WindowKeys:
    """What the keys do to the window itself."""

    help_open: bool = False
    full_screen: bool = False
    quit_asked_ns: int | None = None  # tower clock
    quit: bool = False


def next_window_keys(presses: Iterable[Control], previous: WindowKeys, now_ns: int) -> WindowKeys:
    """Help, full screen, and leaving: one Esc asks, a second within 2 s quits."""
    asked = previous.quit_asked_ns
    if asked is not None and now_ns - asked > QUIT_WITHIN_NS:
        asked = None
    help_open, full_screen, leaving = previous.help_open, previous.full_screen, previous.quit
    for press in presses:
        if press is Control.HELP:
            help_open = not help_open
        elif press is Control.FULL_SCREEN:
            full_screen = not full_screen
        elif press is Control.QUIT:
            leaving = leaving or asked is not None
            asked = now_ns
    return WindowKeys(help_open, full_screen, asked, leaving)
