"""The whole window from a ViewModel: picture, frame, panels. A part is drawn again only when its view has changed.

Draws; decides nothing. Everything is plain surfaces, so a test or a screenshot needs no screen.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, TypeVar

import pygame

from tower.window.banner import draw_subtitle, draw_tab
from tower.window.briefing_view import briefing_height, draw_briefing
from tower.window.card_view import card_height, draw_card
from tower.window.checks_view import checklist_height, draw_checklist
from tower.window.controls_bar import draw_controls
from tower.window.dial import draw_dial
from tower.window.end_screen import draw_end
from tower.window.fonts import Type
from tower.window.frame import frame_strips
from tower.window.ink import Ink
from tower.window.layout import DESIGN_H, DESIGN_W, Box, Layout, layout
from tower.window.looks import Look
from tower.window.map_view import draw_map
from tower.window.overlays import draw_help, draw_picture_state, draw_tag, draw_toast, tag_box
from tower.window.panels import draw_link, draw_operator, operator_height
from tower.window.picture_layout import FRONT, bare
from tower.window.pictures import BEHIND, Frame, Pictures
from tower.window.road_view import RoadPainter
from tower.window.views import ViewModel

V = TypeVar("V")


class Hud:
    """Keeps the drawn parts of one window size."""

    def __init__(self) -> None:
        self._type = Type()
        self._road = RoadPainter()
        self._at: Layout | None = None
        self._parts: dict[str, tuple[object, pygame.Surface]] = {}
        self._frame: tuple[Look, tuple[tuple[pygame.Surface, Box], ...]] | None = None
        self._pictures = Pictures()
        self._turn = ""  # of the panels: which was drawn again last

    @property
    def text_sizes_px(self) -> frozenset[int]:
        return self._type.sizes_px

    @property
    def at(self) -> Layout:
        """Where everything stood when it was drawn last; of the design's own size before."""
        return self._at if self._at is not None else layout(round(DESIGN_W), round(DESIGN_H))

    def draw(self, surface: pygame.Surface, frames: Mapping[str, Frame], model: ViewModel) -> None:
        """Everything, bottom to top, onto the window's surface."""
        at = self._layout(surface, model)
        for box in bare(*surface.get_size(), at.pictures):
            surface.fill(BEHIND, box)
        self._pictures.draw(surface, frames, at.pictures, model.cameras, dark=model.end is not None)
        if model.road is not None and FRONT in frames:
            self._road.draw(surface, at.pictures[FRONT], model.road, at.scale, self._type)
        self._draw_panels(surface, at, model)
        self._draw_tags(surface, at, model)
        self._draw_overlays(surface, at, model)
        self._draw_frame(surface, at, model.banner.look)
        self._blit(surface, "tab", at.tab, model.banner.look, draw_tab)

    def _layout(self, surface: pygame.Surface, model: ViewModel) -> Layout:
        fresh = layout(*surface.get_size(), {name: view.shape for name, view in model.cameras.items()})
        if self._at is None or replace(fresh, pictures=self._at.pictures) != self._at:
            self._frame = None
            self._parts.clear()
        self._at = fresh
        return fresh

    def _draw_tags(self, surface: pygame.Surface, at: Layout, model: ViewModel) -> None:
        """What is wrong with a side or rear picture stands on it; of the front one the tape tells."""
        if model.end is not None:
            return
        panels = _side_panels(at, model)
        for name, view in model.cameras.items():
            box = at.pictures.get(name)
            if view.tag and name != FRONT and box is not None:
                self._blit(surface, f"tag {name}", tag_box(box, at.scale, panels), view.tag, draw_tag)

    def _draw_panels(self, surface: pygame.Surface, at: Layout, model: ViewModel) -> None:
        """One changed panel is drawn again per picture, in turn: nobody reads five of them thirty times a second."""
        panels: tuple[tuple[str, Box, Any, Callable[[Ink, Any], None]], ...] = (
            ("dial", at.dial, model.dial, draw_dial),
            ("controls", at.controls, model.controls, draw_controls),
            ("map", at.map, model.map, draw_map),
            ("operator", _operator_box(at, model), model.operator, draw_operator),
            ("link", at.link, model.link, draw_link),
        )
        changed = [name for name, _, view, _ in panels if name in self._parts and self._parts[name][0] != view]
        self._turn = next_turn(self._turn, [name for name, *_ in panels], changed)
        for name, box, view, draw in panels:
            waits = name in changed and name != self._turn
            self._blit(surface, name, box, self._parts[name][0] if waits else view, draw)

    def _draw_overlays(self, surface: pygame.Surface, at: Layout, model: ViewModel) -> None:
        if model.picture.title:
            front = at.pictures[FRONT]
            tape = Box(front.x, round(front.y + front.h * 0.40), front.w, max(1, round(150 * at.scale)))
            self._blit(surface, "state", tape, model.picture, draw_picture_state)
        if model.end is not None:
            self._blit(surface, "end", at.end, model.end, draw_end)
        elif model.card is not None:
            self._blit(surface, "card", _as_high(at.card, card_height(model.card), at), model.card, draw_card)
        else:
            self._blit(surface, "subtitle", at.subtitle, model.banner, draw_subtitle)
        left = _left_box(at, model)
        if left is not None and model.briefing is not None:
            self._blit(surface, "briefing", left, model.briefing, draw_briefing)
        elif left is not None and model.checklist is not None:
            self._blit(surface, "checklist", left, model.checklist, draw_checklist)
        if model.help_open:
            self._blit(surface, "help", at.help, None, lambda ink, _: draw_help(ink))
        if model.toast:
            self._blit(surface, "toast", at.toast, model.toast, draw_toast)

    def _draw_frame(self, surface: pygame.Surface, at: Layout, look: Look) -> None:
        if self._frame is None or self._frame[0] != look:
            self._frame = (look, frame_strips(look, at))
        for strip, box in self._frame[1]:
            surface.blit(strip, (box.x, box.y))

    def _blit(self, surface: pygame.Surface, name: str, box: Box, view: V, draw: Callable[[Ink, V], None]) -> None:
        kept = self._parts.get(name)
        if kept is None or kept[0] != view:
            fresh = pygame.Surface((box.w, box.h), pygame.SRCALPHA)
            draw(Ink(fresh, _scale(self._at), self._type), view)
            kept = self._parts[name] = (view, fresh)
        surface.blit(kept[1], (box.x, box.y))


def next_turn(last: str, names: list[str], changed: list[str]) -> str:
    """The first of the changed ones after the last one whose turn it was, round and round; the last one when none has changed."""
    begin = names.index(last) + 1 if last in names else 0
    return next((name for name in names[begin:] + names[:begin] if name in changed), last)


def _side_panels(at: Layout, model: ViewModel) -> list[Box]:
    """What stands over the side pictures."""
    left = _left_box(at, model)
    return [_operator_box(at, model), at.link, at.dial, at.map, *([left] if left is not None else [])]


def _operator_box(at: Layout, model: ViewModel) -> Box:
    return _as_high(at.operator, operator_height(model.operator), at)


def _left_box(at: Layout, model: ViewModel) -> Box | None:
    """Of the briefing, or of the checklist before it; None when neither is shown."""
    if model.end is not None:
        return None
    if model.briefing is not None:
        return _as_high(at.briefing, briefing_height(model.briefing, at.briefing.w / at.scale), at)
    return _as_high(at.briefing, checklist_height(model.checklist), at) if model.checklist is not None else None


def _as_high(box: Box, height: float, at: Layout) -> Box:
    """`height` in design units."""
    return box._replace(h=max(1, round(height * at.scale)))


def _scale(at: Layout | None) -> float:
    return at.scale if at is not None else 1.0
