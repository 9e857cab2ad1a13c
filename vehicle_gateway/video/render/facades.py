"""Textures of walls and hedges: plaster or brick, windows, doors, plinth, cornice; and how much sun a wall gets.

Deterministic for the generator handed in. Sizes in metres as commonly built; TEXEL_M is the texture's resolution.
"""

from dataclasses import dataclass
from math import cos, sin, sqrt

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import Colour, shaded
from vehicle_gateway.video.render.noise import fractal, smooth, to_bytes
from vehicle_gateway.video.render.projection import Floats, Picture
from vehicle_gateway.video.render.scenery import sun_direction

TEXEL_M = 0.03
FLOOR_M = 2.9
PLINTH_M = 0.5
WINDOW_M = (1.15, 1.45)  # width, height
SILL_M = 0.95  # above the floor
IN_SHADE, IN_SUN = 0.66, 1.06  # light on a wall that faces away from the sun, and straight towards it


@dataclass(frozen=True, slots=True)
class Style:
    wall: Colour  # BGR
    frame: Colour
    door: Colour
    spacing_m: float  # between the middles of windows
    brick: bool
    roof: Colour


STYLES = (
    Style((188.0, 212.0, 226.0), (236.0, 240.0, 240.0), (70.0, 92.0, 60.0), 2.9, False, (62.0, 74.0, 132.0)),
    Style((92.0, 104.0, 152.0), (226.0, 232.0, 234.0), (52.0, 52.0, 58.0), 2.6, True, (84.0, 82.0, 80.0)),
    Style((206.0, 206.0, 202.0), (88.0, 84.0, 80.0), (60.0, 60.0, 120.0), 3.2, False, (84.0, 82.0, 80.0)),
    Style((140.0, 184.0, 214.0), (236.0, 240.0, 240.0), (96.0, 70.0, 48.0), 2.8, False, (58.0, 70.0, 120.0)),
    Style((204.0, 196.0, 178.0), (238.0, 240.0, 238.0), (110.0, 84.0, 58.0), 3.0, False, (78.0, 80.0, 84.0)),
    Style((168.0, 192.0, 184.0), (232.0, 236.0, 236.0), (64.0, 82.0, 104.0), 2.7, False, (62.0, 74.0, 132.0)),
)


def sunlight(outward_rad: float) -> float:
    """Light factor of an upright wall whose outward normal points along `outward_rad` (map frame)."""
    x, y, _ = sun_direction()
    return IN_SHADE + (IN_SUN - IN_SHADE) * sqrt(max(0.0, x * cos(outward_rad) + y * sin(outward_rad)))


def facade(
    style: Style, length_m: float, height_m: float, light: float, has_door: bool, stucco: Floats, random: np.random.Generator
) -> Picture:
    """A wall with its windows, (rows, columns, 4); row 0 is the top. `stucco`: what `plaster` gave."""
    wall = _bare(style, length_m, height_m, stucco, random)
    count = max(1, int((length_m - 0.8) / style.spacing_m))
    floors = max(1, int((height_m - 0.4) / FLOOR_M))
    entrance = count // 2 if has_door else -1
    for i in range(count):
        middle = length_m * (i + 0.5) / count
        for floor in range(floors):
            if floor == 0 and i == entrance:
                _door(wall, style, middle, random)
            else:
                _window(wall, style, middle, PLINTH_M * 0.6 + floor * FLOOR_M + SILL_M, random)
    _cornice(wall, style, length_m)
    cool = (light * (1.0 + 0.10 * (1 - light)), light, light * (1.0 - 0.05 * (1 - light)), 1.0)  # shade is lit by the sky
    return np.asarray(cv2.multiply(cv2.cvtColor(wall, cv2.COLOR_BGR2BGRA), np.array(cool)), dtype=np.uint8)


def hedge(length_m: float, height_m: float, light: float, random: np.random.Generator) -> Picture:
    """Leaves: darker towards the ground, a ragged light along the top."""
    rows, columns = max(8, round(height_m / TEXEL_M)), max(16, round(length_m / TEXEL_M))
    leaves = 0.86 + 0.26 * fractal(random, rows, columns, 8, 8, 3) + 0.12 * smooth(random, rows, columns, 2, 2)
    leaves *= np.linspace(1.18, 0.55, rows, dtype=np.float32)[:, None] * np.float32(light)
    return to_bytes(np.maximum(leaves, 0.25)[..., None] * np.array([50.0, 98.0, 70.0], dtype=np.float32))


def plaster(random: np.random.Generator) -> Floats:
    """Stains and grain around 1, for all walls to be cut from."""
    rows, columns = 512, 2048
    light: Floats = 1 + 0.02 * fractal(random, rows, columns, 50, 60, 3)
    light += 0.012 * random.standard_normal((rows, columns), dtype=np.float32)
    return light


def _bare(style: Style, length_m: float, height_m: float, stucco: Floats, random: np.random.Generator) -> Picture:
    """Plaster or brick and the plinth."""
    rows, columns = round(height_m / TEXEL_M), round(length_m / TEXEL_M)
    top, left = (int(random.integers(max(1, have - need))) for have, need in zip(stucco.shape, (rows, columns), strict=True))
    light = np.resize(stucco[top : top + rows, left : left + columns], (rows, columns)).astype(np.float32)
    if style.brick:
        course = np.arange(rows) // 3
        light += (
            0.05
            * random.standard_normal((int(course[-1]) + 1, columns // 8 + 1), dtype=np.float32)[course][:, np.arange(columns) // 8]
        )
        light[np.arange(rows) % 3 == 0] -= 0.07
    light *= np.linspace(1.03, 0.94, rows, dtype=np.float32)[:, None]
    tone = cv2.convertScaleAbs(light, alpha=200.0)  # bytes from here on: walls are many
    tint = np.array([*(channel / 200.0 for channel in style.wall), 1.0])
    wall = np.asarray(cv2.multiply(cv2.merge([tone, tone, tone]), tint), dtype=np.uint8)
    _box(wall, 0.0, length_m, 0.0, PLINTH_M, shaded(style.wall, 0.58))
    return wall


def _box(wall: Picture, left_m: float, right_m: float, low_m: float, high_m: float, colour: Colour) -> None:
    """Fill a rectangle given in metres from the lower left corner."""
    rows = wall.shape[0]
    x0, x1 = round(left_m / TEXEL_M), round(right_m / TEXEL_M)
    y0, y1 = rows - round(high_m / TEXEL_M), rows - round(low_m / TEXEL_M)
    wall[max(0, y0) : max(0, y1), max(0, x0) : max(0, x1)] = colour


def _window(wall: Picture, style: Style, middle_m: float, low_m: float, random: np.random.Generator) -> None:
    width, height = WINDOW_M
    left, right, high = middle_m - width / 2, middle_m + width / 2, low_m + height
    _box(wall, left - 0.12, right + 0.12, low_m - 0.12, low_m - 0.03, shaded(style.frame, 0.92))  # sill
    _box(wall, left - 0.10, right + 0.10, low_m - 0.21, low_m - 0.12, shaded(style.wall, 0.72))  # its shadow
    _box(wall, left - 0.07, right + 0.07, low_m - 0.03, high + 0.07, style.frame)
    _glass(wall, left, right, low_m, high, random)
    if random.random() < 0.55:
        cloth, reach = shaded((206.0, 214.0, 218.0), random.uniform(0.6, 0.85)), random.uniform(0.12, 0.3)
        _box(wall, left, left + reach, low_m, high, cloth)
        _box(wall, right - reach, right, low_m, high, cloth)
    _box(wall, left, right, high - 0.09, high, (52.0, 46.0, 42.0))  # shadow of the reveal
    _box(wall, middle_m - 0.03, middle_m + 0.03, low_m, high, style.frame)
    _box(wall, left, right, low_m + height * 0.66, low_m + height * 0.66 + 0.05, style.frame)


def _glass(wall: Picture, left_m: float, right_m: float, low_m: float, high_m: float, random: np.random.Generator) -> None:
    """Reflects the sky above and the street below."""
    rows = wall.shape[0]
    part = wall[rows - round(high_m / TEXEL_M) : rows - round(low_m / TEXEL_M), round(left_m / TEXEL_M) : round(right_m / TEXEL_M)]
    if part.size:
        down = np.linspace(0, 1, part.shape[0])[:, None, None]
        top = np.array([176.0, 146.0, 112.0]) * random.uniform(0.55, 1.05)
        part[:] = np.clip(top * (1 - down) + np.array([62.0, 56.0, 50.0]) * down, 0, 255).astype(np.uint8)


def _door(wall: Picture, style: Style, middle_m: float, random: np.random.Generator) -> None:
    _box(wall, middle_m - 0.75, middle_m + 0.75, 0.0, 2.55, style.frame)
    _box(wall, middle_m - 0.60, middle_m + 0.60, 0.12, 2.42, style.door)
    _box(wall, middle_m - 0.45, middle_m - 0.05, 1.3, 2.25, (96.0, 84.0, 70.0))
    _box(wall, middle_m + 0.05, middle_m + 0.45, 1.3, 2.25, (96.0, 84.0, 70.0))
    _box(wall, middle_m - 0.95, middle_m + 0.95, 2.62, 2.80, shaded(style.wall, random.uniform(0.6, 0.75)))
    _box(wall, middle_m - 0.9, middle_m + 0.9, 0.0, 0.14, (150.0, 154.0, 156.0))


def _cornice(wall: Picture, style: Style, length_m: float) -> None:
    """A light ledge at the top, its shadow below it, and a down-pipe."""
    height = wall.shape[0] * TEXEL_M
    _box(wall, 0.0, length_m, height - 0.62, height - 0.30, shaded(style.wall, 0.78))
    _box(wall, 0.0, length_m, height - 0.30, height, shaded(style.wall, 1.08))
    _box(wall, length_m - 0.42, length_m - 0.30, 0.2, height - 0.3, shaded(style.wall, 0.66))
    wall[:] = cv2.GaussianBlur(wall, (3, 3), 0.5)
