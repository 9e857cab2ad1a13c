"""The sky: a panorama of gradient, clouds, hills and a tree line, looked up by direction.

Deterministic for the seed. At infinity: it turns with the car and does not move with it.
"""

import cv2
import numpy as np

from vehicle_gateway.video.render.ground import CELL_PX, HAZE_BGR
from vehicle_gateway.video.render.noise import fractal, smooth, to_bytes
from vehicle_gateway.video.render.projection import Floats, Picture, View
from vehicle_gateway.video.render.scenery import SUN_AZIMUTH_RAD

SOFT = 2  # air and clouds are made at half the size: nothing in them is sharp
LAND_ROWS = 90
COLUMNS = 4096  # around the whole horizon: 11 per degree
ROWS = 620
BELOW_ROWS = 20  # of them below the horizon
PER_RAD = COLUMNS / (2 * np.pi)
ROW_STEP_PX = 16
STRIP_PX, JOIN_ROWS = 16, 48  # columns that share one need for sky; needs that differ less share one strip
SHARP_SHARE = 0.1  # of the picture's height above the horizon that may show hills and trees


def panorama(seed: int) -> Picture:
    """(ROWS, 3/2 COLUMNS, 4): row 0 is the highest, columns run clockwise (to the right) from the map's x axis.

    The last third repeats the beginning, so that a camera's whole picture finds its place without a seam.
    """
    random = np.random.default_rng(seed)
    elevation = (ROWS - BELOW_ROWS - SOFT * (np.arange(ROWS // SOFT, dtype=np.float32) + 0.5))[:, None] / np.float32(PER_RAD)
    air = _air(elevation)
    _clouds(air, elevation, random)
    whole = to_bytes(np.asarray(cv2.resize(air, (COLUMNS, ROWS), interpolation=cv2.INTER_LINEAR)))
    land = whole[-LAND_ROWS:, :, :3].astype(np.float32)
    for skyline in _SKYLINES:
        _skyline(land, *skyline, random)
    whole[-LAND_ROWS:] = to_bytes(land)
    return np.ascontiguousarray(np.concatenate((whole, whole[:, : COLUMNS // 2]), axis=1))


# height of the silhouette in rows, its roughness, colour (BGR), share of haze at its foot
_SKYLINES = (
    (34.0, 0.2, (198.0, 180.0, 160.0), 0.45),
    (23.0, 0.5, (160.0, 160.0, 138.0), 0.45),
    (19.0, 1.0, (96.0, 118.0, 100.0), 0.30),
)


def _air(elevation_rad: Floats) -> Floats:
    """Blue above, pale at the horizon, brighter towards the sun."""
    high = np.array([206.0, 150.0, 92.0], dtype=np.float32)
    rise = 1 - np.exp(-np.maximum(elevation_rad, 0.0) / np.float32(0.30))
    azimuth = -(np.arange(COLUMNS // SOFT, dtype=np.float32) + 0.5)[None, :] * np.float32(SOFT / PER_RAD)
    glow = 0.5 + 0.5 * np.cos(azimuth - np.float32(SUN_AZIMUTH_RAD))
    bright = (1 + 0.07 * glow * np.exp(-np.maximum(elevation_rad, 0.0) / 0.6))[..., None]
    air: Floats = (HAZE_BGR[:3] + (high - HAZE_BGR[:3]) * rise[..., None]) * bright
    return air


def _clouds(picture: Floats, elevation_rad: Floats, random: np.random.Generator) -> None:
    """Heaps that flatten towards the horizon, white above and grey below."""
    depth = 1 / np.tan(np.maximum(elevation_rad[:, 0], 0.03))  # of a level sheet of cloud, in its heights
    noise = fractal(random, 512, COLUMNS // SOFT, 150, 170, 5, 0.52)
    rows = (np.log1p(depth) * 210).astype(np.float32)
    x, y = np.meshgrid(np.arange(COLUMNS // SOFT, dtype=np.float32), rows)
    field = cv2.remap(noise, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    above = cv2.remap(noise, x, y + 14, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
    cover = np.clip((field - 0.25) * 0.9, 0, 1) * np.clip(elevation_rad * 6 - 0.15, 0, 1)
    shade = np.clip(0.55 + (field - above) * 0.6, 0, 1)[..., None]
    white, grey = np.array([250.0, 249.0, 247.0]), np.array([222.0, 212.0, 204.0])
    tint = (grey + (white - grey) * shade).astype(np.float32)
    picture += (tint - picture) * (cover * 0.9)[..., None].astype(np.float32)


def _skyline(
    land: Floats, height_rows: float, rough: float, colour: tuple[float, float, float], haze: float, random: np.random.Generator
) -> None:
    """A silhouette on the horizon: hills when smooth, trees when rough."""
    swell = fractal(random, 2, COLUMNS, 2, 420, 3)[0] * 0.28
    crowns = fractal(random, 2, COLUMNS, 2, 22, 3)[0] * 0.16 * rough
    top = np.maximum(height_rows * (1 + swell + crowns), 1.0)[None, :]
    up = (LAND_ROWS - BELOW_ROWS - np.arange(LAND_ROWS, dtype=np.float32) - 0.5)[:, None]
    cover = np.clip(top - up + 0.5, 0, 1)[..., None]
    light = 1 + rough * 0.10 * smooth(random, LAND_ROWS, COLUMNS, 5, 8)
    foot = (haze * np.clip(1 - up / top, 0, 1) ** 1.5)[..., None]
    body = light[..., None] * np.array(colour, dtype=np.float32)
    body += (HAZE_BGR[:3] - body) * foot
    land += (body - land) * cover


class Sky:
    def __init__(self, seed: int) -> None:
        self._panorama = panorama(seed)

    def draw(self, canvas: Picture, view: View, end_row: int, sky_to: list[int] | None = None) -> None:
        """Fill the rows [0, end_row) of a BGRA canvas.

        sky_to  per STRIP_PX columns the row from which on walls will cover all sky: left out there
        """
        if end_row <= 0:
            return
        x, y = _widen(_grid(view, end_row), view.width_px, end_row)
        soft = max(0, min(end_row, int(view.horizon_px - SHARP_SHARE * view.height_px)))  # above: only clouds
        for first, last, needed in _strips(view.width_px, end_row, sky_to):
            for low, high, reading in ((0, min(soft, needed), cv2.INTER_NEAREST), (soft, needed, cv2.INTER_LINEAR)):
                if low < high:
                    part = slice(low, high), slice(first, last)
                    cv2.remap(self._panorama, x[part], y[part], reading, dst=canvas[part], borderMode=cv2.BORDER_REPLICATE)


def _strips(width_px: int, end_row: int, sky_to: list[int] | None) -> list[tuple[int, int, int]]:
    """(first column, last column, rows needed), neighbours of about the same need joined."""
    if sky_to is None:
        return [(0, width_px, end_row)]
    strips: list[tuple[int, int, int]] = []
    for cell, row in enumerate(sky_to):
        first, last, needed = cell * STRIP_PX, min(width_px, (cell + 1) * STRIP_PX), min(end_row, row)
        if strips and abs(strips[-1][2] - needed) < JOIN_ROWS:
            strips[-1] = (strips[-1][0], last, max(strips[-1][2], needed))
        else:
            strips.append((first, last, needed))
    return strips


def _grid(view: View, end_row: int) -> tuple[Floats, Floats]:
    """Panorama coordinates on a grid of CELL_PX by ROW_STEP_PX that reaches one half step out of the picture."""
    cells = -(-view.width_px // CELL_PX) + 2, -(-end_row // ROW_STEP_PX) + 2
    a = ((np.arange(cells[0]) - 0.5) * CELL_PX - view.centre_px[0]) / view.focal_px
    b = ((np.arange(cells[1]) - 0.5) * ROW_STEP_PX - view.centre_px[1]) / view.focal_px
    ray = view.axes[0] * a[None, :, None] + view.axes[1] * b[:, None, None] + view.axes[2]
    middle = np.arctan2(view.axes[2, 1], view.axes[2, 0])
    turned = np.arctan2(ray[..., 1], ray[..., 0]) - middle
    azimuth = (turned + np.pi) % (2 * np.pi) - np.pi + middle  # no jump inside the picture
    elevation = np.arctan2(ray[..., 2], np.hypot(ray[..., 0], ray[..., 1]))
    x = -azimuth * PER_RAD - 0.5
    x += COLUMNS * np.ceil((1.0 - x.min()) / COLUMNS)
    y = np.clip(ROWS - BELOW_ROWS - elevation * PER_RAD - 0.5, 0, ROWS - 1)
    return x.astype(np.float32), y.astype(np.float32)


def _widen(grid: tuple[Floats, Floats], width_px: int, rows: int) -> tuple[Floats, Floats]:
    """Panorama coordinates of every pixel of the rows [0, rows), linear between the grid's points."""
    size = (grid[0].shape[1] * CELL_PX, grid[0].shape[0] * ROW_STEP_PX)
    part = slice(ROW_STEP_PX, ROW_STEP_PX + rows), slice(CELL_PX, CELL_PX + width_px)
    x, y = (np.asarray(cv2.resize(places, size, interpolation=cv2.INTER_LINEAR), np.float32)[part] for places in grid)
    return x, y
