"""The cameras' pictures on the window's surface: each scaled into its box once, however often the window is drawn. Draws only."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import pygame

from tower.window.picture_age import PictureState
from tower.window.picture_layout import SHOWN, Box, Shape, part
from tower.window.views import CameraView
from wire.rear_view import REAR

Pixels = npt.NDArray[np.uint8]  # (H, W, 4) BGRA
BEHIND = (16, 20, 26)  # where there is no picture
_DARKENED = 84  # of 255: what is left of a frozen picture's brightness
_RIM_PX = 2


class Frame(Protocol):
    """A decoded picture, as tower.video.receiver gives it."""

    @property
    def capture_ns(self) -> int: ...  # vehicle clock
    @property
    def decoded_ns(self) -> int: ...  # tower clock
    @property
    def shape(self) -> Shape: ...  # of the picture as it came: a camera may give fewer pixels than its own
    def pixels(self, part: Box | None, size: tuple[int, int]) -> Pixels:
        """That part of the picture, None: all of it, at that size (width, height), contiguous."""


@dataclass(frozen=True, slots=True)
class _Scaled:
    frame: Frame
    box: Box
    image: pygame.Surface
    pixels: Pixels  # what `image` shows: it keeps no reference of its own


class Pictures:
    """Keeps the newest scaled picture of every camera."""

    def __init__(self) -> None:
        self._scaled: dict[str, _Scaled] = {}

    def draw(
        self,
        surface: pygame.Surface,
        frames: Mapping[str, Frame],
        boxes: Mapping[str, Box],
        views: Mapping[str, CameraView],
        dark: bool,
    ) -> None:
        """Every picture that has a place, the mirror last; nothing where there is none. `dark`: all of them recede."""
        for name in (name for name in SHOWN if name in boxes and name in views):
            box, view = boxes[name], views[name]
            frame = frames.get(name)
            if frame is None:
                surface.fill(BEHIND, box)
            else:
                recedes = dark or view.state is PictureState.FROZEN
                self._blit(surface, name, frame, box, view, recedes)
            if name == REAR:
                pygame.draw.rect(surface, BEHIND, box, _RIM_PX)

    def _blit(self, surface: pygame.Surface, name: str, frame: Frame, box: Box, view: CameraView, recedes: bool) -> None:
        kept = self._scaled.get(name)
        if kept is None or kept.frame is not frame or kept.box != box:
            kept = self._scaled[name] = _scale(name, frame, box)
        if recedes:
            surface.fill((0, 0, 0), box)
        kept.image.set_alpha(_DARKENED if recedes else None)  # None: opaque, a plain copy
        surface.blit(kept.image, (box.x, box.y))


def _scale(name: str, frame: Frame, box: Box) -> _Scaled:
    pixels = frame.pixels(part(name, frame.shape, box), (box.w, box.h))
    if name == REAR:
        pixels = np.ascontiguousarray(pixels[:, ::-1])  # a mirror
    return _Scaled(frame, box, pygame.image.frombuffer(pixels.data, (box.w, box.h), "BGRA"), pixels)
