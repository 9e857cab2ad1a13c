"""The tab that says who drives, and the line beneath it. Draws; decides nothing."""

from math import pi

from tower.window.fonts import BOLD, REGULAR
from tower.window.ink import XY, Ink, arc
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


def draw_subtitle(ink: Ink, view: BannerView) -> None:
    """Cause and hint in one calm line beneath the tab."""
    if not view.cause and not view.hint:
        return
    wide, high = ink.size
    size, gap, pad = 18.0, 24.0, 18.0
    cause = min(ink.text_width(view.cause, size), wide - 2 * pad) if view.cause else 0.0
    room = wide - 2 * pad - (cause + gap if cause else 0.0)
    hint = min(ink.text_width(view.hint, size), room) if room > 60 else 0.0
    total = cause + hint + (gap if cause and hint else 0.0)
    left = (wide - total) / 2
    ink.box(left - pad, 0, total + 2 * pad, high, PANEL, high / 2)
    ink.text(view.cause, left, high / 2 + 6.5, size, DIM if view.tone is Tone.CALM else TONES[view.tone], REGULAR, room=cause + 2)
    if cause and hint:
        ink.disc(left + cause + gap / 2, high / 2 + 0.5, 2.0, DIM)
    if hint:
        ink.text(view.hint, left + total - hint, high / 2 + 6.5, size, TEXT, REGULAR, room=hint + 2)
