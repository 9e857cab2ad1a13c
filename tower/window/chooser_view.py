"""The page of the cars to choose from: a row each, with the marked one framed. Draws a ChooserView; decides nothing."""

import pygame

from tower.window.chooser import CarRow, ChooserView
from tower.window.fonts import BOLD, MEDIUM, Type
from tower.window.ink import Ink
from tower.window.layout import DESIGN_H, DESIGN_W
from tower.window.overlays import draw_toast
from tower.window.palette import ASKED, DIM, PANEL_EDGE, TEXT, TONES, Rgba
from tower.window.signs import SIGNS
from tower.window.views import Tone

_GROUND: Rgba = (20, 25, 33, 255)
_ROW_FILL: Rgba = (13, 17, 23, 255)
_LEFT, _TOP, _ROW, _GAP = 60.0, 110.0, 100.0, 12.0
_SHOWN = 5  # rows: more than fit stand around the marked one
_BADGE_W, _NAME_W = 244.0, 326.0


def draw_chooser(surface: pygame.Surface, view: ChooserView, kind: Type) -> None:
    """Onto the whole of the window."""
    wide_px, high_px = surface.get_size()
    scale = max(min(wide_px / DESIGN_W, high_px / DESIGN_H), 0.15)
    surface.fill(_GROUND[:3])
    ink = Ink(surface, scale, kind)
    wide, high = ink.size
    ink.text("Which car?", _LEFT, 74, 36, TEXT, BOLD)
    ink.text("Up, down: choose    Enter or A: join    Esc: quit", wide - _LEFT, 74, 20, DIM, MEDIUM, "right", room=wide - 380)
    first = first_shown([row.marked for row in view.rows])
    for i, row in enumerate(view.rows[first : first + _SHOWN]):
        _draw_row(ink, row, _TOP + i * (_ROW + _GAP), wide - 2 * _LEFT)
    if len(view.rows) > _SHOWN:
        text = f"{first + 1} to {min(first + _SHOWN, len(view.rows))} of {len(view.rows)}"
        ink.text(text, _LEFT, high - 26, 20, DIM, MEDIUM)
    if view.asking:
        others = f" and {len(view.asking) - 1} more" if len(view.asking) > 1 else ""
        ink.text(
            f"Asking for an operator: {view.asking[0]}{others}", wide - _LEFT, high - 26, 20, TONES[Tone.WARN], MEDIUM, "right"
        )
    if view.toast:
        _draw_toast(surface, view.toast, scale, kind)


def first_shown(marked: list[bool]) -> int:
    """The number of the first row on the page, so that the marked one is among them."""
    at = marked.index(True) if True in marked else 0
    return min(max(at - _SHOWN // 2, 0), max(len(marked) - _SHOWN, 0))


def _draw_row(ink: Ink, row: CarRow, y: float, wide: float) -> None:
    if row.marked:
        ink.box(_LEFT - 5, y - 5, wide + 10, _ROW + 10, ASKED, 18)
    ink.box(_LEFT, y, wide, _ROW, PANEL_EDGE if not row.marked else _ROW_FILL, 14)
    ink.box(_LEFT + 1, y + 1, wide - 2, _ROW - 2, _ROW_FILL, 13)
    _draw_badge(ink, row, y)
    left = _LEFT + _BADGE_W + 24
    right = _LEFT + wide - 22
    size = 28 if ink.text_width(row.name, 28, BOLD) <= _NAME_W else 20
    ink.text(row.name, left, y + 42, size, TEXT, BOLD, room=_NAME_W)
    ink.text(row.speed, left + 336, y + 41, 22, TEXT, MEDIUM, room=110)
    if row.operator:
        ink.text(f"Operator: {row.operator}", left + 456, y + 41, 20, TEXT, MEDIUM, room=right - left - 456 - 128)
    ink.text(row.link, right, y + 41, 20, TONES[row.link_tone], MEDIUM, "right", room=120)
    ink.text(row.note, left, y + 78, 20, DIM if row.note_tone is Tone.CALM else TONES[row.note_tone], MEDIUM, room=right - left)


def _draw_badge(ink: Ink, row: CarRow, y: float) -> None:
    """Sign and words on the mode's colour: not colour alone."""
    colour: Rgba = (*row.look.colour, 255)
    inked: Rgba = (*row.look.ink, 255)
    ink.box(_LEFT + 1, y + 1, _BADGE_W, _ROW - 2, colour, 13)
    SIGNS[row.look.sign](ink, _LEFT + 38, y + _ROW / 2, inked, colour)
    ink.text(row.words, _LEFT + 66, y + _ROW / 2 + 8, 22, inked, BOLD, room=_BADGE_W - 74)


def _draw_toast(surface: pygame.Surface, text: str, scale: float, kind: Type) -> None:
    wide, high = surface.get_size()
    toast = pygame.Surface((min(round(680 * scale), wide), round(40 * scale)), pygame.SRCALPHA)
    draw_toast(Ink(toast, scale, kind), text)
    surface.blit(toast, ((wide - toast.get_width()) // 2, high - round(64 * scale)))
