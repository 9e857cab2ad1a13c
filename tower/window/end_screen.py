"""The end of the drive: what it came to, and who drove when as one bar. Draws an EndView."""

from tower.window.fonts import BOLD, MEDIUM, REGULAR
from tower.window.ink import Ink
from tower.window.looks import LOOKS
from tower.window.palette import DIM, PANEL, TEXT, TRACK
from tower.window.views import EndView

_LEFT, _RIGHT = 40.0, 540.0


def draw_end(ink: Ink, view: EndView) -> None:
    wide, high = ink.size
    ink.box(0, 0, wide, high, (*PANEL[:3], 240), 20)
    ink.text(view.title, _LEFT, 62, 32, TEXT, BOLD, room=_RIGHT - _LEFT)
    _draw_timeline(ink, view, 92)
    for i, (label, text, mode) in enumerate(view.rows):
        y = 164 + i * 28
        if mode is not None:
            ink.box(_LEFT, y - 11, 11, 11, (*LOOKS[mode].colour, 255), 3)
        ink.text(label, _LEFT + 20, y, 18, DIM, REGULAR)
        ink.text(text, _RIGHT, y, 18, TEXT, MEDIUM, "right", room=240)
        ink.box(_LEFT, y + 8.5, _RIGHT - _LEFT, 1, TRACK)
    if view.recording:
        ink.text(f"Recording in {view.recording}", _LEFT, high - 28, 18, DIM, REGULAR, room=_RIGHT - _LEFT)


def _draw_timeline(ink: Ink, view: EndView, y: float) -> None:
    whole = max((stretch.end_s for stretch in view.stretches), default=0.0)
    ink.box(_LEFT, y, _RIGHT - _LEFT, 16, TRACK, 4)
    if whole <= 0:
        return
    for stretch in view.stretches:
        x = _LEFT + (_RIGHT - _LEFT) * stretch.begin_s / whole
        end = _LEFT + (_RIGHT - _LEFT) * min(stretch.end_s / whole, 1.0)
        ink.box(x, y, max(end - x, 1.0), 16, (*LOOKS[stretch.mode].colour, 255))
    ink.text("0:00", _LEFT, y + 35, 18, DIM)
    ink.text(f"{int(whole) // 60}:{int(whole) % 60:02d}", _RIGHT, y + 35, 18, DIM, REGULAR, "right")
