"""One device through SDL for `tower devices`: the same readings as evdev gives, without a window. Owns pygame's joysticks."""

import os
from collections.abc import Mapping
from types import TracebackType
from typing import Any

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

import pygame

from tower.devices.attached import Joystick
from tower.devices.known import Ends
from tower.devices.sdl_events import identity, readings
from tower.devices.source import Readings, Unplugged


class Sdl:
    """`with Sdl() as sdl:` - joysticks without a window: they are heard although nothing has the focus."""

    def __enter__(self) -> "Sdl":
        os.environ["SDL_JOYSTICK_ALLOW_BACKGROUND_EVENTS"] = "1"
        os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
        pygame.display.init()
        pygame.joystick.init()
        from pygame._sdl2 import controller

        controller.init()
        self.controller: Any = controller
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.controller.quit()
        pygame.joystick.quit()
        pygame.display.quit()

    def joysticks(self) -> tuple[Joystick, ...]:
        found = [pygame.joystick.Joystick(index) for index in range(pygame.joystick.get_count())]
        return tuple(
            Joystick(
                index=index, id=identity(each.get_guid()), name=each.get_name(), is_gamepad=self.controller.is_controller(index)
            )
            for index, each in enumerate(found)
        )

    def mapping(self, index: int) -> Mapping[str, str]:
        """What SDL knows about a gamepad."""
        known = self.controller.Controller(index)
        found: Mapping[str, str] = known.get_mapping()
        known.quit()
        return found


class SdlSource:
    """A tower.devices.source.Source."""

    def __init__(self, index: int) -> None:
        self._joystick = pygame.joystick.Joystick(index)
        self._number = self._joystick.get_instance_id()

    @property
    def ends(self) -> dict[str, Ends]:
        return {f"axis {axis}": (-1.0, 1.0) for axis in range(self._joystick.get_numaxes())}

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        """See tower.devices.source; the age is not known here and stands as 0."""
        found: list[tuple[str, float]] = []
        for event in pygame.event.get():
            if getattr(event, "instance_id", None) == self._number:
                if event.type == pygame.JOYDEVICEREMOVED:
                    raise Unplugged
                found += readings(event)
        return tuple(found), (0 if found else None)

    def close(self) -> None:
        self._joystick.quit()
