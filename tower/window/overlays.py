"""What stands over the picture: FROZEN and its kin, a toast, the key help. Draws; decides nothing."""

from collections.abc import Sequence

from tower.window.fonts import BOLD, MEDIUM, REGULAR
from tower.window.ink import Ink
from tower.window.keys import BINDINGS
from tower.window.layout import Box
from tower.window.looks import AMBER
from tower.window.palette import DIM, PANEL, TEXT, Rgba
from tower.window.picture_age import PictureState
from tower.window.views import PictureView

_AMBER: Rgba = (*AMBER, 255)
_BLACK: Rgba = (12, 14, 18, 255)


def draw_picture_state(ink: Ink, view: PictureView) -> None:
    """A tape across the middle with the word in it; NONE is calmer: there is nothing to be mistaken for now."""
    wide, high = ink.size
    if view.state is PictureState.NONE:
        ink.text(view.title, wide / 2, high / 2, 40, TEXT, MEDIUM, "centre", room=wide)
        ink.text(view.detail, wide / 2, high / 2 + 34, 19, DIM, REGULAR, "centre", room=wide)
        return
    ink.box(0, 0, wide, high, (*_BLACK[:3], 236))
    for top in (0.0, high - 14):
        for i in range(-1, int(wide / 28) + 1):
            x = i * 28.0
            ink.polygon([(x + 14, top), (x + 28, top), (x + 14, top + 14), (x, top + 14)], _AMBER)
    ink.text(view.title, wide / 2, high / 2 + 12, 68, _AMBER, BOLD, "centre", room=wide)
    ink.text(view.detail, wide / 2, high / 2 + 47, 22, TEXT, MEDIUM, "centre", room=wide)


_TAG_W, _TAG_H, _TAG_GAP = 190.0, 34.0, 6.0


def tag_box(picture: Box, scale: float, panels: Sequence[Box]) -> Box:
    """Where the tag of a side or rear picture stands: in its middle, no wider than it, or the nearest place above or below that no
    panel covers."""
    w, h = max(1, min(round(_TAG_W * scale), picture.w)), max(1, round(_TAG_H * scale))
    middle = Box(picture.x + (picture.w - w) // 2, picture.y + (picture.h - h) // 2, w, h)
    gap = round(_TAG_GAP * scale)
    heights = [middle.y, *(y for panel in panels for y in (panel.y - gap - h, panel.y + panel.h + gap))]
    inside = [middle._replace(y=y) for y in heights if picture.y <= y <= picture.y + picture.h - h]
    free = [box for box in inside if not any(box.overlaps(panel) for panel in panels)]
    return min(free, key=lambda box: abs(box.y - middle.y), default=middle)


def draw_tag(ink: Ink, text: str) -> None:
    """FROZEN or NO PICTURE over one camera's picture."""
    wide, high = ink.size
    ink.box(0, 0, wide, high, (*_BLACK[:3], 236), 6)
    ink.text(text, wide / 2, high / 2 + 7, 18, _AMBER, BOLD, "centre", room=wide - 10)


def draw_toast(ink: Ink, text: str) -> None:
    wide, high = ink.size
    needed = min(ink.text_width(text, 20, MEDIUM) + 48, wide)
    left = (wide - needed) / 2
    ink.box(left, 0, needed, high, _AMBER, high / 2)
    ink.text(text, wide / 2, high / 2 + 7, 20, _BLACK, MEDIUM, "centre", room=needed - 30)


def draw_help(ink: Ink) -> None:
    wide, high = ink.size
    ink.box(0, 0, wide, high, (*PANEL[:3], 250), 14)
    row = (high - 26) / len(BINDINGS)
    for i, binding in enumerate(BINDINGS):
        y = 13 + row * (i + 0.72)
        ink.text(binding.label, 16, y, 16, TEXT, MEDIUM, room=86)
        ink.text(binding.control.value, 106, y, 16, DIM, REGULAR, room=238)
