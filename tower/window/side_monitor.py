"""The second of two monitors: the side pictures, whole, with a gap for what lies between. Draws; decides nothing.

One picture across two monitors would have the gap of the bezels in the middle of the road.
"""

from collections.abc import Mapping
from dataclasses import replace

import pygame

from tower.window.fonts import BOLD, Type
from tower.window.frame import frame_strips
from tower.window.ink import Ink
from tower.window.layout import layout
from tower.window.looks import Look
from tower.window.overlays import draw_tag, tag_box
from tower.window.palette import DIM
from tower.window.picture_layout import LEFT, RIGHT, Box, Shape
from tower.window.pictures import BEHIND, Frame, Pictures
from tower.window.views import ViewModel

_BETWEEN_SHARE = 0.03  # ours: of the width, so that nobody takes the two for one continuous view
_HEAD = 46.0  # design units: the name over each picture


def side_places(width_px: int, height_px: int, shapes: Mapping[str, Shape]) -> dict[str, Box]:
    """Each side picture whole, as large as half the monitor holds, its inner edge at the middle."""
    half, between = width_px // 2, round(width_px * _BETWEEN_SHARE / 2)
    boxes = {}
    for name in (LEFT, RIGHT):
        if name in shapes:
            wide, high = shapes[name]
            zoom = min((half - between) / wide, height_px / high)
            w, h = max(1, int(wide * zoom)), max(1, int(high * zoom))
            boxes[name] = Box(half - between - w if name == LEFT else half + between, (height_px - h) // 2, w, h)
    return boxes


class SideMonitor:
    """Keeps what it has scaled and drawn, like the Hud."""

    def __init__(self) -> None:
        self._pictures, self._type = Pictures(), Type()
        self._frame: tuple[Look, tuple[int, int], tuple[tuple[pygame.Surface, Box], ...]] | None = None

    def draw(self, surface: pygame.Surface, frames: Mapping[str, Frame], model: ViewModel) -> None:
        """surface: all of the second monitor."""
        sides = {name: view for name, view in model.cameras.items() if name in (LEFT, RIGHT)}
        boxes = side_places(*surface.get_size(), {name: view.shape for name, view in sides.items()})
        at = layout(*surface.get_size())
        surface.fill(BEHIND)
        self._pictures.draw(surface, frames, boxes, sides, dark=model.end is not None)
        for name, box in boxes.items():
            Ink(surface, at.scale, self._type).text(name, (box.x + box.w / 2) / at.scale, _HEAD, 20, DIM, BOLD, "centre")
            if sides[name].tag:
                place = tag_box(box, at.scale, ())
                tag = pygame.Surface((place.w, place.h), pygame.SRCALPHA)
                draw_tag(Ink(tag, at.scale, self._type), sides[name].tag)
                surface.blit(tag, (place.x, place.y))
        if self._frame is None or self._frame[:2] != (model.banner.look, surface.get_size()):
            self._frame = (model.banner.look, surface.get_size(), frame_strips(model.banner.look, at))
        for strip, box in self._frame[2]:
            surface.blit(strip, (box.x, box.y))


def without_sides(model: ViewModel) -> ViewModel:
    """For the first monitor, when there is a second one for the sides."""
    return replace(model, cameras={name: view for name, view in model.cameras.items() if name not in (LEFT, RIGHT)})
