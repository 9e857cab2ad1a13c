"""Smooth shapes and text on a surface, in design units (1280 x 720) times the window's scale. Draws, knows no meaning.

Edges are smoothed by OpenCV's 8-bit coverage, to a sixteenth of a pixel; colours are laid over what is there.
"""

from collections.abc import Callable, Hashable, Sequence
from functools import lru_cache
from math import ceil, floor, pi

import cv2
import numpy as np
import numpy.typing as npt
import pygame

from tower.window.fonts import REGULAR, Type, clean, fit, tinted, width
from tower.window.palette import PANEL, PANEL_EDGE, Rgba

XY = tuple[float, float]
Rows = npt.NDArray[np.float64]  # (N, 2), design units
Points = Sequence[XY] | Rows
Paint = Callable[[np.ndarray, np.ndarray], object]  # (mask to paint into, points as fixed-point rows)
_WHITE: Rgba = (255, 255, 255, 255)
_SHIFT = 4  # fractional bits of OpenCV's coordinates
_FAR_PX = 30000.0  # OpenCV keeps coordinates in 16.16; nothing visible lies farther


class Ink:
    """origin: what stands at the surface's upper left corner, design units."""

    def __init__(self, surface: pygame.Surface, scale: float, kind: Type, origin: XY = (0.0, 0.0)) -> None:
        self.surface = surface
        self.scale = scale
        self._type = kind
        self._origin = origin

    @property
    def size(self) -> XY:
        """In design units."""
        return self.surface.get_width() / self.scale, self.surface.get_height() / self.scale

    def polygon(self, points: Points, colour: Rgba) -> None:
        self._stamp(points, 1.0, colour, lambda mask, at: cv2.fillPoly(mask, [at], (255,), cv2.LINE_AA, _SHIFT))

    def line(self, points: Points, thickness: float, colour: Rgba) -> None:
        """Round joints; never thinner than a pixel."""
        pixels = max(1, round(thickness * self.scale))
        self._stamp(points, pixels, colour, lambda mask, at: cv2.polylines(mask, [at], False, (255,), pixels, cv2.LINE_AA, _SHIFT))

    def disc(self, x: float, y: float, radius: float, colour: Rgba) -> None:
        self.polygon(arc(x, y, radius, 0.0, 2 * pi), colour)

    def ring(
        self, x: float, y: float, radius: float, thickness: float, colour: Rgba, begin: float = 0.0, end: float = 2 * pi
    ) -> None:
        """A band centred on `radius` between two angles (radians, clockwise on screen from three o'clock)."""
        if abs(end - begin) < 1e-4:
            return
        outer, inner = radius + thickness / 2, radius - thickness / 2
        self.polygon(np.concatenate((arc(x, y, outer, begin, end), arc(x, y, inner, begin, end)[::-1])), colour)

    def box(self, x: float, y: float, wide: float, high: float, colour: Rgba, radius: float = 0.0) -> None:
        if wide <= 0 or high <= 0:
            return
        self.polygon(rounded(x, y, wide, high, min(radius, wide / 2, high / 2)), colour)

    def panel(self, radius: float = 14.0, fill: Rgba = PANEL, edge: Rgba = PANEL_EDGE) -> None:
        """The whole surface as a dark, see-through panel with a hairline edge."""
        self.surface.blit(_panel(self.surface.get_size(), self.scale, radius, fill, edge), (0, 0))

    def layer(self, draw: Callable[..., None], *key: Hashable) -> None:
        """What `draw(ink, *key)` draws, drawn once for this size and these keys: the parts of a panel that seldom change."""
        self.surface.blit(_layer(draw, key, self.surface.get_size(), self.scale, self._type), (0, 0))

    def sign(self, x: float, y: float, reach: float, draw: Callable[..., None], *key: Hashable) -> None:
        """What `draw(ink, *key)` draws around (0, 0), no farther than `reach` from it, drawn once and laid at the nearest pixel."""
        half = ceil(reach * self.scale) + 2
        at = ((place - begin) * self.scale for place, begin in zip((x, y), self._origin, strict=True))
        left, top = (round(place) - half for place in at)
        if -2 * half < left < self.surface.get_width() and -2 * half < top < self.surface.get_height():
            self.surface.blit(_sign(draw, key, half, self.scale, self._type), (left, top))

    def trim(self, radius: float = 14.0) -> None:
        """Take away what reaches over the round corners of a panel."""
        shape = _panel(self.surface.get_size(), self.scale, radius, _WHITE, _WHITE)
        self.surface.blit(shape, (0, 0), special_flags=pygame.BLEND_RGBA_MULT)

    def text(
        self,
        text: str,
        x: float,
        y: float,
        size: float,
        colour: Rgba,
        weight: int = REGULAR,
        anchor: str = "left",
        room: float | None = None,
    ) -> float:
        """One line with its baseline at y; anchor left, centre or right of x. Returns its width in design units."""
        size_px = max(4, round(size * self.scale))
        shown = clean(text) if room is None else fit(text, size_px, weight, int(room * self.scale))
        if not shown:
            return 0.0
        wide_px = width(shown, size_px, weight)
        rendered, baseline = self._type.render(shown, size_px, weight, colour)
        margin = (rendered.get_width() - wide_px) // 2
        left = (x - self._origin[0]) * self.scale - {"left": 0.0, "centre": 0.5, "right": 1.0}[anchor] * wide_px
        self.surface.blit(rendered, (round(left) - margin, round((y - self._origin[1]) * self.scale) - baseline))
        return wide_px / self.scale

    def text_width(self, text: str, size: float, weight: int = REGULAR) -> float:
        return width(clean(text), max(4, round(size * self.scale)), weight) / self.scale

    def _stamp(self, points: Points, thickness: float, colour: Rgba, paint: Paint) -> None:
        """Coverage of the shape's own rectangle, laid over what is there in its colour."""
        rows = points if isinstance(points, np.ndarray) else np.array(list(points), np.float64).reshape(-1, 2)
        at = np.minimum(np.maximum((rows - self._origin) * self.scale - 0.5, -_FAR_PX), _FAR_PX)
        pad = thickness / 2 + 2
        (low_x, low_y), (high_x, high_y) = np.minimum.reduce(at).tolist(), np.maximum.reduce(at).tolist()
        wide, high = self.surface.get_size()
        left, top = max(0, floor(low_x - pad)), max(0, floor(low_y - pad))
        right, bottom = min(wide, ceil(high_x + pad) + 1), min(high, ceil(high_y + pad) + 1)
        if right <= left or bottom <= top:
            return
        mask = np.zeros((bottom - top, right - left), np.uint8)
        paint(mask, np.rint((at - (left, top)) * (1 << _SHIFT)).astype(np.int32))
        self.surface.blit(tinted(mask, colour), (left, top))


@lru_cache(maxsize=32)
def _panel(size_px: tuple[int, int], scale: float, radius: float, fill: Rgba, edge: Rgba) -> pygame.Surface:
    surface = pygame.Surface(size_px, pygame.SRCALPHA)
    surface.fill((*fill[:3], 0))
    ink = Ink(surface, scale, Type())
    wide, high = ink.size
    ink.box(0, 0, wide, high, fill, radius)
    if edge != fill:
        outline = rounded(0.5, 0.5, wide - 1, high - 1, radius - 0.5)
        ink.line([*outline, outline[0]], 1.0, edge)
    return surface


@lru_cache(maxsize=64)
def _layer(
    draw: Callable[..., None], key: tuple[Hashable, ...], size_px: tuple[int, int], scale: float, kind: Type
) -> pygame.Surface:
    surface = pygame.Surface(size_px, pygame.SRCALPHA)
    draw(Ink(surface, scale, kind), *key)
    return surface


@lru_cache(maxsize=256)
def _sign(draw: Callable[..., None], key: tuple[Hashable, ...], half_px: int, scale: float, kind: Type) -> pygame.Surface:
    """(0, 0) in the middle of its middle pixel."""
    surface = pygame.Surface((2 * half_px + 1, 2 * half_px + 1), pygame.SRCALPHA)
    middle = -(half_px + 0.5) / scale
    draw(Ink(surface, scale, kind, (middle, middle)), *key)
    return surface


@lru_cache(maxsize=256)
def _unit_arc(begin: float, end: float) -> Rows:
    """Points on a circle of radius 1, close enough together to look round at any window size."""
    count = max(2, ceil(abs(end - begin) / (2 * pi) * 96))
    angles = np.linspace(begin, end, count + 1)
    return np.stack((np.cos(angles), np.sin(angles)), axis=1)


def arc(x: float, y: float, radius: float, begin: float, end: float) -> Rows:
    """(N, 2) points on a circle, from angle to angle (radians, clockwise on screen from three o'clock)."""
    return radius * _unit_arc(begin, end) + (x, y)


_ROUND = np.concatenate([_unit_arc(quarter * pi / 2, (quarter + 1) * pi / 2) for quarter in range(4)])


@lru_cache(maxsize=1024)
def rounded(x: float, y: float, wide: float, high: float, radius: float) -> Rows:
    """(N, 2) outline of a box with round corners, from the lower right one on."""
    left, top, right, bottom = x + radius, y + radius, x + wide - radius, y + high - radius
    corners = np.array(((right, bottom), (left, bottom), (left, top), (right, top)))
    return corners if radius <= 0 else radius * _ROUND + np.repeat(corners, len(_ROUND) // 4, axis=0)
