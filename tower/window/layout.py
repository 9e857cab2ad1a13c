"""Where everything stands, in design units scaled to the window. Pure; integers out.

Nothing stands on the road: between the horizon and the bonnet the middle of the picture stays free (`clear_zone`). Warnings
stand above the horizon, figures in the corners and over the last half metre before the bumper.
"""

from collections.abc import Mapping
from dataclasses import dataclass

from tower.window.picture_layout import ASSUMED, FRONT, Box, Shape, places

__all__ = ["Box", "Layout", "layout"]
DESIGN_W, DESIGN_H = 1280.0, 720.0
FRAME = 12.0  # thickness of the coloured frame
SUBTITLE_H = 62.0  # of two lines
MARGIN = 26.0  # of panels to the window's edge
_SMALLEST = 0.15  # scale below which nothing could be read or drawn


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    width_px: int
    height_px: int
    scale: float
    pictures: dict[str, Box]  # where each camera's picture goes; the front one, `pictures[FRONT]`, is always there
    tab: Box  # who drives
    subtitle: Box
    card: Box
    operator: Box
    link: Box
    dial: Box
    controls: Box
    map: Box
    briefing: Box
    help: Box
    toast: Box
    end: Box
    clear_zone: Box


def layout(width_px: int, height_px: int, shapes: Mapping[str, Shape] = ASSUMED) -> Layout:
    """The layout of a window; `shapes`: width and height of the picture of each camera to be shown, the front one among them."""
    scale = max(min(width_px / DESIGN_W, height_px / DESIGN_H), _SMALLEST)
    wide, high = width_px / scale, height_px / scale
    middle = wide / 2
    low = high - MARGIN
    pictures = places(width_px, height_px, shapes, scale)

    def box(x: float, y: float, w: float, h: float) -> Box:
        return Box(round(x * scale), round(y * scale), max(1, round(w * scale)), max(1, round(h * scale)))

    return Layout(
        width_px=width_px,
        height_px=height_px,
        scale=scale,
        pictures=pictures,
        tab=box(middle - 210, 0, 420, 58),
        subtitle=box(middle - 330, 66, 660, SUBTITLE_H),
        card=box(middle - 320, 68, 640, 197),
        operator=box(MARGIN, MARGIN, 280, 170),
        link=box(wide - MARGIN - 280, MARGIN, 280, 206),
        dial=box(MARGIN, low - 214, 248, 214),
        controls=box(middle - 220, low - 92, 440, 92),
        map=box(wide - MARGIN - 248, low - 214, 248, 214),
        briefing=box(MARGIN, MARGIN + 178, 262, 274),
        help=box(MARGIN, MARGIN, 354, 448),
        toast=box(middle - 340, low - 92 - 48, 680, 40),
        end=box(middle - 290, high / 2 - 202, 580, 404),
        clear_zone=_clear_zone(pictures[FRONT]),
    )


def _clear_zone(front: Box) -> Box:
    """Of the front picture: the road, from the horizon to the bonnet."""
    left, top = round(front.x + front.w * 0.23), round(front.y + front.h * 0.37)
    return Box(left, top, max(1, round(front.w * 0.54)), max(1, round(front.h * 0.46)))
