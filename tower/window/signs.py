"""The sign beside the words of a mode: shape carries what colour alone must not. About 30 design units across.

Each is drawn with `on`, the ink, and `under`, the colour beneath it.
"""

from collections.abc import Callable
from math import cos, pi, sin

from tower.window.ink import XY, Ink, arc, rounded
from tower.window.looks import Sign
from tower.window.palette import Rgba


def _wheel(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.ring(x, y, 13, 4, on)
    ink.disc(x, y, 4.5, on)
    for angle in (0.0, pi, pi / 2):
        ink.line([(x + 3 * cos(angle), y + 3 * sin(angle)), (x + 12 * cos(angle), y + 12 * sin(angle))], 4, on)


def _car(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.polygon([(x - 11, y - 1), (x - 7, y - 10), (x + 7, y - 10), (x + 11, y - 1)], on)
    ink.box(x - 14, y - 2, 28, 11, on, 3.5)
    ink.polygon([(x - 7.5, y - 1.5), (x - 5, y - 7.2), (x + 5, y - 7.2), (x + 7.5, y - 1.5)], under)
    for side in (-1, 1):
        ink.box(x + side * 9.5 - 2.5, y + 7, 5, 6, on, 2)
        ink.disc(x + side * 9, y + 3.5, 2.2, under)


def _car_asks(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.polygon([(x, y - 15), (x + 16, y + 12), (x - 16, y + 12)], on)
    ink.line([(x, y - 5), (x, y + 2)], 3.6, under)
    ink.disc(x, y + 7.5, 2.1, under)


def _arrows(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    for side in (-1, 1):
        row = y + side * 6
        ink.line([(x - 11, row), (x + 11, row)], 3.6, on)
        ink.polygon([(x + side * 16, row), (x + side * 8, row - 6), (x + side * 8, row + 6)], on)


def _person(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.disc(x, y - 8, 6, on)
    ink.polygon([*arc(x, y + 12, 12, pi, 2 * pi), (x + 12, y + 13), (x - 12, y + 13)], on)


def _octagon_points(x: float, y: float, radius: float) -> list[XY]:
    return [(x + radius * cos(pi / 8 + k * pi / 4), y + radius * sin(pi / 8 + k * pi / 4)) for k in range(8)]


def _octagon(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.polygon(_octagon_points(x, y, 16), on)
    ink.line([(x, y - 8), (x, y + 6)], 4, under)
    ink.line([(x - 6, y + 1), (x, y + 7), (x + 6, y + 1)], 4, under)


def _octagon_open(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.polygon(_octagon_points(x, y, 16), on)
    ink.polygon(_octagon_points(x, y, 11.5), under)
    ink.box(x - 5, y - 5, 10, 10, on)


def _cross(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    ink.polygon(_octagon_points(x, y, 16), on)
    for side in (-1, 1):
        ink.line([(x - 6, y - 6 * side), (x + 6, y + 6 * side)], 4.5, under)


def _pause(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    for side in (-1, 1):
        ink.box(x + side * 6 - 3.5, y - 12, 7, 24, on, 2)


def _broken(ink: Ink, x: float, y: float, on: Rgba, under: Rgba) -> None:
    for side in (-1, 1):
        ink.line(rounded(x + side * 9 - 7, y - 6, 14, 12, 6), 3.4, on)
    ink.line([(x - 5, y + 13), (x + 5, y - 13)], 9, under)
    ink.line([(x - 5, y + 13), (x + 5, y - 13)], 3, on)


SIGNS: dict[Sign, Callable[[Ink, float, float, Rgba, Rgba], None]] = {
    Sign.WHEEL: _wheel,
    Sign.CAR: _car,
    Sign.CAR_ASKS: _car_asks,
    Sign.ARROWS: _arrows,
    Sign.PERSON: _person,
    Sign.OCTAGON: _octagon,
    Sign.OCTAGON_OPEN: _octagon_open,
    Sign.CROSS: _cross,
    Sign.PAUSE: _pause,
    Sign.BROKEN: _broken,
}
