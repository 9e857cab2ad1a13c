"""The sheet: the ground along the road, unrolled into one texture of station by offset, with its reduced copies.

Rows run along the station, columns across from the right (negative offset) to the left. Columns are fine over road and
sidewalks and coarse beyond. The reduced copies halve rows and columns separately, because a road seen from a driver's eye
is foreshortened a hundred times more along than across. Colour is painted elsewhere (render.paving).
"""

from dataclasses import dataclass
from math import log2

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import Floats, Numbers, Picture

ROW_M = 0.05  # along the road
ROWS_MAX = 9000  # 450 m at ROW_M; a longer road gets longer rows, so that memory stays below 200 MB
FINE_M = 0.0125  # across: a tenth of a lane marking
COARSE_M = 0.05  # across, beyond the sidewalks
BEYOND_M = 10.0  # width of the coarse strip on either side
ROW_HALVINGS, COLUMN_HALVINGS = 8, 6


@dataclass(frozen=True, slots=True)
class Sheet:
    """Geometry of the texture. Texel i covers [i, i + 1) of `row` and `column`."""

    first_station_m: float
    last_station_m: float
    fine_half_m: float  # fine columns reach from -this to +this

    @property
    def row_m(self) -> float:
        return max(ROW_M, (self.last_station_m - self.first_station_m) / ROWS_MAX)

    @property
    def rows(self) -> int:
        return int((self.last_station_m - self.first_station_m) / self.row_m)

    @property
    def columns(self) -> int:
        return 2 * int(self.fine_half_m / FINE_M + BEYOND_M / COARSE_M)

    def row(self, station_m: Floats) -> Floats:
        rows: Floats = (station_m - np.float32(self.first_station_m)) * np.float32(1 / self.row_m)
        return rows

    def column(self, offset_m: Floats) -> Floats:
        """Offsets beyond the coarse strip get its outermost column."""
        fine = np.clip(offset_m, -self.fine_half_m, self.fine_half_m)
        coarse = np.clip(offset_m - fine, -BEYOND_M, BEYOND_M)
        columns: Floats = fine * np.float32(1 / FINE_M) + coarse * np.float32(1 / COARSE_M) + np.float32(self.columns / 2)
        return columns

    def offsets_m(self) -> Floats:
        """The offset of the middle of every column, ascending."""
        places = np.arange(self.columns, dtype=np.float32) + 0.5 - self.columns / 2
        edge = self.fine_half_m / FINE_M
        fine = np.clip(places, -edge, edge)
        offsets: Floats = fine * np.float32(FINE_M) + (places - fine) * np.float32(COARSE_M)
        return offsets

    def texels(self, station_m: Floats, offset_m: Floats) -> Floats:
        """(N, 2) points for OpenCV's drawing (column, row), middle of the first texel at (0, 0)."""
        return np.stack((self.column(offset_m), self.row(station_m)), axis=-1) - 0.5


class Reduced:
    """The texture and its copies, each halved i times along and j times across, all in one picture.

    One picture, so that one call of OpenCV reads rows of several copies: i picks the rows of it, j the columns.
    """

    def __init__(self, texture: Picture) -> None:
        heights = _halved_sizes(texture.shape[0], ROW_HALVINGS)
        widths = _halved_sizes(texture.shape[1], COLUMN_HALVINGS)
        self._size = np.array(heights, np.float32), np.array(widths, np.float32)
        self._first = np.cumsum([0, *heights[:-1]]), np.cumsum([0, *widths[:-1]])
        self.all_copies: Picture = np.zeros((sum(heights), sum(widths), 4), np.uint8)
        along = texture
        for i in range(ROW_HALVINGS + 1):
            self._add_across(i, along)
            along = _halved(along, rows=True)

    def _add_across(self, i: int, texture: Picture) -> None:
        across = texture
        for j in range(min(i + 1, COLUMN_HALVINGS) + 1):  # more across than along is hardly ever looked at
            self._copy(i, j)[:] = across
            across = _halved(across, rows=False)

    def _copy(self, i: int, j: int) -> Picture:
        row, column = self._first[0][i], self._first[1][j]
        return self.all_copies[row : row + int(self._size[0][i]), column : column + int(self._size[1][j])]

    def pick(self, rows_per_sample: float, columns_per_sample: float) -> tuple[int, int, Picture]:
        """The copy whose texels are about as large as one sample's footprint: halvings (i, j) and the copy."""
        i = _halvings(rows_per_sample, ROW_HALVINGS)
        j = min(_halvings(columns_per_sample, COLUMN_HALVINGS), i + 1)
        return i, j, self._copy(i, j)

    def places(self, rows: Floats, columns: Floats, copies: Numbers) -> tuple[Floats, Floats]:
        """Where in `all_copies` OpenCV finds rows and columns (lines, N) of the texture: x and y.

        copies  (lines, 2) halvings (i, j) of the copy each line is read from
        """
        y, x = (
            np.minimum(np.maximum(texels * np.float32(0.5) ** halvings - np.float32(0.5), np.float32(0)), size[halvings] - 1)
            + first[halvings].astype(np.float32)
            for texels, halvings, size, first in zip((rows, columns), copies.T[..., None], self._size, self._first, strict=True)
        )
        return x, y


def _halved_sizes(size: int, most: int) -> list[int]:
    """Of the copies along one side, as `_halved` makes them."""
    return [max(1, size >> k) for k in range(most + 1)]


def _halvings(texels: float, most: int) -> int:
    return int(min(max(log2(max(texels, 1e-6)) + 0.5, 0.0), most))


def _halved(texture: Picture, rows: bool) -> Picture:
    height, width = texture.shape[:2]
    size = (width, max(1, height // 2)) if rows else (max(1, width // 2), height)
    even = texture[: size[1] * 2] if rows else texture[:, : size[0] * 2]
    return np.asarray(cv2.resize(even, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)
