"""Text as surfaces, kept while in use. The font is Rubik, shipped inside OpenCV: no font of the system is needed.

Legibility: nothing of the driving view is smaller than LEAST_SIZE. On a 24 inch monitor with 1920 x 1080 pixels (0.277 mm each),
full screen, that is 27 px; capitals are 0.74 of it, 5.5 mm, which is 12.7 arc minutes at 1.5 m. ISO 15008 asks for at least 12;
what has to be read at a glance (who drives, speed, what to do) has 14 to 46. A smaller window is read from nearer.

OpenCV's text crashes on lone surrogates (5.0.0, 2026-10), so only printable characters reach it, and only the first 240.
"""

from collections import OrderedDict
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt
import pygame

from tower.window.palette import Rgba

LEAST_SIZE = 18.0  # design units (720 to the window's height)
CAP_SHARE = 0.74  # of the size: capitals of Rubik, measured on "H" at 18 to 100 px
THIN, REGULAR, MEDIUM, BOLD = 300, 400, 500, 650
_LONGEST = 240  # characters; the widest window shows fewer
_KEPT = 600  # surfaces; about three times what one screen shows


@lru_cache(maxsize=1)
def _face() -> "cv2.FontFace":
    return cv2.FontFace("sans")


def clean(text: str) -> str:
    """What may be drawn: printable characters in one line."""
    return "".join(c if c.isprintable() else " " for c in text[:_LONGEST])


@lru_cache(maxsize=4096)
def width(text: str, size_px: int, weight: int) -> int:
    """Advance of cleaned text in pixels."""
    if not text:
        return 0
    box = cv2.getTextSize((1, 1), text, (0, 0), _face(), size_px, weight)
    return int(box[2])


@lru_cache(maxsize=1024)
def fit(text: str, size_px: int, weight: int, room_px: int) -> str:
    """The text, ended by an ellipsis where it does not fit."""
    text = clean(text)
    if width(text, size_px, weight) <= room_px:
        return text
    keep = len(text)
    while keep > 0 and width(text[:keep].rstrip() + "…", size_px, weight) > room_px:
        keep -= max(1, keep // 12)
    return text[:keep].rstrip() + "…" if keep > 0 else ""


@lru_cache(maxsize=256)
def wrap(text: str, size_px: int, weight: int, room_px: int, lines_max: int) -> tuple[str, ...]:
    """Lines broken between words; what does not fit ends in an ellipsis."""
    lines: list[str] = []
    words = clean(text).split()
    while words and len(lines) < lines_max:
        take = len(words)
        if len(lines) < lines_max - 1:
            while take > 1 and width(" ".join(words[:take]), size_px, weight) > room_px:
                take -= 1
        lines.append(fit(" ".join(words[:take]), size_px, weight, room_px))
        words = words[take:]
    return tuple(lines)


class Type:
    """Rendered text: (text, size, weight, colour) -> surface and the height of its baseline within it."""

    def __init__(self) -> None:
        self._kept: OrderedDict[tuple[str, int, int, Rgba], tuple[pygame.Surface, int]] = OrderedDict()

    @property
    def sizes_px(self) -> frozenset[int]:
        """Of every text that is kept: what has been drawn lately."""
        return frozenset(size_px for _, size_px, _, _ in self._kept)

    def render(self, text: str, size_px: int, weight: int, colour: Rgba) -> tuple[pygame.Surface, int]:
        """`text` must be clean. The surface has per-pixel alpha."""
        key = (text, size_px, weight, colour)
        found = self._kept.get(key)
        if found is not None:
            self._kept.move_to_end(key)
            return found
        if len(self._kept) >= _KEPT:
            self._kept.popitem(last=False)
        self._kept[key] = _rendered(text, size_px, weight, colour)
        return self._kept[key]


def _rendered(text: str, size_px: int, weight: int, colour: Rgba) -> tuple[pygame.Surface, int]:
    margin = max(2, size_px // 6)
    baseline = size_px + margin
    mask = np.zeros((baseline + size_px // 2 + margin, width(text, size_px, weight) + 2 * margin), np.uint8)
    cv2.putText(mask, text, (margin, baseline), (255,), _face(), size_px, weight)
    return tinted(mask, colour), baseline


def tinted(mask: npt.NDArray[np.uint8], colour: Rgba) -> pygame.Surface:
    """A coverage mask (H, W) as a surface of one colour, in the byte order of the window: other orders blend slowly."""
    red, green, blue, alpha = colour
    coverage = mask.astype(np.uint32)
    if alpha != 255:
        coverage = coverage * alpha // 255
    pixels = (coverage << 24) | ((red << 16) | (green << 8) | blue)
    return pygame.image.frombuffer(pixels.astype("<u4", copy=False).data, (mask.shape[1], mask.shape[0]), "BGRA")
