"""REPLAY across the top and the bottom edge of the window: what is shown is a recording. Draws; decides nothing.

White with black words, as nothing else in the window is: it must never be mistaken for a live drive, by anyone, in any mode.
"""

import pygame

from tower.window.fonts import BOLD, CAP_SHARE, MEDIUM, Type
from tower.window.ink import Ink
from tower.window.layout import DESIGN_H, DESIGN_W
from tower.window.palette import Rgba

WORD = "REPLAY - NOT LIVE"
_HIGH = 26.0  # design units: as high as the panels' distance from the window's edge
_BAND: Rgba = (255, 255, 255, 255)
_INK: Rgba = (0, 0, 0, 255)
_TAB_HALF = 216.0  # who drove is read between the two words at the top


class ReplayMark:
    """Keeps the bands of one window size."""

    def __init__(self, recording: str) -> None:
        self._recording = recording
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
        bottom = self._band(wide, rows, scale, f"REPLAY   {self._recording}   nothing here can be driven")
        top = self._band(side, rows, scale, WORD)
        return (bottom, (0, high - rows)), (top, (0, 0)), (top, (wide - side, 0))

    def _band(self, wide: int, rows: int, scale: float, words: str) -> pygame.Surface:
        band = pygame.Surface((wide, rows))
        band.fill(_BAND[:3])
        ink = Ink(band, scale, self._type)
        weight, size = (BOLD, 24.0) if words == WORD else (MEDIUM, 20.0)
        ink.text(words, ink.size[0] / 2, (_HIGH + size * CAP_SHARE) / 2, size, _INK, weight, anchor="centre", room=ink.size[0] - 12)
        return band
