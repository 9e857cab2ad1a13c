"""What colours and lines mean: the drawing's kinds of line to the left, the candidates of this cycle to the right."""

from collections.abc import Callable

import numpy as np

from autonomy.planner_view.layers import View, Way
from autonomy.planner_view.pens import BOLD, BROKEN, CAR, CAR_LINE, DOTTED, PAPER, THICK, THIN
from autonomy.planner_view.sheet import HEAVY, REGULAR, Sheet
from autonomy.planning.horizon import Floats
from autonomy.planning.topology import BRAKING
from wire.planner_colours import INK, PERSON, Rgb

HIGH_PX = 240
LINE_PX, SIZE_PX = 34, 23
LEFT_PX, SAMPLE_PX = 36, 70
WAYS_PX = 700
GREY: Rgb = (120, 126, 134)


def draw_legend(sheet: Sheet, top_px: int, view: View, title: str) -> None:
    wide = sheet.pixels.shape[1]
    sheet.fill(np.array(((0, top_px), (wide, top_px), (wide, top_px + HIGH_PX), (0, top_px + HIGH_PX)), float), PAPER)
    sheet.stroke(np.array(((0.0, top_px), (wide, top_px))), THIN, INK)
    sheet.words(title, LEFT_PX, top_px + 40, 27, INK, HEAVY)
    for row, (sample, text) in enumerate(SAMPLES):
        y = top_px + 78 + row * LINE_PX
        sample(sheet, _line(LEFT_PX, y))
        sheet.words(text, LEFT_PX + SAMPLE_PX + 18, y + 8, SIZE_PX, INK)
    for row, way in enumerate(sorted(view.ways, key=lambda way: way.cost)):
        _draw_way(sheet, top_px + 78 + row * LINE_PX, way)


def _line(x: float, y: float) -> Floats:
    return np.array(((x, y), (x + SAMPLE_PX, y)), float)


def _draw_way(sheet: Sheet, y: float, way: Way) -> None:
    at = _line(WAYS_PX, y)
    if way.feasible or way.chosen:
        sheet.stroke(at, BOLD if way.chosen else THICK, way.colour)
    else:
        sheet.dashes(at, THICK, way.colour, *BROKEN)
    x, weight = WAYS_PX + SAMPLE_PX + 18, HEAVY if way.chosen else REGULAR
    text = sheet.fitted(told(way), sheet.pixels.shape[1] - x - 16, SIZE_PX, weight)
    sheet.words(text, x, y + 8, SIZE_PX, INK, weight)


def told(way: Way) -> str:
    """What it is, what it costs, and, as far as there is room, what it does."""
    cost = "" if way.identity == BRAKING else f"cost {way.cost:.1f}" if way.feasible else "not feasible"
    return "  ·  ".join(word for word in (way.name, cost, "chosen" if way.chosen else "", way.does) if word)


def _guidance(sheet: Sheet, at: Floats) -> None:
    sheet.dashes(at, THICK, GREY, *DOTTED)


def _trajectory(sheet: Sheet, at: Floats) -> None:
    middle = at.mean(axis=0)
    sheet.stroke(np.array((at[0], middle - (6, 0))), THICK, GREY)
    sheet.dashes(np.array((middle + (6, 0), at[1])), THICK, GREY, *BROKEN)


def _chosen(sheet: Sheet, at: Floats) -> None:
    sheet.stroke(at, BOLD, GREY)


def _person(sheet: Sheet, at: Floats) -> None:
    ring = np.stack((np.cos(np.linspace(0, 2 * np.pi, 40)), np.sin(np.linspace(0, 2 * np.pi, 40))), axis=1)
    sheet.fill(at[1] - (16, 0) + 14 * ring, PERSON, 0.10)
    sheet.stroke(at[1] - (16, 0) + 14 * ring, 1.0, PERSON, 0.7, closed=True)
    sheet.stroke(np.array((at[0] + (12, 0), at[1] - (16, 0))), THIN, PERSON, 0.9)
    sheet.fill(at[0] + (12, 0) + 12 * ring, PERSON)


def _car(sheet: Sheet, at: Floats) -> None:
    box = np.array((at[0] - (0, 12), at[1] - (0, 12), at[1] + (0, 12), at[0] + (0, 12)))
    sheet.fill(box, CAR, 0.35)
    sheet.stroke(box, THIN, CAR_LINE, closed=True)


Sample = Callable[[Sheet, Floats], None]
SAMPLES: tuple[tuple[Sample, str], ...] = (
    (_guidance, "guidance class"),
    (_trajectory, "trajectory made of it; broken: not feasible"),
    (_chosen, "chosen; its outline at every second"),
    (_person, "person now, and predicted: 2σ at every second"),
    (_car, "car"),
)
