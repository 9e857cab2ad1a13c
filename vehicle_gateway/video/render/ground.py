"""The ground of one picture: every pixel below the horizon, looked up on the sheet. Fast: about a quarter of a frame's time.

For every row of the picture and every 32nd column the ray's point on the ground is turned into (station, offset); between
the columns the coordinates are interpolated. Rows are grouped in bands, each of which reads the reduced copy whose texels
are as large as its pixels; towards the horizon a row is the mean of two or four sampled rows. Both keep lines from
flickering. Ground is flat (z = 0): a kerb is colour only.
"""

from dataclasses import dataclass
from math import exp

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import Floats, Numbers, Picture, View
from vehicle_gateway.video.render.road_frame import RoadFrame
from vehicle_gateway.video.render.sheet import FINE_M, Reduced, Sheet

CELL_PX, ROW_STEP_PX = 32, 4  # of the grid; rows only where a row more or less makes no visible difference
FARTHEST_M = 1500.0
BAND_ROWS = (0, 2, 3, 4, 6, 8, 11, 15, 21, 29, 40, 56, 79, 111, 157, 222, 314, 444, 100000)  # rows below the horizon
FOUR_SAMPLES_ABOVE, TWO_SAMPLES_ABOVE = 15, 111  # rows below the horizon, for a height of 720
HAZE_BGR = np.array([226.0, 216.0, 204.0, 255.0], dtype=np.float32)
HAZE_LENGTH_M = 420.0  # after this way a share of 1 - 1/e is haze
HAZE_MOST = 0.5  # at the horizon, where the tree line's own haze meets it
HAZE_ROWS = 26  # below the horizon, for a height of 720; nearer there is next to none
SHORTEST_CUT_CELLS = 5
SPARSE = 3  # of the grid's columns, one in so many decides which copy is read


@dataclass(frozen=True, slots=True)
class Band:
    """Rows [first, last) of the picture, each the mean of `samples` rows read from the sheet.

    The grid knows every sampled row (step 1) or, near the car, every `step`-th row and one beyond either end; its lines of
    a band stand from `at` on in the list of all.
    """

    first: int
    last: int
    samples: int
    step: int
    at: int

    @property
    def lines(self) -> int:
        rows = self.last - self.first
        return rows * self.samples if self.step == 1 else -(-rows // self.step) + 2

    def v_px(self) -> Floats:
        """Of the grid's lines. With several samples: the first of all rows, then the second of all, and so on."""
        if self.step == 1:
            rows = np.arange(self.first, self.last)
            return np.concatenate([rows + (k + 0.5) / self.samples for k in range(self.samples)]).astype(np.float32)
        return (self.first + (np.arange(self.lines) - 0.5) * self.step).astype(np.float32)

    def rows_apart(self) -> float:
        """Of the grid's first and last line, in sampled rows."""
        if self.step == 1:
            return (self.last - self.first) * self.samples - 1.0
        return (self.lines - 1.0) * self.step


def bands(horizon_row: int, end_row: int, height_px: int) -> list[Band]:
    """From the horizon down to `end_row`; rows above the picture are left out."""
    result, at = [], 0
    scale = height_px / 720
    for low, high in zip(BAND_ROWS[:-1], BAND_ROWS[1:], strict=True):
        first, last = max(0, horizon_row + low), min(end_row, horizon_row + high)
        if first < last:
            samples = 4 if high <= FOUR_SAMPLES_ABOVE * scale else 2 if high <= TWO_SAMPLES_ABOVE * scale else 1
            result.append(Band(first, last, samples, ROW_STEP_PX if samples == 1 else 1, at))
            at += result[-1].lines
    return result


@dataclass(frozen=True, slots=True)
class Hidden:
    """What will be painted over, per `cell_px` columns: rows [first, last) by walls, rows from `bonnet_from` on by the car."""

    cell_px: int
    walls: Numbers  # (cells, 2)
    bonnet_from: Numbers  # (cells,)

    def runs(self, all_bands: list[Band], width_px: int) -> list[list[slice]]:
        """Per band the columns that will be seen. Short covered stretches are not worth a cut."""
        first = np.array([[band.first] for band in all_bands])
        last = np.array([[band.last] for band in all_bands])
        behind_wall = (self.walls[:, 0] <= first) & (self.walls[:, 1] >= last)
        is_open = ~(behind_wall | (self.bonnet_from <= first))
        edges = np.diff(is_open, axis=1, prepend=False, append=False)  # every stretch begins and ends with one
        cells = np.flatnonzero(edges) % edges.shape[1]
        counts = np.cumsum(edges.sum(axis=1)).tolist()
        flat = cells.tolist()
        return [self._joined(flat[begin:end], width_px) for begin, end in zip([0, *counts], counts, strict=False)]

    def _joined(self, edges: list[int], width_px: int) -> list[slice]:
        """Columns of one band from the cells where a stretch begins or ends, in turn."""
        kept = edges[:1]
        for end, begin in zip(edges[1:-1:2], edges[2::2], strict=True):
            if begin - end >= SHORTEST_CUT_CELLS:
                kept += [end, begin]
        kept += edges[-1:]
        return [slice(a * self.cell_px, min(b * self.cell_px, width_px)) for a, b in zip(kept[::2], kept[1::2], strict=True)]


class Ground:
    """Draws the sheet as a camera sees it."""

    def __init__(self, sheet: Sheet, reduced: Reduced, frame: RoadFrame) -> None:
        self._sheet = sheet
        self._reduced = reduced
        self._frame = frame

    def draw(self, canvas: Picture, view: View, station_m: float, rows_px: tuple[int, int], hidden: Hidden) -> None:
        """Fill the rows [from, to) of a BGRA canvas but for what is hidden. `station_m`: where the car is, roughly."""
        all_bands = bands(rows_px[0], min(rows_px[1], view.height_px), view.height_px)
        if not all_bands:
            return
        rows, columns = self._places(view, np.concatenate([band.v_px() for band in all_bands]), station_m)
        footprints, seen = _footprints(rows, columns, all_bands, self._sheet), hidden.runs(all_bands, view.width_px)
        for band, texels, runs in zip(all_bands, footprints, seen, strict=True):
            if not runs:
                continue
            i, j, texture = self._reduced.pick(*texels)
            lines = slice(band.at, band.at + band.lines)
            map_x, map_y = (
                _widen(places[lines] * np.float32(0.5**halvings) - np.float32(0.5), band, view.width_px)
                for places, halvings in ((columns, j), (rows, i))
            )
            for run in runs:
                _sample(canvas[band.first : band.last, run], band, texture, map_x[:, run], map_y[:, run])
        _haze(canvas, view, all_bands)

    def _places(self, view: View, v_px: Floats, station_m: float) -> tuple[Floats, Floats]:
        """Sheet rows and columns of the grid's points."""
        cells = -(-view.width_px // CELL_PX) + 2
        u_px = (np.arange(cells, dtype=np.float32) - 0.5) * CELL_PX
        x, y = _on_ground(view, u_px, v_px)
        station, offset = self._frame.to_road(x, y, (float(view.position_m[0]), float(view.position_m[1])), station_m)
        return np.clip(self._sheet.row(station), 0, self._sheet.rows), self._sheet.column(offset)


def _on_ground(view: View, u_px: Floats, v_px: Floats) -> tuple[Floats, Floats]:
    """Where the rays through every (v, u) meet z = 0, relative to the camera's foot; rays that do not: far away."""
    right, down, forward = view.axes.astype(np.float32)
    a = ((u_px - view.centre_px[0]) / view.focal_px)[None, :].astype(np.float32)
    b = ((v_px - view.centre_px[1]) / view.focal_px)[:, None].astype(np.float32)
    x, y, z = (right[k] * a + down[k] * b + forward[k] for k in range(3))
    far = np.float32(FARTHEST_M)
    reach = np.float32(view.position_m[2]) / np.maximum(-z, np.float32(1e-5))
    reach = np.minimum(reach, far / np.hypot(x, y))
    return x * reach, y * reach


def _footprints(rows: Floats, columns: Floats, all_bands: list[Band], sheet: Sheet) -> list[tuple[float, float]]:
    """Per band the texels that one sample covers along and across: the mean over what lies near the road."""
    heads = np.array([band.at for band in all_bands])
    tails = np.array([band.at + band.lines - 1 for band in all_bands])
    apart = np.maximum([[band.rows_apart()] for band in all_bands], 1.0)
    near = np.abs(columns[tails, ::SPARSE] - sheet.columns / 2) < sheet.fine_half_m / FINE_M
    near |= ~near.any(axis=1, keepdims=True)
    total = near.sum(axis=1)
    texels = []
    for places in (rows[:, ::SPARSE], columns[:, ::SPARSE]):
        low, high = places[tails], places[heads]
        down = (np.abs(high - low) / apart * near).sum(axis=1) / total
        across = (np.abs(np.gradient(low, axis=1)) * near).sum(axis=1) / total / (CELL_PX * SPARSE)
        texels.append(np.maximum(down, across).tolist())
    return list(zip(*texels, strict=True))


def _widen(grid: Floats, band: Band, width_px: int) -> Floats:
    """A band's lines of the grid -> one value per sampled pixel, linear between; the outermost cells lie outside the picture."""
    size = (grid.shape[1] * CELL_PX, grid.shape[0] * band.step)
    wide = np.asarray(cv2.resize(grid, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)[:, CELL_PX : CELL_PX + width_px]
    return wide if band.step == 1 else wide[band.step : band.step + band.last - band.first]


def _sample(target: Picture, band: Band, texture: Picture, map_x: Floats, map_y: Floats) -> None:
    if band.samples == 1:
        cv2.remap(texture, map_x, map_y, cv2.INTER_LINEAR, dst=target, borderMode=cv2.BORDER_REPLICATE)
        return
    many = cv2.remap(texture, map_x, map_y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    count = band.last - band.first
    while len(many) > 2 * count:
        half = len(many) // 2
        many = cv2.addWeighted(many[:half], 0.5, many[half:], 0.5, 0.0)
    cv2.addWeighted(many[:count], 0.5, many[count:], 0.5, 0.0, dst=target)


def _haze(canvas: Picture, view: View, all_bands: list[Band]) -> None:
    """Blend what is far towards the colour of the horizon."""
    first, horizon = all_bands[0].first, view.horizon_px
    last = min(round(horizon) + HAZE_ROWS * view.height_px // 720, all_bands[-1].last)
    colour = np.broadcast_to(HAZE_BGR.astype(np.uint8), canvas[first].shape).copy()[None]
    for row in range(first, last):
        distance = float(view.position_m[2]) * view.focal_px / max(row + 0.5 - horizon, 0.5)
        haze = min(HAZE_MOST, 1 - exp(-max(distance - 40.0, 0.0) / HAZE_LENGTH_M))
        cv2.addWeighted(canvas[row : row + 1], 1 - haze, colour, haze, 0.0, dst=canvas[row : row + 1])
