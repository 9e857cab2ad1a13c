"""Bands across the window's edges that say what this is not: a live drive (a replay), or real time. Draws; decides nothing.

White with black words, as nothing else in the window is: it must never be mistaken for the real thing, by anyone, in any mode.
"""

import pygame

from tower.window.fonts import BOLD, CAP_SHARE, MEDIUM, Type
from tower.window.ink import Ink
from tower.window.layout import DESIGN_H, DESIGN_W
from tower.window.palette import Rgba

_HIGH = 26.0  # design units: as high as the panels' distance from the window's edge
_BAND: Rgba = (255, 255, 255, 255)
_INK: Rgba = (0, 0, 0, 255)
_TAB_HALF = 216.0  # who drove is read between the two words at the top


class Mark:
    """Keeps the bands of one window size."""

    def __init__(self, sentence: str, word: str = "") -> None:
        """sentence: along the bottom; word: twice along the top; "": nothing there."""
        self._sentence, self._word = sentence, word
        self._type = Type()
        self._size = (0, 0)
        self._bands: tuple[tuple[pygame.Surface, tuple[int, int]], ...] = ()

    def draw(self, surface: pygame.Surface) -> None:
        """Over everything else."""
        if surface.get_size() != self._size:
            self._size = surface.get_size()
            self._bands = self._drawn(*self._size)
        for band, place in self._bands:
            surface.blit(band, place)

    def _drawn(self, wide: int, high: int) -> tuple[tuple[pygame.Surface, tuple[int, int]], ...]:
        scale = max(min(wide / DESIGN_W, high / DESIGN_H), 0.15)
        rows = max(8, round(_HIGH * scale))
        side = max(1, round(wide / 2 - _TAB_HALF * scale))
        bottom = self._band(wide, rows, scale, self._sentence, MEDIUM, 20.0), (0, high - rows)
        if not self._word:
            return (bottom,)
        top = self._band(side, rows, scale, self._word, BOLD, 24.0)
        return bottom, (top, (0, 0)), (top, (wide - side, 0))

    def _band(self, wide: int, rows: int, scale: float, words: str, weight: int, size: float) -> pygame.Surface:
        band = pygame.Surface((wide, rows))
        band.fill(_BAND[:3])
        ink = Ink(band, scale, self._type)
        ink.text(words, ink.size[0] / 2, (_HIGH + size * CAP_SHARE) / 2, size, _INK, weight, anchor="centre", room=ink.size[0] - 12)
        return band


def replay_mark(recording: str) -> Mark:
    return Mark(f"REPLAY   {recording}   nothing here can be driven", "REPLAY - NOT LIVE")


def slow_motion_mark(real_time_factor: float) -> Mark:
    return Mark(f"SLOW MOTION   {real_time_factor:.0%} of real time")
