"""The tab that says who drives, and the line beneath it. Draws; decides nothing."""

from math import pi

from tower.window.fonts import BOLD, REGULAR
from tower.window.ink import XY, Ink, arc
from tower.window.layout import SUBTITLE_H
from tower.window.looks import Look
from tower.window.palette import DIM, PANEL, TEXT, TONES, Rgba
from tower.window.signs import SIGNS
from tower.window.views import BannerView, Tone

_DARK: Rgba = (12, 14, 18, 255)


def draw_tab(ink: Ink, look: Look) -> None:
    """Words and sign on the mode's colour, hanging from the top edge."""
    wide, high = ink.size
    inked: Rgba = (*look.ink, 255)
    size = 29.0
    words = ink.text_width(look.words, size, BOLD)
    needed = min(words + 96, wide)
    left = (wide - needed) / 2
    ink.polygon(_hanging(left - 3, needed + 6, high, 20), _DARK)
    ink.polygon(_hanging(left, needed, high - 3, 17), (*look.colour, 255))
    SIGNS[look.sign](ink, left + 40, high / 2 - 1, inked, (*look.colour, 255))
    ink.text(look.words, left + 68, high / 2 + 9, size, inked, BOLD)


def _hanging(left: float, wide: float, high: float, radius: float) -> list[XY]:
    return [
        (left, -1),
        (left + wide, -1),
        *arc(left + wide - radius, high - radius, radius, 0, pi / 2),
        *arc(left + radius, high - radius, radius, pi / 2, pi),
    ]


_SIZE, _GAP, _PAD, _LINE = 18.0, 24.0, 18.0, 36.0  # of the words beneath the tab


def draw_subtitle(ink: Ink, view: BannerView) -> None:
    """Cause and hint beneath the tab, in one calm line or, where it is too short for both, in one each: neither is cut off."""
    wide, _ = ink.size
    room = wide - 2 * _PAD
    cause, hint = (min(ink.text_width(text, _SIZE), room) if text else 0.0 for text in (view.cause, view.hint))
    colour = DIM if view.tone is Tone.CALM else TONES[view.tone]
    lines = [(view.cause, cause, colour), (view.hint, hint, TEXT)]
    if cause and hint and cause + _GAP + hint > room:
        broad = max(cause, hint)
        ink.box((wide - broad) / 2 - _PAD, 0, broad + 2 * _PAD, SUBTITLE_H, PANEL, _LINE / 2)
        for number, (text, width, tint) in enumerate(lines):
            ink.text(text, wide / 2, 23.5 + number * 26, _SIZE, tint, REGULAR, "centre", room=width + 2)
        return
    total = cause + hint + (_GAP if cause and hint else 0.0)
    if not total:
        return
    left = (wide - total) / 2
    ink.box(left - _PAD, 0, total + 2 * _PAD, _LINE, PANEL, _LINE / 2)
    ink.text(view.cause, left, _LINE / 2 + 6.5, _SIZE, colour, REGULAR, room=cause + 2)
    if cause and hint:
        ink.disc(left + cause + _GAP / 2, _LINE / 2 + 0.5, 2.0, DIM)
    ink.text(view.hint, left + total - hint, _LINE / 2 + 6.5, _SIZE, TEXT, REGULAR, room=hint + 2)
