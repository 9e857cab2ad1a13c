"""Moves a gamepad that SDL itself makes in the window's process, as `benchmarks.person` decides. A shell.

`python person_at_gamepad.py --config FILE` is `tower window` on a display of its own (only a window with the focus is driven) with
that gamepad at its side: SDL's virtual joystick lives in one process only. It is told where stick, triggers and buttons are over a
socket in the session's folder.
"""

import argparse
import json
import os
import socket
import sys
import threading
from pathlib import Path

import pygame

from benchmarks.person import Finger, Hands, Look, Person, on_a_gamepad
from benchmarks.person_at_keyboard import virtual_display
from benchmarks.person_looking import looked
from benchmarks.virtual_gamepad import LEFT_SHOULDER, LEFT_TRIGGER, LEFT_X, RIGHT_TRIGGER, A, VirtualJoystick, X
from tower.window.window import run
from wire.process import BEHIND_CONTROL, run_until_stopped
from wire.settings import WireSettings

SOCKET = "gamepad.socket"
BUTTONS = {Finger.DEAD_MAN: LEFT_SHOULDER, Finger.ACCEPT: A, Finger.HAND_BACK: X}


def drive(wire: WireSettings, folder: Path, done: threading.Event) -> Person:
    """Look and move stick, triggers and buttons until `done` is set; what the person has been through."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as sender:

        def move(person: Person, look: Look, hands: Hands) -> None:
            if not (folder / SOCKET).exists():
                return  # the window has not begun to listen
            thumbs = on_a_gamepad(person, look, hands)
            axes = {LEFT_X: -thumbs.stick, RIGHT_TRIGGER: 2 * thumbs.throttle - 1, LEFT_TRIGGER: 2 * thumbs.brake - 1}
            down = hands.held | ({hands.tapped} if hands.tapped else set())
            told = {"axes": axes, "buttons": {number: finger in down for finger, number in BUTTONS.items()}}
            sender.sendto(json.dumps(told).encode(), str(folder / SOCKET))

        return looked(wire, done, move)


def _moved(place: Path) -> None:
    """Attach the gamepad when first told of it, then keep it where it is told to be. A thread beside the window."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as heard:
        heard.bind(str(place))
        first = heard.recv(4096)
        while not pygame.joystick.get_init():  # plugged in before the window looks, SDL would not announce it
            first = heard.recv(4096)
        pad = VirtualJoystick()
        for axis in (LEFT_TRIGGER, RIGHT_TRIGGER):
            pad.move(axis, -0.9)  # SDL makes up the first value of an axis: it counts from its first change on
        told = json.loads(first)
        while True:
            for axis, value in told["axes"].items():
                pad.move(int(axis), value)
            for button, down in told["buttons"].items():
                pad.press(int(button), down)
            told = json.loads(heard.recv(4096))


def _window(config: Path, stop: threading.Event) -> int:
    threading.Thread(target=_moved, args=(config.parent / SOCKET,), daemon=True).start()
    return run(config, stop)


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("--config", type=Path, required=True)
    config = parser.parse_args().config
    os.environ.pop("SDL_VIDEODRIVER", None)
    with virtual_display() as display:
        os.environ["DISPLAY"] = display
        code = run_until_stopped(_window, config, BEHIND_CONTROL)
    sys.exit(code)
