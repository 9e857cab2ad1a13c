"""The two panels in the upper corners: the operator and the lease; the link and its ages over the last 20 s."""

from tower.window.age_history import SPAN_NS, Sample
from tower.window.fonts import MEDIUM, REGULAR, wrap
from tower.window.ink import XY, Ink
from tower.window.looks import BLUE
from tower.window.palette import DIM, FAINT, GIVEN, TEXT, TONES, TRACK, Rgba
from tower.window.views import LinkView, OperatorView, Tone

_HELD: Rgba = (*BLUE, 255)
_LIMITS_MS = (200, 500)  # architecture: the speed cap falls above 200 ms, the car stops above 500 ms
_LINES = ((DIM, 1.4), (GIVEN, 2.2))  # colour and thickness: picture, loop
_GRAPH = (18.0, 86.0, 244.0, 50.0)  # left, top, width, height
_HIGH_MS = 300.0  # of the graph, until something is higher
_HIGHEST_MS = 1200.0
_NOTE_SIZE = 12.5


def operator_height(view: OperatorView) -> float:
    """Design units: the panel is no larger than what it says."""
    return (94.0 if view.dead_man_text else 70.0) + (15.0 * len(_note_lines(view.note, 1.0)) + 4.0 if view.note else 0.0)


def draw_operator(ink: Ink, view: OperatorView) -> None:
    ink.panel()
    ink.text(view.name, 18, 30, 17, TEXT, MEDIUM, room=200)
    ink.text("F1 keys", 262, 29, 12, DIM, REGULAR, "right")
    _lamp(ink, 25, 51, TONES[view.lease_tone], view.lease_tone is Tone.GOOD)
    ink.text(view.lease, 40, 56, 14, TEXT if view.lease_tone is Tone.GOOD else TONES[view.lease_tone], room=226)
    if view.dead_man_text:
        _lamp(ink, 25, 74, _HELD if view.dead_man else DIM, view.dead_man)
        ink.text(view.dead_man_text, 40, 79, 14, TEXT if view.dead_man else DIM, room=226)
    for i, line in enumerate(_note_lines(view.note, ink.scale)):
        ink.text(line, 18, 99 + i * 15, _NOTE_SIZE, DIM, room=246)


def _note_lines(note: str, scale: float) -> tuple[str, ...]:
    return wrap(note, max(4, round(_NOTE_SIZE * scale)), REGULAR, int(244 * scale), 3)


def _lamp(ink: Ink, x: float, y: float, colour: Rgba, lit: bool) -> None:
    """A lit lamp is full, an unlit one a ring: not colour alone."""
    if lit:
        ink.disc(x, y, 6.5, colour)
    else:
        ink.ring(x, y, 5.5, 1.8, colour)


def draw_link(ink: Ink, view: LinkView) -> None:
    ink.panel()
    for i in range(4):
        high = 6 + i * 4
        ink.box(18 + i * 7, 32 - high, 5, high, TEXT if i < view.bars else FAINT, 1.5)
    ink.text(view.word, 52, 30, 17, TEXT, MEDIUM)
    for i, figure in enumerate(view.figures):
        x = 18 + i * 86
        ink.text(figure.text, x, 58, 17, TEXT if figure.tone is Tone.GOOD else TONES[figure.tone], MEDIUM, room=84)
        label = ink.text(figure.label, x, 74, 12, DIM)
        if i < len(_LINES):
            ink.box(x + label + 6, 69.5, 14, _LINES[i][1], _LINES[i][0], 1)
    _draw_graph(ink, view)


def _draw_graph(ink: Ink, view: LinkView) -> None:
    left, top, wide, high = _GRAPH
    worst = max((max(s.picture_ms or 0, s.loop_ms or 0) for s in view.samples), default=0)
    full = min(max(_HIGH_MS, worst * 1.1), _HIGHEST_MS)
    ink.box(left, top, wide, high, TRACK, 5)
    for limit in _LIMITS_MS:
        if limit < full:
            y = top + high * (1 - limit / full)
            _dashes(ink, left, y, wide)
            ink.text(f"{limit}", left + wide - 3, y - 2.5, 10, DIM, REGULAR, "right")
    for (colour, thick), is_picture in zip(_LINES, (True, False), strict=True):
        for piece in _pieces(view.samples, is_picture, view.now_ns, full):
            ink.line(piece, thick, colour)


def _dashes(ink: Ink, left: float, y: float, wide: float) -> None:
    for i in range(int(wide / 9)):
        ink.box(left + i * 9, y, 4.5, 1, FAINT)


def _pieces(samples: tuple[Sample, ...], picture: bool, now_ns: int, full: float) -> list[list[XY]]:
    """Stretches of known ages as lines: a gap in knowledge is a gap in the line."""
    left, top, wide, high = _GRAPH
    pieces: list[list[XY]] = [[]]
    for sample in samples:
        value = sample.picture_ms if picture else sample.loop_ms
        if value is None:
            pieces.append([])
            continue
        x = left + wide * (1 - min(max(now_ns - sample.at_ns, 0) / SPAN_NS, 1.0))
        pieces[-1].append((x, top + high * (1 - min(value / full, 1.0))))
    return [piece for piece in pieces if len(piece) > 1]
