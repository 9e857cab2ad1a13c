"""The card above the horizon. Draws a CardView: title, time left, reasons, steps, what to do now."""

from dataclasses import replace

from tower.window.fonts import BOLD, MEDIUM, REGULAR, wrap
from tower.window.ink import Ink
from tower.window.looks import BLUE
from tower.window.palette import DIM, FAINT, PANEL, TEXT, TONES, TRACK, Rgba
from tower.window.views import CardView, Step

_LEFT, _RIGHT = 24.0, 616.0
_LINE, _STEPS, _NOTE = 23.0, 40.0, 23.0  # heights of a line of reasons and of the row of steps
_FULL_DEG = 90.0  # of the alignment bar, each side
_DONE: Rgba = (*BLUE, 255)
_DARK: Rgba = (13, 17, 23, 255)


def card_height(view: CardView) -> float:
    """Design units that the card needs; it never reaches the horizon."""
    bar, steps = 0.0 if view.remaining_share is None else 10.0, _STEPS if view.steps else 0.0
    return 78.0 + bar + steps + _LINE * _reason_lines(view) + (_NOTE if view.note else 0.0)


def _reason_lines(view: CardView) -> int:
    """A single reason may take two lines, and so may the first of several where no note needs the room."""
    return 0 if not view.reasons else 2 if view.note or len(view.reasons) == 1 else 3


def draw_card(ink: Ink, view: CardView) -> None:
    """The words are drawn once; time and wheel run over them."""
    still = replace(view, remaining_text="", remaining_share=None if view.remaining_share is None else 1.0, wheel_error_deg=None)
    ink.layer(_draw_words, still)
    ink.text(view.remaining_text, _RIGHT, 34, 21, TEXT, MEDIUM, "right", room=210)
    if view.remaining_share is not None:
        ink.box(_LEFT, 45, (_RIGHT - _LEFT) * view.remaining_share, 6, TONES[view.tone], 3)
    if view.wheel_error_deg is not None and view.steps:
        x = _LEFT + sum(_step_width(ink, step) + 8 for step in view.steps)
        _draw_alignment(ink, view, x + 6, _steps_y(view) + 4)


def _draw_words(ink: Ink, view: CardView) -> None:
    wide, _ = ink.size
    high = card_height(view)
    colour = TONES[view.tone]
    ink.box(0, 0, wide, high, (*PANEL[:3], 232), 16)
    ink.box(0, 14, 5, high - 28, colour, 2.5)
    ink.text(view.title, _LEFT, 34, 23, colour, BOLD, room=370)
    if view.remaining_share is not None:
        ink.box(_LEFT, 45, _RIGHT - _LEFT, 6, TRACK, 3)
    _draw_reasons(ink, view, _reasons_y(view))
    y = _draw_steps(ink, view, _steps_y(view))
    _draw_action(ink, view, y)


def _reasons_y(view: CardView) -> float:
    return 60.0 if view.remaining_share is None else 70.0


def _steps_y(view: CardView) -> float:
    return _reasons_y(view) + _LINE * _reason_lines(view)


def _draw_reasons(ink: Ink, view: CardView, y: float) -> None:
    """The first two reasons within the lines there are; how many more there are."""
    left, size_px, row = _LEFT + 104, max(4, round(18 * ink.scale)), 0
    for i, (channel, text) in enumerate(view.reasons[:2]):
        ink.text(channel, _LEFT, y + row * _LINE, 18, DIM, MEDIUM, room=99)
        more = f"+{len(view.reasons) - 2}" if i == 1 and len(view.reasons) > 2 else ""
        ink.text(more, _RIGHT, y + row * _LINE, 18, DIM, MEDIUM, "right")
        lines_max = _reason_lines(view) - row - (1 if i == 0 and len(view.reasons) > 1 else 0)
        for line in wrap(text, size_px, REGULAR, int((_RIGHT - left - (28 if more else 0)) * ink.scale), lines_max):
            ink.text(line, left, y + row * _LINE, 18, TEXT)
            row += 1


def _draw_steps(ink: Ink, view: CardView, y: float) -> float:
    if not view.steps:
        return y
    x, current = _LEFT, next((i for i, step in enumerate(view.steps) if not step.done), len(view.steps))
    for i, step in enumerate(view.steps):
        x = _draw_step(ink, step, i == current, x, y + 4) + 8
    return y + _STEPS


def _step_width(ink: Ink, step: Step) -> float:
    return ink.text_width(step.text, 18, MEDIUM) + 42


def _draw_step(ink: Ink, step: Step, current: bool, x: float, y: float) -> float:
    """A pill: full with a tick when done, bright edge when it is next, dim after that. Returns its right end."""
    wide = _step_width(ink, step)
    fill = _DONE if step.done else TEXT if current else TRACK
    ink.box(x, y - 16, wide, 30, fill, 15)
    on = TEXT if step.done else _DARK if current else DIM
    if step.done:
        ink.line([(x + 11, y - 1), (x + 15, y + 3), (x + 22, y - 5)], 2.2, on)
    else:
        ink.ring(x + 16, y - 1.5, 4.5, 1.8, on)
    ink.text(step.text, x + 31, y + 5.5, 18, on, MEDIUM)
    return x + wide


def _draw_alignment(ink: Ink, view: CardView, x: float, y: float) -> None:
    """Where the operator's wheel stands against the car's: a needle that has to reach the middle gap."""
    error = view.wheel_error_deg or 0.0
    right = _RIGHT - 48
    middle, half = (x + right) / 2, (right - x) / 2
    if half < 20:
        return
    ink.box(x, y - 4, right - x, 5, TRACK, 2.5)
    ink.box(middle - 5, y - 9, 10, 15, FAINT, 3)
    at = middle - min(max(error / _FULL_DEG, -1.0), 1.0) * half
    ink.box(at - 2, y - 11, 4, 19, _DONE if view.wheel_aligned else TEXT, 2)
    ink.text(f"{min(abs(error), 999):.0f}°", _RIGHT, y + 5.5, 18, TEXT, MEDIUM, "right")


def _draw_action(ink: Ink, view: CardView, y: float) -> None:
    ink.text(view.action, _LEFT, y + 3, 23, TEXT, MEDIUM, room=_RIGHT - _LEFT)
    for line in wrap(view.note, max(4, round(18 * ink.scale)), REGULAR, int((_RIGHT - _LEFT) * ink.scale), 1):
        ink.text(line, _LEFT, y + 28, 18, DIM)
