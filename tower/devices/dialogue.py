"""What `tower devices` shows and asks: which wheels and gamepads are there, what their axes and buttons mean. A shell."""

import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from tower.devices import store
from tower.devices.attached import Attached, attached, picked
from tower.devices.calibration import NotClear
from tower.devices.found import UDEV_FIX, has_evdev, nodes
from tower.devices.gamepad import profile_of
from tower.devices.interview import calibrate, learn
from tower.devices.known import KNOWN, Ends, through_evdev, through_sdl
from tower.devices.profile import EVDEV, SDL, WHEEL, Pedal, Profile, Steering, problems
from tower.devices.source import Source, Unplugged
from tower.devices.store import Saved
from wire.configuration import ConfigurationError
from wire.process import USER_ERROR

STEP_S = 0.01


class Fault(Exception):
    """One line for the user."""


class Terminal:
    """A person at a terminal: Enter ends a step."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._entered = threading.Event()
        self._alone = False

    def ask(self, text: str) -> None:
        self._console.print(f"[bold]{text}[/]")
        self._entered.clear()
        threading.Thread(target=self._wait, daemon=True).start()

    def _wait(self) -> None:
        try:
            input()
        except EOFError:
            self._alone = True
        self._entered.set()

    def done(self) -> bool:
        entered = self._entered.wait(STEP_S)
        if self._alone:
            raise Fault("nobody presses Enter; run this in a terminal")
        return entered


@contextmanager
def _errors(console: Console) -> Iterator[None]:
    try:
        yield
    except (Fault, ConfigurationError, NotClear) as error:
        console.print(f"tower devices: {error}", soft_wrap=True, markup=False)
        raise typer.Exit(USER_ERROR) from None
    except Unplugged:
        console.print("tower devices: the device was unplugged; plug it in and start again")
        raise typer.Exit(USER_ERROR) from None


def show() -> None:
    """Every device that could be driven with, and what is known about it."""
    from tower.devices.sdl_source import Sdl

    console = Console()
    with _errors(console), Sdl() as sdl:
        saved = store.load(store.folder())
        devices = attached(nodes(), sdl.joysticks(), saved, _readable)
    if not devices:
        console.print("no wheel or gamepad is attached; the keyboard is always there (Shift is its dead-man control)")
        return
    table = Table("device", "id", "through", "place", "state")
    for each in devices:
        table.add_row(each.name, each.id, each.through, each.place, each.state, style="" if each.usable else "yellow")
    console.print(table)


def interview(wanted: str, rotation_deg: float, *, steering: bool) -> None:
    """Asks for steering and pedals, or for the buttons alone; saved for this device."""
    from tower.devices.sdl_source import Sdl, SdlSource

    console = Console()
    with _errors(console), Sdl() as sdl:
        saved = store.load(store.folder())
        chosen = picked(attached(nodes(), sdl.joysticks(), saved, _readable), wanted)
        if isinstance(chosen, str):
            raise Fault(chosen)
        if chosen.through == EVDEV:
            source, codes = _evdev(chosen)
            profile = starting_profile(chosen, saved, codes)
            ends = {f"axis {code}": each for code, each in codes.items()}
        else:
            index = int(chosen.place.removeprefix("joystick "))
            sdl_source = SdlSource(index)
            source, ends = sdl_source, sdl_source.ends
            mapping = sdl.mapping(index) if sdl.controller.is_controller(index) else {}
            profile = profile_of(mapping, chosen.name, chosen.id) or starting_profile(chosen, saved, {})
            profile = saved.get((chosen.id, SDL), profile)
        console.print(f"{chosen.name} ({chosen.id}) through {chosen.through}")
        person = Terminal(console)
        if steering:
            profile = calibrate(profile, source, ends, rotation_deg, person)
        if not steering or problems(profile):
            profile = learn(profile, source, person)
        source.close()
        console.print(f"saved: {finish(profile, store.folder())}", soft_wrap=True)


def _evdev(chosen: Attached) -> tuple[Source, dict[int, Ends]]:
    from tower.devices.evdev_wheel import EvdevWheel

    try:
        wheel = EvdevWheel(chosen.place)
    except OSError as error:
        raise Fault(f"{chosen.place}: {error.strerror}; {UDEV_FIX}") from None
    return wheel, wheel.ends


def starting_profile(device: Attached, saved: Saved, ends: dict[int, Ends]) -> Profile:
    """What is known before the interview: what was saved, the table's entry, or a bare wheel."""
    if (device.id, device.through) in saved:
        return saved[device.id, device.through]
    if device.id in KNOWN:
        known = KNOWN[device.id]
        return through_evdev(known, ends) if device.through == EVDEV else through_sdl(known)
    bare = Pedal(axis="axis 1", released=0.0, pressed=0.0)
    return Profile(
        name=device.name[:48],
        id=device.id,
        kind=WHEEL,
        through=device.through,
        steering=Steering(axis="axis 0", left=0.0, right=0.0),
        throttle=bare,
        brake=bare,
        buttons={},
    )


def finish(profile: Profile, where: Path) -> Path:
    """Saves a profile that can be driven with. Raises Fault on any other: the cockpit would not start with it."""
    wrong = problems(profile)
    if wrong:
        raise Fault(f"not saved: {wrong[0]}")
    return store.save(profile, where)


def _readable(path: str) -> bool:
    return has_evdev() and os.access(path, os.R_OK | os.W_OK)
