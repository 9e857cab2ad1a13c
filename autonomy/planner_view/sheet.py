"""A sheet of pixels to draw smooth shapes and words on. Draws, knows no meaning. Coordinates in pixels, from the upper left corner.

Edges are smoothed by OpenCV's 8-bit coverage, to a sixteenth of a pixel. The font is Rubik, shipped inside OpenCV.
"""

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from autonomy.planning.horizon import Floats
from wire.planner_colours import Rgb

Pixels = NDArray[np.uint8]
Fixed = NDArray[np.int32]
Paint = Callable[[Pixels, Fixed, tuple[int, ...]], object]  # pixels to paint on, points, ink
SHIFT = 4  # fractional bits of OpenCV's coordinates
FAR_PX = 30_000.0  # it keeps them in 16.16
REGULAR, HEAVY = 400, 600  # weights


class Sheet:
    def __init__(self, wide_px: int, high_px: int, paper: Rgb) -> None:
        self.pixels: Pixels = np.full((high_px, wide_px, 3), paper[::-1], np.uint8)  # BGR, as OpenCV writes it
        self._face = cv2.FontFace("sans")

    def fill(self, points: Floats, colour: Rgb, share: float = 1.0) -> None:
        self._lay(points, 1.0, colour, share, lambda on, at, ink: cv2.fillPoly(on, [at], ink, cv2.LINE_AA, SHIFT))

    def stroke(self, points: Floats, thick_px: float, colour: Rgb, share: float = 1.0, closed: bool = False) -> None:
        """Round joints."""
        whole = max(1, round(thick_px))

        def paint(on: Pixels, at: Fixed, ink: tuple[int, ...]) -> object:
            return cv2.polylines(on, [at], closed, ink, whole, cv2.LINE_AA, SHIFT)

        self._lay(points, whole, colour, share, paint)

    def dashes(self, points: Floats, thick_px: float, colour: Rgb, on_px: float, off_px: float, share: float = 1.0) -> None:
        for piece in dashed(points, on_px, off_px):
            self.stroke(piece, thick_px, colour, share)

    def words(self, text: str, x: float, y: float, size_px: int, colour: Rgb, weight: int = REGULAR, anchor: float = 0.0) -> None:
        """One line with its baseline at y; anchor: the share of its width that lies left of x."""
        left = round(x - anchor * self.width(text, size_px, weight))
        cv2.putText(self.pixels, text, (left, round(y)), colour[::-1], self._face, size_px, weight)

    def fitted(self, text: str, room_px: float, size_px: int, weight: int = REGULAR) -> str:
        """The text, ended by an ellipsis where it does not fit."""
        if self.width(text, size_px, weight) <= room_px:
            return text
        while text and self.width(text + "…", size_px, weight) > room_px:
            text = text[:-1].rstrip()
        return text + "…"

    def width(self, text: str, size_px: int, weight: int = REGULAR) -> int:
        return int(cv2.getTextSize((1, 1), text, (0, 0), self._face, size_px, weight)[2]) if text else 0

    def _lay(self, points: Floats, thick: float, colour: Rgb, share: float, paint: Paint) -> None:
        """share below 1: coverage of the shape's own rectangle, laid over what is there in its colour."""
        if len(points) < 2 or not np.isfinite(points).all():
            return
        at, pad = np.clip(points, -FAR_PX, FAR_PX), thick / 2 + 2
        if share >= 1.0:
            paint(self.pixels, _fixed(at), colour[::-1])
            return
        high, wide = self.pixels.shape[:2]
        left, top = np.maximum(np.floor(at.min(axis=0) - pad), 0).astype(int)
        right, bottom = np.minimum(np.ceil(at.max(axis=0) + pad) + 1, (wide, high)).astype(int)
        if left >= right or top >= bottom:
            return
        mask = np.zeros((bottom - top, right - left), np.uint8)
        paint(mask, _fixed(at - (left, top)), (255,))
        under = self.pixels[top:bottom, left:right]
        covered = mask[..., None] * np.float32(share / 255.0)
        under[:] = np.rint(under + covered * (np.array(colour[::-1], np.float32) - under)).astype(np.uint8)


def _fixed(points: Floats) -> Fixed:
    return np.asarray(np.round(points * (1 << SHIFT)), np.int32)


def dashed(points: Floats, on: float, off: float) -> Sequence[Floats]:
    """The pieces of a polyline that a pen draws which is down for `on` and up for `off`, as lengths along it."""
    lengths = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    begins = np.arange(0.0, lengths[-1], on + off)
    return [_piece(points, lengths, begin, min(begin + on, lengths[-1])) for begin in begins]


def _piece(points: Floats, lengths: Floats, begin: float, end: float) -> Floats:
    inside = lengths[(lengths > begin) & (lengths < end)]
    at = np.concatenate(([begin], inside, [end]))
    return np.stack([np.interp(at, lengths, points[:, axis]) for axis in (0, 1)], axis=1)
