"""Speed as the driver reads it: large figures, an arc with the cap's mark, gear and indicators. Draws a DialView."""

from math import cos, pi, sin

from tower.window.fonts import BOLD, MEDIUM, REGULAR
from tower.window.ink import Ink
from tower.window.looks import AMBER
from tower.window.palette import DIM, FAINT, INDICATOR, TEXT, TRACK, Rgba
from tower.window.views import DialView
from wire.messages.base import Gear

_BEGIN, _SWEEP = 0.75 * pi + 0.12, 1.5 * pi - 0.24  # clockwise from lower left to lower right
_X, _Y, _RADIUS = 124.0, 102.0, 80.0
_CAP: Rgba = (*AMBER, 255)
_BEYOND: Rgba = (*AMBER, 88)
_GEARS = ((Gear.PARK, "P"), (Gear.REVERSE, "R"), (Gear.NEUTRAL, "N"), (Gear.DRIVE, "D"))


def draw_dial(ink: Ink, view: DialView) -> None:
    ink.layer(_draw_background, view.scale_km_h, view.gear if view.fresh else None, view.lamps, view.left_lit, view.right_lit)
    if view.fresh:
        ink.ring(_X, _Y, _RADIUS, 9, TEXT, _BEGIN, _angle(abs(view.speed_km_h), view.scale_km_h))
    if view.cap_km_h is not None:
        _draw_cap(ink, view.cap_km_h, abs(view.speed_km_h), view.scale_km_h)
    ink.text(f"{abs(view.speed_km_h):.0f}" if view.fresh else "–", _X, _Y + 20, 66, TEXT, MEDIUM, "centre")


def _draw_background(ink: Ink, scale_km_h: int, gear: Gear | None, lamps: str, left_lit: bool, right_lit: bool) -> None:
    """All but the speed and its cap."""
    ink.panel()
    ink.ring(_X, _Y, _RADIUS, 9, TRACK, _BEGIN, _BEGIN + _SWEEP)
    _draw_scale(ink, scale_km_h)
    ink.text("km/h", _X, _Y + 42, 18, DIM, REGULAR, "centre")
    _draw_gears(ink, gear)
    ink.text(lamps, _X, 174, 18, TEXT, MEDIUM, "centre", room=224)
    for side, lit in ((-1, left_lit), (1, right_lit)):
        _draw_indicator(ink, _X + side * 98, 26, side, INDICATOR if lit else FAINT)


def _angle(km_h: float, scale_km_h: int) -> float:
    return _BEGIN + _SWEEP * min(max(km_h / scale_km_h, 0.0), 1.0)


def _draw_scale(ink: Ink, scale_km_h: int) -> None:
    step = 10 if scale_km_h <= 60 else 50
    for mark in range(0, scale_km_h + 1, step):
        at = _angle(mark, scale_km_h)
        ink.line([(_X + r * cos(at), _Y + r * sin(at)) for r in (_RADIUS - 14, _RADIUS - 9)], 1.5, DIM)


def _draw_cap(ink: Ink, cap_km_h: float, speed_km_h: float, scale_km_h: int) -> None:
    """Beyond the cap the arc is amber; a bar across the arc marks it, and the figure says it."""
    at = _angle(cap_km_h, scale_km_h)
    ink.ring(_X, _Y, _RADIUS, 9, _BEYOND, max(at, _angle(speed_km_h, scale_km_h)), _BEGIN + _SWEEP)
    ink.line([(_X + r * cos(at), _Y + r * sin(at)) for r in (_RADIUS - 8, _RADIUS + 12)], 4, _CAP)
    ink.text(f"cap {cap_km_h:.0f}", _X, _Y - 38, 20, _CAP, MEDIUM, "centre")


def _draw_gears(ink: Ink, gear: Gear | None) -> None:
    for i, (which, letter) in enumerate(_GEARS):
        x, y = _X - 51 + i * 34, 198.0
        if which is gear:
            ink.box(x - 14, y - 17, 28, 24, TEXT, 7)
        ink.text(letter, x, y + 2, 18, (13, 17, 23, 255) if which is gear else DIM, BOLD if which is gear else MEDIUM, "centre")


def _draw_indicator(ink: Ink, x: float, y: float, side: int, colour: Rgba) -> None:
    ink.polygon(
        [(x + side * 13, y), (x, y - 11), (x, y - 5), (x - side * 11, y - 5), (x - side * 11, y + 5), (x, y + 5), (x, y + 11)],
        colour,
    )
