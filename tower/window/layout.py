"""Where everything stands, in design units scaled to the window. Pure; integers out.

Nothing stands on the road: between the horizon and the bonnet the middle of the picture stays free (`clear_zone`). Warnings
stand above the horizon, figures in the corners and over the last half metre before the bumper.
"""

from dataclasses import dataclass
from typing import NamedTuple

DESIGN_W, DESIGN_H = 1280.0, 720.0
FRAME = 12.0  # thickness of the coloured frame
MARGIN = 26.0  # of panels to the window's edge
_SMALLEST = 0.15  # scale below which nothing could be read or drawn


class Box(NamedTuple):
    """Pixels: left, top, width, height."""

    x: int
    y: int
    w: int
    h: int

    def overlaps(self, other: "Box") -> bool:
        return self.x < other.x + other.w and other.x < self.x + self.w and self.y < other.y + other.h and other.y < self.y + self.h


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    width_px: int
    height_px: int
    scale: float
    picture: Box  # where the picture goes, its shape kept
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


def layout(width_px: int, height_px: int, picture_shape: tuple[int, int] = (1280, 720)) -> Layout:
    """The layout of a window; `picture_shape` is width and height of the camera's picture."""
    scale = max(min(width_px / DESIGN_W, height_px / DESIGN_H), _SMALLEST)
    wide, high = width_px / scale, height_px / scale
    middle = wide / 2
    low = high - MARGIN

    def box(x: float, y: float, w: float, h: float) -> Box:
        return Box(round(x * scale), round(y * scale), max(1, round(w * scale)), max(1, round(h * scale)))

    return Layout(
        width_px=width_px,
        height_px=height_px,
        scale=scale,
        picture=_letterbox(width_px, height_px, picture_shape),
        tab=box(middle - 210, 0, 420, 58),
        subtitle=box(middle - 330, 66, 660, 36),
        card=box(middle - 320, 68, 640, 197),
        operator=box(MARGIN, MARGIN, 280, 170),
        link=box(wide - MARGIN - 280, MARGIN, 280, 182),
        dial=box(MARGIN, low - 214, 248, 214),
        controls=box(middle - 220, low - 92, 440, 92),
        map=box(wide - MARGIN - 248, low - 214, 248, 214),
        briefing=box(MARGIN, MARGIN + 178, 262, 254),
        help=box(MARGIN, MARGIN, 322, 448),
        toast=box(middle - 340, low - 92 - 48, 680, 40),
        end=box(middle - 290, high / 2 - 202, 580, 404),
        clear_zone=box(middle - 350, high * 0.37, 700, high * 0.46),
    )


def _letterbox(width_px: int, height_px: int, shape: tuple[int, int]) -> Box:
    zoom = min(width_px / shape[0], height_px / shape[1])
    w, h = max(1, round(shape[0] * zoom)), max(1, round(shape[1] * zoom))
    return Box((width_px - w) // 2, (height_px - h) // 2, w, h)
