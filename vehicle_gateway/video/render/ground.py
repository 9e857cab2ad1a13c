"""The ground of one picture: every pixel below the horizon, looked up on the sheet. Fast: about a quarter of a frame's time.

For every row of the picture and every 32nd column the ray's point on the ground is turned into (station, offset); between
the columns the coordinates are interpolated. Rows are grouped in parts, each of which reads the reduced copy whose texels
are as large as its pixels, and parts in bands that are read by one call: all copies lie in one picture. Towards the horizon
a row is the mean of two or four sampled rows. Both keep lines from flickering. Ground is flat (z = 0): a kerb is colour only.
"""

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from math import exp

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import Floats, Numbers, Picture, View
from vehicle_gateway.video.render.road_frame import RoadFrame
from vehicle_gateway.video.render.sheet import FINE_M, Reduced, Sheet

CELL_PX, ROW_STEP_PX = 32, 4  # of the grid; rows only where a row more or less makes no visible difference
FARTHEST_M = 1500.0
PART_ROWS = (0, 2, 3, 4, 6, 8, 11, 15, 21, 29, 40, 56, 79, 111, 157, 222, 314, 444, 100000)  # rows below the horizon
BAND_ROWS = (0, 15, 40)  # of them those where far away a band begins: walls hide the upper ones more often
FOUR_SAMPLES_ABOVE, TWO_SAMPLES_ABOVE = 15, 79  # rows below the horizon, for a height of 720
HAZE_BGR = np.array([226.0, 216.0, 204.0, 255.0], dtype=np.float32)
HAZE_LENGTH_M = 420.0  # after this way a share of 1 - 1/e is haze
HAZE_MOST = 0.5  # at the horizon, where the tree line's own haze meets it
HAZE_ROWS = 26  # below the horizon, for a height of 720; nearer there is next to none
SHORTEST_CUT_CELLS = 5
SPARSE = 3  # of the grid's columns, one in so many decides which copy is read


@dataclass(frozen=True, slots=True)
class Band:
    """Rows [first, last) of the picture that are sampled in one go, each the mean of `samples` rows read from the sheet.

    The grid knows every sampled row (step 1) or, near the car, every `step`-th row and one beyond either end; its lines of
    a band stand from `at` on in the list of all.
    """

    first: int
    last: int
    samples: int
    step: int
    at: int

    @property
    def lines(self) -> slice:
        rows = self.last - self.first
        return slice(self.at, self.at + (rows * self.samples if self.step == 1 else -(-rows // self.step) + 2))

    def v_px(self) -> Floats:
        """Of the grid's lines. With several samples: the first of all rows, then the second of all, and so on."""
        if self.step == 1:
            rows = np.arange(self.first, self.last)
            return np.concatenate([rows + (k + 0.5) / self.samples for k in range(self.samples)]).astype(np.float32)
        count = self.lines.stop - self.lines.start
        return (self.first + (np.arange(count) - 0.5) * self.step).astype(np.float32)

    def ends(self, first: int, last: int) -> tuple[int, int, float]:
        """Of some of its rows: the first and the last line, and how many sampled rows these are apart."""
        if self.step == 1:
            back = (self.samples - 1) * (self.last - self.first)
            return self.at + first - self.first, self.at + back + last - 1 - self.first, (last - first) * self.samples - 1.0
        return self.lines.start, self.lines.stop - 1, (self.lines.stop - 1.0 - self.lines.start) * self.step


@dataclass(frozen=True, slots=True)
class Layout:
    """How the rows of a picture are read: in bands, and within a band in parts that each read one reduced copy."""

    bands: tuple[Band, ...]
    v_px: Floats  # of all the bands' lines
    heads: Numbers  # per part its first line
    tails: Numbers  # and its last
    apart: Floats  # (parts, 1) sampled rows between the two
    part_of: Numbers  # per line


@lru_cache(256)  # a car that drives dips by a few rows, back and forth
def layout(horizon_row: int, end_row: int, height_px: int) -> Layout | None:
    """From the horizon down to `end_row`; rows above the picture are left out. None when nothing is left."""
    bands: list[Band] = []
    parts: list[tuple[int, int, float]] = []
    part_of: list[Numbers] = []
    for samples, edges in _reach(height_px / 720):
        rows = [min(max(0, horizon_row + edge), end_row) for edge in edges]
        if rows[0] == rows[-1]:
            continue
        band = Band(rows[0], rows[-1], samples, ROW_STEP_PX if samples == 1 else 1, bands[-1].lines.stop if bands else 0)
        used = [(first, last) for first, last in pairwise(rows) if first < last]
        numbers = np.repeat(np.arange(len(used)) + len(parts), [last - first for first, last in used])
        part_of.append(np.tile(numbers, samples) if band.step == 1 else np.full(len(band.v_px()), len(parts)))
        parts += [band.ends(first, last) for first, last in used]
        bands.append(band)
    if not bands:
        return None
    heads, tails, apart = (np.array(values) for values in zip(*parts, strict=True))
    v_px = np.concatenate([band.v_px() for band in bands])
    return Layout(tuple(bands), v_px, heads, tails, np.maximum(apart, 1.0)[:, None], np.concatenate(part_of))


def _reach(scale: float) -> list[tuple[int, list[int]]]:
    """Samples and edges (rows below the horizon) of the parts of every band. Near the car a band is one part."""
    bands: list[tuple[int, list[int]]] = []
    for low, high in pairwise(PART_ROWS):
        samples = 4 if high <= FOUR_SAMPLES_ABOVE * scale else 2 if high <= TWO_SAMPLES_ABOVE * scale else 1
        if samples > 1 and bands and bands[-1][0] == samples and low not in BAND_ROWS:
            bands[-1][1].append(high)
        else:
            bands.append((samples, [low, high]))
    return bands


@dataclass(frozen=True, slots=True)
class Hidden:
    """What will be painted over, per `cell_px` columns: rows [first, last) by walls, rows from `bonnet_from` on by the car."""

    cell_px: int
    walls: Numbers  # (cells, 2)
    bonnet_from: Numbers  # (cells,)

    def runs(self, all_bands: tuple[Band, ...], width_px: int) -> list[list[slice]]:
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
        plan = layout(rows_px[0], min(rows_px[1], view.height_px), view.height_px)
        if plan is None:
            return
        rows, columns = self._places(view, plan.v_px, station_m)
        copies = [self._reduced.pick(*texels)[:2] for texels in _footprints(rows, columns, plan, self._sheet)]
        map_x, map_y = self._reduced.places(rows, columns, np.array(copies)[plan.part_of])
        for band, runs in zip(plan.bands, hidden.runs(plan.bands, view.width_px), strict=True):
            if runs:
                cells = slice(runs[0].start // CELL_PX, -(-runs[-1].stop // CELL_PX) + 2)
                wide_x, wide_y = (_widen(places[band.lines, cells], band) for places in (map_x, map_y))
                for run in runs:
                    here = slice(run.start - cells.start * CELL_PX, run.stop - cells.start * CELL_PX)
                    target = canvas[band.first : band.last, run]
                    _sample(target, band, self._reduced.all_copies, wide_x[:, here], wide_y[:, here])
        _haze(canvas, view, plan.bands)

    def _places(self, view: View, v_px: Floats, station_m: float) -> tuple[Floats, Floats]:
        """Sheet rows and columns of the grid's points."""
        cells = -(-view.width_px // CELL_PX) + 2
        u_px = (np.arange(cells, dtype=np.float32) - 0.5) * CELL_PX
        x, y = _on_ground(view, u_px, v_px)
        station, offset = self._frame.to_road(x, y, (float(view.position_m[0]), float(view.position_m[1])), station_m)
        return self._sheet.row(station), self._sheet.column(offset)


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


def _footprints(rows: Floats, columns: Floats, plan: Layout, sheet: Sheet) -> list[tuple[float, float]]:
    """Per part the texels that one sample covers along and across: the mean over what lies near the road."""
    near = np.abs(columns[plan.tails, ::SPARSE] - sheet.columns / 2) < sheet.fine_half_m / FINE_M
    near |= ~near.any(axis=1, keepdims=True)
    total = near.sum(axis=1)
    texels = []
    for places in (rows[:, ::SPARSE], columns[:, ::SPARSE]):
        low, high = places[plan.tails], places[plan.heads]
        down = (np.abs(high - low) / plan.apart * near).sum(axis=1) / total
        across = (np.abs(np.gradient(low, axis=1)) * near).sum(axis=1) / total / (CELL_PX * SPARSE)
        texels.append(np.maximum(down, across).tolist())
    return list(zip(*texels, strict=True))


def _widen(grid: Floats, band: Band) -> Floats:
    """Some cells of a band's lines -> one value per sampled pixel, linear between, without the outer half of either end."""
    size = (grid.shape[1] * CELL_PX, grid.shape[0] * band.step)
    wide = np.asarray(cv2.resize(grid, size, interpolation=cv2.INTER_LINEAR), dtype=np.float32)[:, CELL_PX:]
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


def _haze(canvas: Picture, view: View, all_bands: tuple[Band, ...]) -> None:
    """Blend what is far towards the colour of the horizon."""
    first, horizon = all_bands[0].first, view.horizon_px
    last = min(round(horizon) + HAZE_ROWS * view.height_px // 720, all_bands[-1].last)
    colour = np.broadcast_to(HAZE_BGR.astype(np.uint8), canvas[first].shape).copy()[None]
    for row in range(first, last):
        distance = float(view.position_m[2]) * view.focal_px / max(row + 0.5 - horizon, 0.5)
        haze = min(HAZE_MOST, 1 - exp(-max(distance - 40.0, 0.0) / HAZE_LENGTH_M))
        cv2.addWeighted(canvas[row : row + 1], 1 - haze, colour, haze, 0.0, dst=canvas[row : row + 1])
