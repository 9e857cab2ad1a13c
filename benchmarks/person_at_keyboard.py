"""Presses real keys (xdotool on an X display) as `benchmarks.person` decides, until the drive ends. A shell."""

import os
import shutil
import subprocess
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType

from benchmarks.person import Finger, Hands, Person
from benchmarks.person_looking import looked, paged
from wire.settings import WireSettings

KEYS = {
    Finger.DEAD_MAN: "shift",
    Finger.LEFT: "Left",
    Finger.RIGHT: "Right",
    Finger.THROTTLE: "Up",
    Finger.BRAKE: "Down",
    Finger.ACCEPT: "Return",
    Finger.HAND_BACK: "b",
    Finger.STOP: "space",
    Finger.CLEAR: "c",
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


def drive(wire: WireSettings, display: str, done: threading.Event, person: Person | None = None) -> Person:
    """Look and press keys until `done` is set; what the person has been through."""
    with Keyboard(display) as keyboard:
        return looked(wire, done, lambda _, __, hands: keyboard.press(hands), person)


def check(wire: WireSettings, display: str, done: threading.Event) -> dict[str, str]:
    """Work the checklist with real keys until all of it is passed or `done` is set; how it stood at the end."""
    with Keyboard(display) as keyboard:
        return paged(wire, done, keyboard.press)
