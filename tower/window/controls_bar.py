"""Steering and acceleration: what was requested beside what the car applied, and the rule between them. Draws a ControlsView."""

from tower.window.fonts import MEDIUM
from tower.window.ink import Ink
from tower.window.looks import AMBER
from tower.window.palette import ASKED, BRAKING, DIM, GIVEN, PANEL, TEXT, TRACK, Rgba
from tower.window.views import ControlsView

_LEFT, _RIGHT, _THICK = 104.0, 328.0, 9.0
_MIDDLE = (_LEFT + _RIGHT) / 2
_CLAMPED: Rgba = (*AMBER, 255)


def draw_controls(ink: Ink, view: ControlsView) -> None:
    ink.layer(_draw_background)
    _draw_row(ink, 23, view.steer_text, -view.steer_requested, -view.steer_applied, GIVEN, view.fresh)
    _draw_row(
        ink,
        50,
        view.drive_text,
        view.drive_requested,
        view.drive_applied,
        BRAKING if view.drive_applied < 0 else GIVEN,
        view.fresh,
    )
    _draw_rule(ink, view)


def _draw_background(ink: Ink) -> None:
    ink.panel()
    for y, label in ((23.0, "Steering"), (50.0, "Pedals")):
        ink.text(label, 18, y + 6, 18, DIM)
        ink.box(_LEFT, y - _THICK / 2, _RIGHT - _LEFT, _THICK, TRACK, _THICK / 2)
        ink.box(_MIDDLE - 0.75, y - 8, 1.5, 16, DIM)
    ink.box(390, 62, 34, 24, TRACK, 6)
    ink.text("F1", 407, 80, 18, DIM, MEDIUM, "centre")


def _draw_row(ink: Ink, y: float, text: str, asked: float, given: float, colour: Rgba, fresh: bool) -> None:
    """asked, given  -1 at the left end, +1 at the right"""
    ink.text(text, 424, y + 6, 18, TEXT, MEDIUM, "right")
    if fresh:
        half = (_RIGHT - _LEFT) / 2
        at, wanted = _MIDDLE + given * half, _MIDDLE + asked * half
        ink.box(min(at, _MIDDLE), y - _THICK / 2, abs(at - _MIDDLE), _THICK, colour, 3)
        _draw_asked(ink, wanted, y)


def _draw_asked(ink: Ink, x: float, y: float) -> None:
    """The request rides on the bar as a wedge with a dark edge, so that it stays apart from what was applied."""
    ink.polygon([(x, y + 3), (x - 7.5, y - 10.5), (x + 7.5, y - 10.5)], PANEL)
    ink.polygon([(x, y + 1), (x - 5.5, y - 9), (x + 5.5, y - 9)], ASKED)


def _draw_rule(ink: Ink, view: ControlsView) -> None:
    y = 80.0
    if view.limited:
        ink.polygon([(18, y), (25, y - 13), (32, y)], _CLAMPED)
        ink.text(view.rule_text, 40, y, 18, _CLAMPED, MEDIUM, room=340)
    else:
        ink.text(view.rule_text, 18, y, 18, DIM, room=362)
