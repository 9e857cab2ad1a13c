"""The one outside thing of the window: pygame's display, keyboard and gamepads. Says what is held and pressed; decides nothing."""

import os
import sys
from types import TracebackType

import pygame

from tower.devices.store import Saved
from tower.window.joysticks import Joysticks
from tower.window.keys import BINDINGS, Control
from tower.window.picture_layout import Box
from tower.window.settings import WindowSettings
from tower.window.sticks import Hands
from wire.configuration import ConfigurationError

TITLE = "Remote Operation Tower"
_DISPLAYS = ("DISPLAY", "WAYLAND_DISPLAY", "SDL_VIDEODRIVER")


class ScreenError(ConfigurationError):
    """No window can be opened; the text names the fix."""


def how_to_open(settings: WindowSettings, full_screen: bool, monitors: list[tuple[int, int]]) -> tuple[tuple[int, int], int, int]:
    """Size, pygame's flags and the display of the window.

    monitors  their sizes as SDL counts them; spanning, they stand side by side from left to right
    """
    display = min(settings.display, max(len(monitors) - 1, 0))  # a monitor that was unplugged must not keep the window away
    if full_screen and settings.span_displays and len(monitors) > 1:
        return (sum(width for width, _ in monitors), min(height for _, height in monitors)), pygame.NOFRAME, 0
    if full_screen:
        return (0, 0), pygame.FULLSCREEN, display
    return (settings.width_px, settings.height_px), pygame.RESIZABLE, display


def parted(settings: WindowSettings, full_screen: bool, monitors: list[tuple[int, int]]) -> tuple[Box, ...]:
    """Where the window's two monitors are in it, the one for the front picture (`display`) first; () when it is one whole."""
    if not (full_screen and settings.span_displays and len(monitors) == 2):
        return ()
    high = min(height for _, height in monitors)
    first, second = Box(0, 0, monitors[0][0], high), Box(monitors[0][0], 0, monitors[1][0], high)
    return (second, first) if settings.display == 1 else (first, second)


def has_screen() -> bool:
    """Whether a window could be seen, or SDL was told what to draw on instead."""
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in _DISPLAYS)


class Screen:
    """`with Screen(settings) as screen:` - without a display the window is drawn all the same, into memory."""

    def __init__(self, settings: WindowSettings, saved: Saved | None = None) -> None:
        """saved: calibrated devices"""
        self._settings = settings
        self._full_screen = settings.full_screen
        self._parts: tuple[Box, ...] = ()
        self._codes: dict[int, Control] = {}
        self._joysticks = Joysticks(saved or {})

    def __enter__(self) -> "Screen":
        if not has_screen():
            os.environ["SDL_VIDEODRIVER"] = "dummy"
        try:
            pygame.display.init()
            if pygame.display.get_driver() == "x11":  # straight into X's memory: no texture, no vertical sync to wait for and,
                os.environ.setdefault("SDL_FRAMEBUFFER_ACCELERATION", "0")  # without a GPU, no OpenGL in software
            self._joysticks.open()
            self._open()
        except pygame.error as error:
            raise ScreenError(f"cannot open a window: {error}; set DISPLAY, or unset it to draw without a screen") from None
        self._codes = {pygame.key.key_code(name): binding.control for binding in BINDINGS for name in binding.keys}
        self.has_display = pygame.display.get_driver() != "dummy"
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._joysticks.close()
        pygame.mixer.quit()
        pygame.display.quit()

    def _open(self) -> None:
        monitors = pygame.display.get_desktop_sizes()
        size, flags, display = how_to_open(self._settings, self._full_screen, monitors)
        self._parts = parted(self._settings, self._full_screen, monitors)
        if flags & pygame.NOFRAME:
            os.environ["SDL_VIDEO_WINDOW_POS"] = "0,0"  # read by SDL whenever a window is made
        else:
            os.environ.pop("SDL_VIDEO_WINDOW_POS", None)
        pygame.display.set_mode(size, flags, display=display)
        pygame.display.set_caption(TITLE)

    def show_full(self, full_screen: bool) -> None:
        """Switch to or from full screen; nothing when it is so already."""
        if full_screen != self._full_screen:
            self._full_screen = full_screen
            self._open()

    @property
    def surface(self) -> pygame.Surface:
        return pygame.display.get_surface()

    @property
    def side_surface(self) -> pygame.Surface | None:
        """The monitor for the side pictures, where the window stands on two; then `front_surface` is the other."""
        return self.surface.subsurface(self._parts[1]) if self._stands_on_two else None

    @property
    def front_surface(self) -> pygame.Surface:
        return self.surface.subsurface(self._parts[0]) if self._stands_on_two else self.surface

    @property
    def _stands_on_two(self) -> bool:
        """SDL may give another size than asked for."""
        return bool(self._parts) and all(self.surface.get_rect().contains(part) for part in self._parts)

    @property
    def focus(self) -> bool:
        return bool(pygame.key.get_focused())

    def presses(self) -> tuple[Control, ...]:
        """Edges of keys, then of buttons, since the last call, in order; closing the window counts as Esc. Repeats are no edges."""
        pressed = []
        for event in pygame.event.get():
            if event.type == pygame.QUIT:
                pressed.append(Control.QUIT)
            elif event.type == pygame.KEYDOWN and event.key in self._codes:
                pressed.append(self._codes[event.key])
            else:
                self._joysticks.hear(event)
        return (*pressed, *self._joysticks.take_presses())

    def sticks(self) -> tuple[Hands, ...]:
        """Gamepads and wheels that are plugged in, as of the last `presses`."""
        return self._joysticks.hands

    def held(self) -> frozenset[Control]:
        down = pygame.key.get_pressed()
        return frozenset(control for code, control in self._codes.items() if down[code])

    def flip(self) -> None:
        pygame.display.flip()
