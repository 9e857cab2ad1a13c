"""Keyboard and gamepad -> OperatorInput, by level. Pure: held controls, presses since the last call, the previous input go in.

Without focus everything is released and no press counts. Ratios are the bare levels of the keys: steering and pedal curves
live in the cockpit. The bindings are the one table that the key help and the pygame codes come from.
"""

from collections.abc import Iterable, Set
from dataclasses import dataclass

import msgspec

from tower.devices.switches import Control, changes
from tower.window.sticks import Hands, in_use, of_keys, touches, was_touched, without_focus
from wire.messages.base import Gear, Indicators
from wire.messages.operating import OperatorInput, OperatorStatus

__all__ = ["BINDINGS", "Binding", "Control", "WindowKeys", "followed", "next_input", "next_window_keys", "released"]

SHIFT_BELOW_M_S = 0.3  # architecture: gears change below it
QUIT_WITHIN_NS = 2_000_000_000  # ours: a second Esc within it quits


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
    held: Set[Control],
    presses: Iterable[Control],
    previous: OperatorInput,
    *,
    focus: bool,
    standing: bool,
    now_ns: int,
    sticks: Iterable[Hands] = (),
) -> OperatorInput:
    """The next input to publish.

    held      keys that are down now
    presses   edges of keys and buttons since the last call, in order: they count on every device, so STOP is never out of reach
    standing  the car is known to be slower than 0.3 m/s: the gear may change
    now_ns    tower clock
    sticks    gamepads and wheels that are plugged in
    """
    sticks = tuple(sticks)
    now = in_use(of_keys(held), sticks, previous)
    if not focus:
        now = without_focus(now)
    latched = previous
    for press in presses if focus else ():
        latched = _press(latched, press, standing)
    return msgspec.structs.replace(
        latched,
        stamp_ns=now_ns,
        sequence=previous.sequence + 1,
        focus=focus,
        device=now.device,
        kind=now.kind,
        touched=previous.touched or now.touched,
        touches=touches(now, previous),
        unplugged=now.unplugged,
        pedals_reported=now.reported,
        steer=now.steer,
        steering_wheel_angle_rad=now.angle_rad,
        throttle=now.throttle,
        brake=now.brake,
        dead_man=now.dead_man,
        horn=now.horn or (focus and any(hands.horn for hands in (of_keys(held), *sticks))),
    )


def followed(previous: OperatorInput, operator: OperatorStatus | None) -> OperatorInput:
    """The input with gear, lights and wipers as another device has them that is in use, so that they do not jump when this
    one is touched. operator: the cockpit's status if it is fresh."""
    if operator is None or operator.device == previous.device or was_touched(previous):
        return previous
    return msgspec.structs.replace(
        previous,
        gear=operator.gear,
        indicators=operator.indicators,
        hazard=operator.hazard,
        lights=operator.lights,
        wipers=operator.wipers,
    )


def _press(latched: OperatorInput, press: Control, standing: bool) -> OperatorInput:
    return msgspec.structs.replace(latched, **changes(latched, press, standing))


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
