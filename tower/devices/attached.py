"""Every device that could be driven with, from Linux and from SDL, each once, and what is known about it. Pure.

A wheel that Linux shows is read through evdev, by the cockpit; everything else through SDL, by the window.
"""

from collections.abc import Callable
from dataclasses import dataclass

from tower.devices.found import UDEV_FIX, Node
from tower.devices.known import ABS_X, KNOWN, XBOX_MODE
from tower.devices.profile import EVDEV, SDL
from tower.devices.store import Saved

WHEEL_AXES_MIN = 3  # a wheel and two pedals


@dataclass(frozen=True, slots=True, kw_only=True)
class Joystick:
    """What SDL shows."""

    index: int
    id: str
    name: str
    is_gamepad: bool  # SDL knows what its axes mean


@dataclass(frozen=True, slots=True, kw_only=True)
class Attached:
    name: str
    id: str
    through: str
    place: str  # path, or SDL's index
    state: str  # what is known about it, in words
    usable: bool


def attached(
    nodes: tuple[Node, ...], joysticks: tuple[Joystick, ...], saved: Saved, readable: Callable[[str], bool]
) -> tuple[Attached, ...]:
    """readable: whether a path may be opened."""
    wheels = [node for node in nodes if _is_wheel(node, joysticks, saved)]
    theirs = {node.id for node in wheels}
    return (
        *(_through_evdev(node, saved, readable(node.path)) for node in wheels),
        *(_through_sdl(each, saved) for each in joysticks if each.id not in theirs),
    )


def _is_wheel(node: Node, joysticks: tuple[Joystick, ...], saved: Saved) -> bool:
    if node.id in KNOWN or node.id in XBOX_MODE or (node.id, EVDEV) in saved:
        return bool(node.axes) or node.id in XBOX_MODE
    gamepads = {each.id for each in joysticks if each.is_gamepad}
    return ABS_X in node.axes and len(node.axes) >= WHEEL_AXES_MIN and node.id not in gamepads and (node.id, SDL) not in saved


def _through_evdev(node: Node, saved: Saved, readable: bool) -> Attached:
    state = "calibrated" if (node.id, EVDEV) in saved else "known" if node.id in KNOWN else ""
    usable = bool(state) and readable
    if node.id in XBOX_MODE:
        state, usable = XBOX_MODE[node.id], False
    elif not readable:
        state = f"no permission: {UDEV_FIX}"
    return Attached(
        name=node.name,
        id=node.id,
        through=EVDEV,
        place=node.path,
        state=state or "not known: tower devices calibrate",
        usable=usable,
    )


def _through_sdl(joystick: Joystick, saved: Saved) -> Attached:
    states = (
        ((joystick.id, SDL) in saved, "calibrated"),
        (joystick.id in KNOWN, "known"),
        (joystick.is_gamepad, "gamepad that SDL knows"),
    )
    state = next((words for holds, words in states if holds), "")
    return Attached(
        name=joystick.name,
        id=joystick.id,
        through=SDL,
        place=f"joystick {joystick.index}",
        state=state or "not known: tower devices calibrate",
        usable=bool(state),
    )


def picked(devices: tuple[Attached, ...], wanted: str) -> Attached | str:
    """The one device meant by a part of its name, its id or its place; or what is wrong, with the fix."""
    fitting = [each for each in devices if wanted.lower() in f"{each.name} {each.id} {each.place}".lower()]
    if len(fitting) == 1:
        return fitting[0]
    if not devices:
        return "no device is attached; plug one in"
    names = ", ".join(f"{each.name!r} ({each.id})" for each in fitting or devices)
    return f"{'which device' if fitting else f'none is called {wanted!r}'}? name one with --device: {names}"
