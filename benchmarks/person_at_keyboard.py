"""Presses real keys (xdotool on an X display) as `benchmarks.person` decides, until the drive ends. A shell."""

import os
import shutil
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import Any

from benchmarks.person import Eyes, Finger, Hands, Person, acted
from tower.cockpit.devices import View
from wire.clock import Clock
from wire.latest import Latest
from wire.link import Link, open_link
from wire.messages.operating import OperatorStatus
from wire.settings import WireSettings
from wire.topics import Role

LOOK_S = 0.03
KEYS = {
    Finger.DEAD_MAN: "shift",
    Finger.LEFT: "Left",
    Finger.RIGHT: "Right",
    Finger.THROTTLE: "Up",
    Finger.BRAKE: "Down",
    Finger.ACCEPT: "Return",
    Finger.HAND_BACK: "b",
}
SCREEN = "1280x720x24"


def missing_programs() -> str:
    """What this needs and the machine has not; "" when all is there."""
    return ", ".join(name for name in ("Xvfb", "xdotool") if shutil.which(name) is None)


@contextmanager
def virtual_display() -> Iterator[str]:
    """An X display of its own; yields its name, for DISPLAY."""
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), "-screen", "0", SCREEN, "-nolisten", "tcp"],
        pass_fds=(writing,),
        stderr=subprocess.DEVNULL,
    )
    os.close(writing)
    try:
        with os.fdopen(reading) as pipe:
            yield f":{pipe.readline().strip()}"  # written when it is ready
    finally:
        server.terminate()
        server.wait()


class Keyboard:
    """One xdotool that is told line by line: the only window of the display gets the keys. Leaving lets go of everything."""

    def __init__(self, display: str) -> None:
        self._environment = os.environ | {"DISPLAY": display}
        self._held: frozenset[Finger] = frozenset()

    def __enter__(self) -> "Keyboard":
        self._tool = subprocess.Popen(["xdotool", "-"], stdin=subprocess.PIPE, env=self._environment, text=True)
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.press(Hands())
        if self._tool.stdin is not None:
            self._tool.stdin.close()
        self._tool.wait()

    def press(self, hands: Hands) -> None:
        lines = [f"keyup {KEYS[finger]}" for finger in self._held - hands.held]
        lines += [f"keydown {KEYS[finger]}" for finger in hands.held - self._held]
        lines += [f"key {KEYS[hands.tapped]}"] if hands.tapped else []
        self._held = hands.held
        if lines and self._tool.stdin is not None:
            self._tool.stdin.write("\n".join(lines) + "\n")
            self._tool.stdin.flush()


class Screen:
    """What the window is told, and what it has on screen."""

    def __init__(self, link: Link) -> None:
        self._operator: Latest[OperatorStatus] = link.level("operator_status")
        names = ("vehicle_state", "gateway_status", "description", "scene", "road_map", "window_status")
        self._slots: dict[str, Latest[Any]] = {
            name: link.level("vehicle_description" if name == "description" else name) for name in names
        }

    def view(self) -> View:
        newest: dict[str, Any] = {name: slot.get() for name, slot in self._slots.items()}
        return View(**newest)

    def operator(self) -> OperatorStatus | None:
        received = self._operator.get()
        return received.message if received else None


def drive(wire: WireSettings, display: str, done: threading.Event) -> Person:
    """Look and press until `done` is set; what the person has been through."""
    clock, person, eyes = Clock(wire.clock.tower_offset_ns), Person(), Eyes()
    with open_link(wire.link, Role.TOWER_OBSERVER, clock, done) as link, Keyboard(display) as keyboard:
        screen = Screen(link)
        while not done.wait(LOOK_S):
            person, hands = acted(person, eyes.look(screen.view(), screen.operator(), time.monotonic()))
            keyboard.press(hands)
    return person
