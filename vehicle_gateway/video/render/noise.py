"""Seeded noise that repeats without a seam: the stuff of asphalt, grass, clouds and leaves. Pure."""

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import Floats


def smooth(random: np.random.Generator, rows: int, columns: int, cell_rows: float, cell_columns: float) -> Floats:
    """(rows, columns) float32 of mean 0 and deviation about 1, features of the given size, periodic in both directions."""
    r, c = max(2, round(rows / cell_rows)), max(2, round(columns / cell_columns))
    coarse = np.pad(random.standard_normal((r, c), dtype=np.float32), 2, mode="wrap")
    tall, wide = rows / r, columns / c
    fine = cv2.resize(coarse, (round((c + 4) * wide), round((r + 4) * tall)), interpolation=cv2.INTER_CUBIC)
    top, left = round(2 * tall), round(2 * wide)
    return np.asarray(fine[top : top + rows, left : left + columns]) * np.float32(1.3)


def fractal(
    random: np.random.Generator, rows: int, columns: int, cell_rows: float, cell_columns: float, octaves: int, gain: float = 0.5
) -> Floats:
    """A sum of `octaves` of smooth noise, each half as large and `gain` as strong; deviation about 1."""
    total = np.zeros((rows, columns), dtype=np.float32)
    weight, square = 1.0, 0.0
    for _ in range(octaves):
        total += np.float32(weight) * smooth(random, rows, columns, cell_rows, cell_columns)
        square += weight * weight
        weight, cell_rows, cell_columns = weight * gain, cell_rows / 2, cell_columns / 2
    return total / np.float32(square**0.5)


def coloured(light: Floats, colour_bgr: tuple[float, float, float]) -> Floats:
    """(rows, columns) light around 1 -> (rows, columns, 3) float32, BGR 0..255, not clipped."""
    return light[..., None] * np.array(colour_bgr, dtype=np.float32)


def to_bytes(bgr: Floats) -> np.ndarray[tuple[int, ...], np.dtype[np.uint8]]:
    """Float BGR -> BGRA bytes, opaque. The renderer works on four channels: OpenCV samples them twice as fast as three."""
    four = cv2.cvtColor(np.clip(bgr, 0, 255).astype(np.uint8), cv2.COLOR_BGR2BGRA)
    return np.asarray(four)
