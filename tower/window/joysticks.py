"""Gamepads and wheels through SDL: opened when they are plugged in, heard through pygame's events. Decides nothing.

A wheel that the cockpit reads through evdev is left to it. A device that is no gamepad SDL knows, no wheel we know, and was never
calibrated, is left alone: its axes could be anything.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pygame

from tower.devices.found import has_evdev
from tower.devices.gamepad import profile_of
from tower.devices.known import KNOWN, through_sdl
from tower.devices.profile import EVDEV, GAMEPAD, SDL, Profile, meant
from tower.devices.sdl_events import JOYSTICK_EVENTS, identity, readings
from tower.devices.store import Saved
from tower.devices.switches import Control
from tower.window.sticks import Hands, honest, of_stick

log = logging.getLogger(__name__)


def is_the_cockpits(identity_: str, saved: Saved) -> bool:
    """Whether the cockpit reads this device through evdev."""
    return has_evdev() and (identity_ in KNOWN or (identity_, EVDEV) in saved)


@dataclass
class Opened:
    joystick: Any
    profile: Profile
    name: str
    first: dict[str, float] = field(default_factory=dict)  # what SDL said before the axis moved
    levels: dict[str, float] = field(default_factory=dict)


class Joysticks:
    """`open()` once; then every event to `hear`."""

    def __init__(self, saved: Saved) -> None:
        self._saved = saved
        self._opened: dict[int, Opened] = {}
        self._pressed: list[Control] = []

    def open(self) -> None:
        pygame.joystick.init()
        from pygame._sdl2 import controller

        controller.init()
        self._controller = controller

    def close(self) -> None:
        self._opened.clear()
        self._controller.quit()
        pygame.joystick.quit()

    def hear(self, event: pygame.event.Event) -> None:
        if event.type == pygame.JOYDEVICEADDED:
            self._add(event.device_index)
        elif event.type == pygame.JOYDEVICEREMOVED:
            self._opened.pop(event.instance_id, None)
        elif event.type in JOYSTICK_EVENTS:
            opened = self._opened.get(event.instance_id)
            if opened is not None:
                self._read(opened, event)

    def take_presses(self) -> tuple[Control, ...]:
        """What the buttons that went down since the last call stand for, in order."""
        pressed, self._pressed = tuple(self._pressed), []
        return pressed

    @property
    def hands(self) -> tuple[Hands, ...]:
        return tuple(of_stick(opened.levels, opened.profile, opened.name) for opened in self._opened.values())

    def _add(self, index: int) -> None:
        joystick = pygame.joystick.Joystick(index)
        number, who = joystick.get_instance_id(), identity(joystick.get_guid())
        profile = None if number in self._opened or is_the_cockpits(who, self._saved) else self._profile(index, joystick, who)
        if profile is None and number not in self._opened and not is_the_cockpits(who, self._saved):
            log.warning("%s (%s) is not known: tower devices calibrate", joystick.get_name(), who)
        if profile is not None:
            taken = {opened.name for opened in self._opened.values()}
            self._opened[number] = Opened(joystick, profile, named(profile, taken))

    def _profile(self, index: int, joystick: Any, who: str) -> Profile | None:
        if (who, SDL) in self._saved:
            return self._saved[who, SDL]
        if who in KNOWN:
            return through_sdl(KNOWN[who])
        if not self._controller.is_controller(index):
            return None
        known = self._controller.Controller(index)
        mapping: Mapping[str, str] = known.get_mapping()
        known.quit()  # pygame 2.6 crashes over one that is still open when the joysticks are closed
        return profile_of(mapping, joystick.get_name(), who)

    def _read(self, opened: Opened, event: pygame.event.Event) -> None:
        for name, value in readings(event):
            if name.startswith("axis"):
                if not honest(opened.first, opened.levels, name, value):
                    opened.first[name] = value
                    continue
            elif value > opened.levels.get(name, 0.0):
                self._pressed += meant((name,), opened.profile)
            opened.levels[name] = value


def named(profile: Profile, taken: set[str]) -> str:
    """The name on screen, one for each: "gamepad (Xbox 360 Controller)", and "... 2" of a second one."""
    base = f"gamepad ({profile.name})" if profile.kind == GAMEPAD else profile.name
    return next(name for number in range(1, 100) if (name := base if number == 1 else f"{base} {number}") not in taken)
