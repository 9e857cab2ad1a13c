"""Draws a RoadView onto the picture: the strip the car will sweep, the stopping line, the corridor, the place of the request, and
what the planner weighs.

Cut off above the bonnet, and never opaque where the road is: an operator looks through it. Draws; decides nothing.
"""

from collections.abc import Sequence

import pygame

from tower.window.fonts import MEDIUM, Type, width
from tower.window.layout import Box
from tower.window.looks import AMBER, BLUE, VERMILION
from tower.window.paint import Pixels, fill, ordered, pixels_within, stroke
from tower.window.palette import Rgba
from tower.window.projection import GroundCamera
from tower.window.views import LineKind, RoadView
from wire.planner_colours import CLASSES

XY = tuple[float, float]
Colour = tuple[int, int, int]
Label = tuple[str, XY, Colour]
_SHOWN_TO = 0.80  # of the picture's height: below it are the bonnet and the panels
_CASING = (12, 14, 18)
_EDGE = (244, 247, 250)
_FILL_SHARE = 0.26
_THICK = {  # design units
    LineKind.UNCERTAINTY: 1.0,
    LineKind.PERSON: 0.8,
    LineKind.GUIDANCE: 0.8,
    LineKind.NOT_FEASIBLE: 1.2,
    LineKind.TRAJECTORY: 2.0,
    LineKind.CHOSEN: 4.5,
}
_LABEL_SIZE = 20.0  # design units
_MARK_M = 2.0  # height of the pole over the place of a request
_LABEL: Rgba = (12, 14, 18, 255)


class RoadPainter:
    """Keeps the projection of one calibration."""

    def __init__(self) -> None:
        self._camera: GroundCamera | None = None
        self._of: object = None

    def draw(self, surface: pygame.Surface, box: Box, view: RoadView, scale: float, kind: Type) -> None:
        """box  of the picture on the surface, pixels"""
        if self._of != view.camera or self._camera is None:
            self._camera, self._of = GroundCamera(view.camera), view.camera
        shown = box._replace(h=round(box.h * _SHOWN_TO))
        for text, at, colour in _painted(surface, shown, view, self._camera, box.w / view.camera.width_px, scale):
            _label(surface, shown, text, at, colour, scale, kind)


def _painted(surface: pygame.Surface, shown: Box, view: RoadView, camera: GroundCamera, zoom: float, scale: float) -> list[Label]:
    """The labels that are still to be drawn: text can be blitted only once the surface is unlocked, after the return."""
    with pixels_within(surface, shown) as pixels:
        if pixels is None:
            return []
        pen = _Pen(pixels, surface, camera, zoom, scale)
        _draw_planned(pen, view)
        _draw_corridor(pen, view)
        labels = _draw_path(pen, view)
        _draw_blind_end(pen, view)
        return [*labels, *_draw_place(pen, view)]


class _Pen:
    """Strokes in metres on the road, widths in design units."""

    def __init__(self, pixels: Pixels, surface: pygame.Surface, camera: GroundCamera, zoom: float, scale: float) -> None:
        self.pixels, self._surface, self._camera, self._zoom, self._scale = pixels, surface, camera, zoom, scale

    def at(self, points: Sequence[XY]) -> list[XY]:
        return [(x * self._zoom, y * self._zoom) for x, y in self._camera.line(points)]

    def above(self, point: XY, high_m: float) -> XY | None:
        pixel = self._camera.pixel(*point, high_m)
        return None if pixel is None else (pixel[0] * self._zoom, pixel[1] * self._zoom)

    def line(self, points: Sequence[XY], thick: float, colour: Colour) -> None:
        """With a dark casing, so that it is seen on snow and on asphalt."""
        stroke(self.pixels, points, ordered(_CASING, self._surface), round((thick + 2.5) * self._scale))
        stroke(self.pixels, points, ordered(colour, self._surface), round(thick * self._scale))

    def area(self, points: Sequence[XY], colour: Colour, share: float) -> None:
        if len(points) > 2:
            fill(self.pixels, points, ordered(colour, self._surface), share)


def _draw_planned(pen: _Pen, view: RoadView) -> None:
    """A hair for a guidance, thin for what could be driven of it, broken for what could not, thick for what is."""
    for line in view.planned:
        colour = _EDGE if line.colour is None else CLASSES[line.colour % len(CLASSES)]
        for piece in _broken(line.points) if line.kind is LineKind.NOT_FEASIBLE else [line.points]:
            pen.line(pen.at(piece), _THICK[line.kind], colour)


def _broken(points: Sequence[XY]) -> list[Sequence[XY]]:
    """Every second piece."""
    return [points[k : k + 2] for k in range(0, len(points) - 1, 2)]


def _draw_path(pen: _Pen, view: RoadView) -> list[Label]:
    """Two edges, filled between them up to the stopping line; a preview has no fill and thin edges."""
    if view.until_stop is None or view.whole is None:
        return []
    left, right = pen.at(view.until_stop.left), pen.at(view.until_stop.right)
    if view.driving:
        pen.area([*left, *reversed(right)], BLUE, _FILL_SHARE)
    for edge in (view.whole.left, view.whole.right):
        pen.line(pen.at(edge), 2.5 if view.driving else 1.5, _EDGE)
    if not left or not right:
        return []
    pen.line([left[-1], right[-1]], 5.0, AMBER)
    seen = max(left[-1][1], right[-1][1]) < pen.pixels.shape[0]
    return [(view.stop_text, max(left[-1], right[-1]), AMBER)] if seen else []


def _draw_corridor(pen: _Pen, view: RoadView) -> None:
    """The way of a stop by itself: filled while the car takes it, else its edges alone; a line where the car would stand."""
    if view.corridor is not None:
        left, right = pen.at(view.corridor.left), pen.at(view.corridor.right)
        if view.stopping:
            pen.area([*left, *reversed(right)], VERMILION, _FILL_SHARE)
        for edge in (left, right):
            pen.line(edge, 3.0 if view.stopping else 1.5, VERMILION)


def _draw_blind_end(pen: _Pen, view: RoadView) -> None:
    if view.blind_end is not None:
        pen.line(pen.at(view.blind_end), 5.0, VERMILION)


def _draw_place(pen: _Pen, view: RoadView) -> list[Label]:
    """A pole with a diamond over the place, dug into the road by a ring; at the picture's edge when it lies outside."""
    if view.place is None:
        return []
    foot, top = pen.above(view.place, 0.0), pen.above(view.place, _MARK_M)
    if foot is None or top is None:
        return []
    high, wide = pen.pixels.shape[:2]
    if not (0 <= foot[0] < wide and 0 <= top[1] < high):
        return []
    size = 9.0 * pen._scale
    pen.line([foot, top], 2.5, AMBER)
    diamond = [(top[0], top[1] - size), (top[0] + size, top[1]), (top[0], top[1] + size), (top[0] - size, top[1])]
    pen.area(diamond, AMBER, 1.0)
    pen.line([*diamond, diamond[0]], 1.5, _EDGE)
    return [(view.place_text, (top[0] + size, top[1]), AMBER)]


def _label(surface: pygame.Surface, shown: Box, text: str, at: XY, colour: Colour, scale: float, kind: Type) -> None:
    """Dark words on the colour, right of a point; kept within the picture."""
    size_px = max(4, round(_LABEL_SIZE * scale))
    words, baseline = kind.render(text, size_px, MEDIUM, _LABEL)
    wide, high = width(text, size_px, MEDIUM), round(size_px * 1.3)
    pad = round(7 * scale)
    left = shown.x + min(max(round(at[0]) + pad, 0), max(shown.w - wide - 2 * pad, 0))
    top = shown.y + min(max(round(at[1]) - high // 2, 0), max(shown.h - high, 0))
    pygame.draw.rect(surface, colour, (left, top, wide + 2 * pad, high), border_radius=high // 3)
    surface.blit(words, (left + pad - (words.get_width() - wide) // 2, top + round(size_px * 1.02) - baseline))
