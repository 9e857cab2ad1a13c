"""Paint on the road: smooth shapes straight into the pixels of a surface, for what changes with every picture.

A fresh surface per shape, as Ink makes, would cost milliseconds here; this costs tenths. Draws, knows no meaning.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import cv2
import numpy as np
import numpy.typing as npt
import pygame

from tower.window.layout import Box

XY = tuple[float, float]
Colour = tuple[int, int, int]
Pixels = npt.NDArray[np.uint8]
_SHIFT = 4
_FAR_PX = 30000.0  # OpenCV keeps coordinates in 16.16


@contextmanager
def pixels_within(surface: pygame.Surface, box: Box) -> Iterator[Pixels | None]:
    """The pixels (H, W, 4) under a box, to be painted on. None: not 32 bits, or outside.

    The surface is locked as long as anybody holds the pixels, so they must not outlive the caller's function.
    """
    left, top = max(box.x, 0), max(box.y, 0)
    right, bottom = min(box.x + box.w, surface.get_width()), min(box.y + box.h, surface.get_height())
    if surface.get_bytesize() != 4 or right <= left or bottom <= top:
        yield None
        return
    proxy = surface.get_buffer()
    held = memoryview(proxy)  # type: ignore[arg-type]  # it is a buffer; the stub does not say so
    whole: Pixels = np.ndarray((surface.get_height(), surface.get_width(), 4), np.uint8, held, strides=(surface.get_pitch(), 4, 1))
    try:
        yield whole[top:bottom, left:right]
    finally:
        del whole, held, proxy


def ordered(colour: Colour, surface: pygame.Surface) -> tuple[int, int, int, int]:
    """The bytes of a colour as the surface stores them."""
    value = surface.map_rgb(colour)
    return value & 255, value >> 8 & 255, value >> 16 & 255, 255


def fill(pixels: Pixels, points: Sequence[XY], colour: tuple[int, int, int, int], share: float) -> None:
    """A polygon over what is there; share 1: opaque."""
    at = _fixed(points)
    high, wide = pixels.shape[:2]
    left, top = np.clip((at.min(axis=0) >> _SHIFT) - 1, 0, (wide, high))
    right, bottom = np.clip((at.max(axis=0) >> _SHIFT) + 3, 0, (wide, high))
    if right <= left or bottom <= top:
        return
    under = pixels[top:bottom, left:right]
    over = under.copy()
    cv2.fillPoly(over, [at - (left << _SHIFT, top << _SHIFT)], colour, cv2.LINE_AA, _SHIFT)
    cv2.addWeighted(over, share, under, 1.0 - share, 0.0, dst=under)


def stroke(pixels: Pixels, points: Sequence[XY], colour: tuple[int, int, int, int], thick_px: int, closed: bool = False) -> None:
    if len(points) > 1:
        cv2.polylines(pixels, [_fixed(points)], closed, colour, max(1, thick_px), cv2.LINE_AA, _SHIFT)


def _fixed(points: Sequence[XY]) -> npt.NDArray[np.int32]:
    at = np.clip(np.array(points, np.float64).reshape(-1, 2) - 0.5, -_FAR_PX, _FAR_PX)
    return np.round(at * (1 << _SHIFT)).astype(np.int32)
