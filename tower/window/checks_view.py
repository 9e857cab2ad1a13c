"""The pre-drive checklist in the left column: a sign, a name and what to do or what was measured. Draws a ChecklistView."""

from tower.window.checks import CheckState
from tower.window.fonts import BOLD, MEDIUM
from tower.window.ink import Ink
from tower.window.palette import DIM, TEXT, TONES, Rgba
from tower.window.views import ChecklistView, Tone

_ROW, _HEAD, _PAD = 27.0, 44.0, 8.0
_COLOURS: dict[CheckState, Rgba] = {
    CheckState.PENDING: DIM,
    CheckState.PASSED: TONES[Tone.GOOD],
    CheckState.FAILED: TONES[Tone.BAD],
}


def checklist_height(view: ChecklistView) -> float:
    return _HEAD + _ROW * len(view.items) + _PAD


def draw_checklist(ink: Ink, view: ChecklistView) -> None:
    ink.panel()
    wide, _ = ink.size
    passed = sum(check.state is CheckState.PASSED for check in view.items)
    ink.text("Before you drive", 14, 30, 20, TEXT, BOLD)
    ink.text(f"{passed}/{len(view.items)}", wide - 14, 30, 20, TEXT, MEDIUM, "right")
    for i, check in enumerate(view.items):
        y = _HEAD + (i + 0.6) * _ROW
        _draw_sign(ink, 23, y - 5, check.state)
        ink.text(check.name, 38, y, 18, TEXT if check.state is not CheckState.PASSED else DIM, MEDIUM, room=82)
        ink.text(check.text, 126, y, 18, _COLOURS[check.state] if check.state is CheckState.FAILED else DIM, room=wide - 136)


def _draw_sign(ink: Ink, x: float, y: float, state: CheckState) -> None:
    """Tick, cross or ring: not colour alone."""
    colour = _COLOURS[state]
    if state is CheckState.PASSED:
        ink.line([(x - 7, y), (x - 2, y + 5), (x + 7, y - 6)], 2.8, colour)
    elif state is CheckState.FAILED:
        for side in (-1, 1):
            ink.line([(x - 6, y - 6 * side), (x + 6, y + 6 * side)], 2.8, colour)
    else:
        ink.ring(x, y, 5.5, 2.0, colour)
