"""The two panels in the upper corners: the operator and the lease; the link and its ages over the last 20 s."""

from math import ceil

from tower.window.age_history import PERIOD_NS, SPAN_NS, Sample
from tower.window.fonts import MEDIUM, REGULAR, wrap
from tower.window.ink import XY, Ink
from tower.window.looks import BLUE
from tower.window.palette import DIM, FAINT, GIVEN, TEXT, TONES, TRACK, Rgba
from tower.window.views import LinkView, OperatorView, Tone

_HELD: Rgba = (*BLUE, 255)
_LIMITS_MS = (200, 500)  # architecture: the speed cap falls above 200 ms, the car stops above 500 ms
_LINES = ((DIM, 1.4), (GIVEN, 2.2))  # colour and thickness: picture, loop
_GRAPH = (18.0, 94.0, 208.0, 52.0)  # left, top, width, height
_HIGH_MS = 300.0  # of the graph, until something is higher
_STEP_MS = 50.0  # in which its scale grows
_HIGHEST_MS = 1200.0
_QUALITY_FOOT, _QUALITY_HIGH = 168.0, 16.0
_QUALITY: tuple[Rgba, ...] = (TRACK, TONES[Tone.BAD], TONES[Tone.WARN], DIM, (*TONES[Tone.GOOD][:3], 130))  # by number of bars
_MOTION_Y = 192.0
_NOTE_SIZE, _NOTE_LINE = 18.0, 22.0


def operator_height(view: OperatorView) -> float:
    """Design units: the panel is no larger than what it says."""
    return (104.0 if view.dead_man_text else 78.0) + _NOTE_LINE * len(_note_lines(view.note, 1.0))


def draw_operator(ink: Ink, view: OperatorView) -> None:
    ink.panel()
    ink.text(view.name, 18, 33, 20, TEXT, MEDIUM, room=250)
    _lamp(ink, 25, 57, TONES[view.lease_tone], view.lease_tone is Tone.GOOD)
    ink.text(view.lease, 41, 63, 18, TEXT if view.lease_tone is Tone.GOOD else TONES[view.lease_tone], room=226)
    if view.dead_man_text:
        _lamp(ink, 25, 83, _HELD if view.dead_man else DIM, view.dead_man)
        ink.text(view.dead_man_text, 41, 89, 18, TEXT if view.dead_man else DIM, room=226)
    for i, line in enumerate(_note_lines(view.note, ink.scale)):
        ink.text(line, 18, 113 + i * _NOTE_LINE, _NOTE_SIZE, DIM, room=250)


def _note_lines(note: str, scale: float) -> tuple[str, ...]:
    return wrap(note, max(4, round(_NOTE_SIZE * scale)), REGULAR, int(250 * scale), 3)


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
    ink.text(view.word, 54, 33, 20, TEXT, MEDIUM, room=212)
    for i, figure in enumerate(view.figures):
        x = 18 + i * 92
        ink.text(figure.text, x, 62, 20, TEXT if figure.tone is Tone.GOOD else TONES[figure.tone], MEDIUM, room=88)
        label = ink.text(figure.label, x, 83, 18, DIM)
        if i < len(_LINES):
            ink.box(x + label + 6, 77, 14, _LINES[i][1], _LINES[i][0], 1)
    _draw_graph(ink, view)
    _draw_quality(ink, view)
    ink.text("to motion", 18, _MOTION_Y, 18, DIM)
    ink.text(view.motion, 262, _MOTION_Y, 18, TEXT, anchor="right", room=150)


def _draw_graph(ink: Ink, view: LinkView) -> None:
    worst = max((max(s.picture_ms or 0, s.loop_ms or 0) for s in view.samples), default=0)
    full = min(max(_HIGH_MS, _STEP_MS * ceil(worst * 1.1 / _STEP_MS)), _HIGHEST_MS)
    ink.layer(_draw_ground, full)
    for (colour, thick), is_picture in zip(_LINES, (True, False), strict=True):
        for piece in _pieces(view.samples, is_picture, view.now_ns, full):
            ink.line(piece, thick, colour)


def _draw_ground(ink: Ink, full: float) -> None:
    """What the graph's lines stand on."""
    left, top, wide, high = _GRAPH
    ink.box(left, top, wide, high, TRACK, 5)
    limits = [limit for limit in _LIMITS_MS if limit < full]
    for limit in limits:
        _dashes(ink, left, top + high * (1 - limit / full), wide)
    if limits:  # the highest: two figures would not fit above one another
        ink.text(f"{limits[-1]}", left + wide + 5, top + high * (1 - limits[-1] / full) + 6, 18, DIM)


def _draw_quality(ink: Ink, view: LinkView) -> None:
    """The bars of the past 20 s beneath the graph: high is good, and no link leaves a gap."""
    left, _, wide, _ = _GRAPH
    ink.box(left, _QUALITY_FOOT + 1, wide, 1, FAINT)
    for begin_ns, end_ns, bars in _runs(view):
        x = left + wide * (1 - min(max(view.now_ns - begin_ns, 0) / SPAN_NS, 1.0))
        end = left + wide * (1 - min(max(view.now_ns - end_ns, 0) / SPAN_NS, 1.0))
        high = _QUALITY_HIGH * bars / 4
        ink.box(x, _QUALITY_FOOT - high, end - x, high, _QUALITY[bars])


def _runs(view: LinkView) -> list[tuple[int, int, int]]:
    """(begin, end, bars) of stretches of one quality: few boxes instead of a hundred."""
    runs: list[tuple[int, int, int]] = []
    for sample in view.samples:
        end = min(sample.at_ns + PERIOD_NS, view.now_ns)
        if runs and runs[-1][2] == sample.bars and sample.at_ns - runs[-1][1] < PERIOD_NS:
            runs[-1] = (runs[-1][0], end, sample.bars)
        else:
            runs.append((sample.at_ns, end, sample.bars))
    return runs


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
