"""The coloured frame around the whole picture: one pattern per mode. Draws a Look; decides nothing."""

import pygame

from tower.window.fonts import Type
from tower.window.ink import Ink
from tower.window.layout import FRAME, Box, Layout
from tower.window.looks import Look, Pattern
from tower.window.palette import Rgba

_DARK = (12, 14, 18)  # between the marks of a pattern


def frame_strips(look: Look, at: Layout) -> tuple[tuple[pygame.Surface, Box], ...]:
    """The frame as four opaque strips with their places: top, bottom, left, right."""
    thick = max(2, round(FRAME * at.scale))
    w, h = at.width_px, at.height_px
    places = (
        Box(0, 0, w, thick),
        Box(0, h - thick, w, thick),
        Box(0, thick, thick, h - 2 * thick),
        Box(w - thick, thick, thick, h - 2 * thick),
    )
    return tuple((_strip(look, at, place), place) for place in places if place.w > 0 and place.h > 0)


def _strip(look: Look, at: Layout, place: Box) -> pygame.Surface:
    surface = pygame.Surface((place.w, place.h))
    surface.fill(_DARK)
    ink = Ink(surface, at.scale, Type(), origin=(place.x / at.scale, place.y / at.scale))
    _paint_pattern(ink, look, at.width_px / at.scale, at.height_px / at.scale)
    return surface


def _paint_pattern(ink: Ink, look: Look, wide: float, high: float) -> None:
    colour = (*look.colour, 255)
    if look.pattern is Pattern.SOLID:
        ink.box(0, 0, wide, high, colour)
    elif look.pattern is Pattern.THIN:
        _band(ink, wide, high, 3.5, 8.5, colour)
    elif look.pattern is Pattern.STRIPES:
        for k in range(-int(high / 24) - 1, int((wide + high) / 24) + 2):
            x = k * 24.0
            ink.polygon([(x, 0), (x + 13, 0), (x + 13 - high, high), (x - high, high)], colour)
    elif look.pattern is Pattern.CHECKS:
        _rows(ink, wide, high, colour)
    else:
        length, gap = {Pattern.DASHES: (26.0, 18.0), Pattern.DOTS: (7.0, 9.0), Pattern.BLOCKS: (84.0, 8.0)}[look.pattern]
        for x, y, w, h in _beads(wide, high, length, gap):
            ink.box(x, y, w, h, colour, 3.5 if look.pattern is Pattern.DOTS else 0.0)


def _band(ink: Ink, wide: float, high: float, begin: float, end: float, colour: Rgba) -> None:
    for x, y, w, h in (
        (begin, begin, wide - 2 * begin, end - begin),
        (begin, high - end, wide - 2 * begin, end - begin),
        (begin, begin, end - begin, high - 2 * begin),
        (wide - end, begin, end - begin, high - 2 * begin),
    ):
        ink.box(x, y, w, h, colour)


def _beads(wide: float, high: float, length: float, gap: float) -> list[tuple[float, float, float, float]]:
    """Boxes along the four edges, symmetric about the middle; dots are as high as they are long."""
    across_size = min(length, FRAME)
    inset = (FRAME - across_size) / 2
    lying = [
        (along, across, length, across_size)
        for along in _places(wide, length, gap)
        for across in (inset, high - inset - across_size)
    ]
    standing = [
        (across, along, across_size, length)
        for along in _places(high, length, gap)
        for across in (inset, wide - inset - across_size)
    ]
    return lying + standing


def _places(edge: float, length: float, gap: float) -> list[float]:
    count = max(1, int((edge + gap) / (length + gap)))
    begin = (edge - count * (length + gap) + gap) / 2
    return [begin + i * (length + gap) for i in range(count)]


def _rows(ink: Ink, wide: float, high: float, colour: Rgba) -> None:
    """Two rows of squares, like a chequered tape."""
    half = FRAME / 2
    for row in (0, 1):
        for i in range(int(wide / half) + 2):
            if (i + row) % 2 == 0:
                ink.box(i * half, row * half, half, half, colour)
                ink.box(i * half, high - FRAME + row * half, half, half, colour)
        for i in range(int(high / half) + 2):
            if (i + row) % 2 == 0:
                ink.box(row * half, i * half, half, half, colour)
                ink.box(wide - FRAME + row * half, i * half, half, half, colour)
