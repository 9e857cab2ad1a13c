"""Steering and acceleration: what was requested beside what the car applied, and the rule between them. Draws a ControlsView."""

from tower.window.fonts import MEDIUM, REGULAR
from tower.window.ink import Ink
from tower.window.looks import AMBER
from tower.window.palette import ASKED, BRAKING, DIM, GIVEN, PANEL, TEXT, TRACK, Rgba
from tower.window.views import ControlsView

_LEFT, _RIGHT, _THICK = 86.0, 346.0, 8.0
_MIDDLE = (_LEFT + _RIGHT) / 2
_CLAMPED: Rgba = (*AMBER, 255)


def draw_controls(ink: Ink, view: ControlsView) -> None:
    ink.panel()
    _draw_row(ink, 21, "Steering", view.steer_text, -view.steer_requested, -view.steer_applied, GIVEN, view.fresh)
    _draw_row(
        ink,
        45,
        "Pedals",
        view.drive_text,
        view.drive_requested,
        view.drive_applied,
        BRAKING if view.drive_applied < 0 else GIVEN,
        view.fresh,
    )
    _draw_rule(ink, view)


def _draw_row(ink: Ink, y: float, label: str, text: str, asked: float, given: float, colour: Rgba, fresh: bool) -> None:
    """asked, given  -1 at the left end, +1 at the right"""
    ink.text(label, 18, y + 5, 14, DIM)
    ink.text(text, 422, y + 5, 14, TEXT, MEDIUM, "right")
    ink.box(_LEFT, y - _THICK / 2, _RIGHT - _LEFT, _THICK, TRACK, _THICK / 2)
    if fresh:
        half = (_RIGHT - _LEFT) / 2
        at, wanted = _MIDDLE + given * half, _MIDDLE + asked * half
        ink.box(min(at, _MIDDLE), y - _THICK / 2, abs(at - _MIDDLE), _THICK, colour, 3)
        _draw_asked(ink, wanted, y)
    ink.box(_MIDDLE - 0.75, y - 8, 1.5, 16, DIM)


def _draw_asked(ink: Ink, x: float, y: float) -> None:
    """The request rides on the bar as a wedge with a dark edge, so that it stays apart from what was applied."""
    ink.polygon([(x, y + 3), (x - 7.5, y - 10.5), (x + 7.5, y - 10.5)], PANEL)
    ink.polygon([(x, y + 1), (x - 5.5, y - 9), (x + 5.5, y - 9)], ASKED)


def _draw_rule(ink: Ink, view: ControlsView) -> None:
    y = 70.0
    if view.limited:
        ink.polygon([(18, y - 1), (24, y - 12), (30, y - 1)], _CLAMPED)
        ink.text(view.rule_text, 38, y, 14, _CLAMPED, MEDIUM, room=230)
    else:
        ink.text(view.rule_text, 18, y, 14, DIM, room=250)
    ink.polygon([(290, y), (286, y - 8), (294, y - 8)], ASKED)
    ink.text("requested", 299, y, 12, DIM, REGULAR)
    ink.box(366, y - 7, 12, 6, GIVEN, 3)
    ink.text("applied", 383, y, 12, DIM, REGULAR)
