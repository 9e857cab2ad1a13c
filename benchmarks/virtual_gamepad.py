"""A gamepad that SDL itself makes: SDL_JoystickAttachVirtualEx, called in the SDL2 that pygame brings along. Nothing is replaced.

SDL calls it a real device: it is announced, opened, read and removed like one on a cable.
Source: SDL 2.28 SDL_joystick.h.
"""

import ctypes
from pathlib import Path

import pygame

GAMECONTROLLER, WHEEL = 1, 2  # SDL_JoystickType
# SDL_GameController's order of axes and buttons, which a virtual gamepad has
LEFT_X, LEFT_TRIGGER, RIGHT_TRIGGER = 0, 4, 5
A, B, X, Y, BACK, START, LEFT_STICK, LEFT_SHOULDER, RIGHT_SHOULDER, DPAD_LEFT = 0, 1, 2, 3, 4, 6, 7, 9, 10, 13


class _Description(ctypes.Structure):
    """SDL_VirtualJoystickDesc"""

    _fields_ = (
        *((name, ctypes.c_uint16) for name in ("version", "type", "axes", "buttons", "hats", "vendor", "product", "padding")),
        *((name, ctypes.c_uint32) for name in ("button_mask", "axis_mask")),
        ("name", ctypes.c_char_p),
        *((name, ctypes.c_void_p) for name in ("userdata", "update", "player", "rumble", "triggers", "led", "effect")),
    )


def sdl() -> ctypes.CDLL:
    """The library that pygame has loaded already."""
    beside = Path(pygame.__file__).parent.parent / "pygame.libs"
    library = ctypes.CDLL(str(next(beside.glob("libSDL2-2*"))))
    library.SDL_JoystickOpen.restype = ctypes.c_void_p
    library.SDL_GetError.restype = ctypes.c_char_p
    return library


class VirtualJoystick:
    """Attached until `unplug`. Axes are set as SDL counts them: -1..1, released triggers -1."""

    def __init__(self, kind: int = GAMECONTROLLER, *, vendor: int = 0x1234, product: int = 0x5678, axes: int = 6) -> None:
        self._sdl = sdl()
        self._description = _Description(
            version=1,
            type=kind,
            axes=axes,
            buttons=15,
            hats=0,
            vendor=vendor,
            product=product,
            button_mask=0x7FFF,
            axis_mask=0x3F,
            name=b"Virtual pad",
        )
        self.index = self._sdl.SDL_JoystickAttachVirtualEx(ctypes.byref(self._description))
        assert self.index >= 0, self._sdl.SDL_GetError()
        self._joystick = ctypes.c_void_p(self._sdl.SDL_JoystickOpen(self.index))

    def move(self, axis: int, value: float) -> None:
        assert self._sdl.SDL_JoystickSetVirtualAxis(self._joystick, axis, ctypes.c_int16(round(value * 32767))) == 0

    def press(self, button: int, down: bool = True) -> None:
        assert self._sdl.SDL_JoystickSetVirtualButton(self._joystick, button, ctypes.c_uint8(down)) == 0

    def unplug(self) -> None:
        self._sdl.SDL_JoystickClose(self._joystick)
        assert self._sdl.SDL_JoystickDetachVirtual(self.index) == 0
