"""Colours of the ground: asphalt, kerbs, paved sidewalks, grass, lane markings, repairs and shadows, painted on a sheet.

Deterministic for the seed. Nothing here knows the camera. Dimensions of markings after the German RMS (narrow line 0.12 m,
3 m dashes with 6 m gaps inside towns); those of kerb stones and slabs as commonly laid.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from vehicle_gateway.video.render.noise import coloured, fractal, smooth, to_bytes
from vehicle_gateway.video.render.projection import Floats, Picture
from vehicle_gateway.video.render.sheet import Sheet
from wire.road import Road

TILE_ROWS = 1024  # asphalt and grass repeat after this many rows
LINE_WIDTH_M, DASH_M, GAP_M = 0.12, 3.0, 6.0
EDGE_LINE_M = 0.20  # from the kerb to the middle of the edge line
KERB_WIDTH_M, KERB_FACE_M, KERB_STONE_M = 0.16, 0.09, 1.0
SLAB_M = 0.5
MARKING_BGR = (226.0, 232.0, 232.0)


@dataclass(frozen=True, slots=True)
class Edges:
    """Half widths of the street's cross-section."""

    kerb_m: float
    walk_m: float  # outer edge of the sidewalk

    @classmethod
    def of(cls, road: Road) -> "Edges":
        return cls(road.half_width_m, road.half_width_m + road.map.sidewalk_width_m)


def pave(sheet: Sheet, road: Road, seed: int) -> Picture:
    """(rows, columns, 4) BGRA: the whole ground without shadows."""
    random = np.random.default_rng(seed)
    edges = Edges.of(road)
    texture = _surface(sheet, edges, random)
    _repairs(texture, sheet, edges, random)
    _iron(texture, sheet, edges, random)
    _kerbs(texture, sheet, edges, random)
    _markings(texture, sheet, edges, random)
    return texture


def _surface(sheet: Sheet, edges: Edges, random: np.random.Generator) -> Picture:
    """Asphalt, slabs and grass, each in its columns, repeated along the road."""
    offsets = sheet.offsets_m()
    distance = np.abs(offsets)
    tile = np.zeros((TILE_ROWS, sheet.columns, 4), np.uint8)
    meadow = np.flatnonzero(distance >= edges.walk_m - 0.2)
    tile[:, meadow] = to_bytes(_grass(distance[meadow], random))
    walk = np.flatnonzero((distance >= edges.kerb_m) & (distance < edges.walk_m))
    if len(walk):
        tile[:, walk] = to_bytes(_slabs(sheet, offsets[walk], random))
    lane = np.flatnonzero(distance < edges.kerb_m)
    tile[:, lane] = to_bytes(_asphalt(offsets[lane], edges, random))
    _soft_verge(tile, distance, edges, random)
    repeats = -(-sheet.rows // TILE_ROWS)
    return np.ascontiguousarray(np.concatenate([tile] * repeats)[: sheet.rows])


def _asphalt(offsets_m: Floats, edges: Edges, random: np.random.Generator) -> Floats:
    columns = len(offsets_m)
    light = 1 + 0.035 * random.standard_normal((TILE_ROWS, columns), dtype=np.float32)
    light += 0.030 * smooth(random, TILE_ROWS, columns, 2, 7) + 0.028 * fractal(random, TILE_ROWS, columns, 60, 130, 3)
    across = np.abs(np.abs(offsets_m) - edges.kerb_m / 2)  # from the middle of a lane
    tracks = 0.055 * np.exp(-(((across - 0.75) / 0.28) ** 2)) - 0.05 * np.exp(-((across / 0.3) ** 2))
    gutter = -0.16 * np.exp(-((edges.kerb_m - np.abs(offsets_m)) / 0.16))
    return coloured(light + tracks + gutter, (101.0, 99.0, 97.0))


def _slabs(sheet: Sheet, offsets_m: Floats, random: np.random.Generator) -> Floats:
    columns = len(offsets_m)
    per_slab = max(2, round(SLAB_M / sheet.row_m))
    row_slab = np.arange(TILE_ROWS) // per_slab
    across = np.floor(offsets_m / SLAB_M).astype(np.int64)
    tone = random.standard_normal((int(row_slab[-1]) + 1, 64), dtype=np.float32)
    light = 1 + 0.035 * tone[row_slab[:, None], across[None, :] % 64]
    light += 0.02 * random.standard_normal((TILE_ROWS, columns), dtype=np.float32)
    light += 0.03 * fractal(random, TILE_ROWS, columns, 50, 80, 3)
    light[np.arange(TILE_ROWS) % per_slab == 0] -= 0.10
    light[:, np.abs(offsets_m / SLAB_M - np.round(offsets_m / SLAB_M)) * SLAB_M < 0.009] -= 0.16
    return coloured(light, (150.0, 158.0, 164.0))


def _grass(distance_m: Floats, random: np.random.Generator) -> Floats:
    """Plain towards the sheet's outermost columns, which stand for everything beyond."""
    columns = len(distance_m)
    lively = np.clip((distance_m.max() - 0.5 - distance_m) / 4.0, 0, 1)
    light = 0.09 * random.standard_normal((TILE_ROWS, columns), dtype=np.float32)
    light += 0.09 * fractal(random, TILE_ROWS, columns, 24, 24, 3)
    dry = 0.5 + lively[:, None] * 0.22 * smooth(random, TILE_ROWS, columns, 90, 70)[..., None]
    light = 1 + light * lively
    lush, straw = coloured(light, (62.0, 108.0, 86.0)), coloured(light, (84.0, 134.0, 122.0))
    mixed: Floats = lush + (straw - lush) * dry
    return mixed


def _soft_verge(tile: Picture, distance_m: Floats, edges: Edges, random: np.random.Generator) -> None:
    """Grass grows over the sidewalk's outer edge unevenly; a strip of earth lies between."""
    reach = edges.walk_m - 0.03 + 0.05 * fractal(random, TILE_ROWS, 8, 5, 8, 2)[:, :1]
    earth = (distance_m[None, :] > reach) & (distance_m[None, :] < reach + 0.10)
    tile[..., :3][earth] = (tile[..., :3][earth] * 0.35 + np.array([48.0, 66.0, 78.0]) * 0.65).astype(np.uint8)


def _columns(sheet: Sheet, first_m: float, last_m: float) -> slice:
    low, high = sheet.column(np.array([min(first_m, last_m), max(first_m, last_m)], dtype=np.float32))
    return slice(max(0, round(float(low))), round(float(high)))


def _rows(sheet: Sheet, first_m: float, last_m: float) -> slice:
    low, high = sheet.row(np.array([first_m, last_m], dtype=np.float32))
    return slice(max(0, round(float(low))), max(0, round(float(high))))


def _shade(texture: Picture, rows: slice, columns: slice, factor: float) -> None:
    part = texture[rows, columns]
    texture[rows, columns] = cv2.multiply(part, np.array([factor, factor, factor, 1.0])).reshape(part.shape) if part.size else part


def _repairs(texture: Picture, sheet: Sheet, edges: Edges, random: np.random.Generator) -> None:
    """Patches of newer asphalt with a sealed seam, joints across, and cracks."""
    station = sheet.first_station_m + 3.0
    while station < sheet.last_station_m - 8:
        first, width = random.uniform(-edges.kerb_m + 0.3, edges.kerb_m - 1.8), random.uniform(0.7, 1.6)
        length = random.uniform(1.2, 6.0)
        _patch(texture, sheet, (station, station + length), (first, first + width), random.uniform(0.80, 0.93))
        station += length + random.uniform(6.0, 20.0)
    for at in np.arange(sheet.first_station_m + 11.0, sheet.last_station_m, 24.0):
        _crack(texture, sheet, [(float(at), -edges.kerb_m), (float(at) + 0.1, edges.kerb_m)], 14, 0.05, random)
    for _ in range(int((sheet.last_station_m - sheet.first_station_m) / 7)):
        at, offset = random.uniform(sheet.first_station_m, sheet.last_station_m), random.uniform(-edges.kerb_m, edges.kerb_m)
        turn = random.uniform(-0.8, 0.8)
        ends = [(at, offset), (at + random.uniform(1.0, 5.0), float(np.clip(offset + turn, -edges.kerb_m, edges.kerb_m)))]
        _crack(texture, sheet, ends, 12, 0.10, random)


def _patch(texture: Picture, sheet: Sheet, stations_m: tuple[float, float], offsets_m: tuple[float, float], factor: float) -> None:
    seam = 0.03
    _shade(
        texture,
        _rows(sheet, stations_m[0] - 0.05, stations_m[1] + 0.05),
        _columns(sheet, offsets_m[0] - seam, offsets_m[1] + seam),
        0.66,
    )
    _shade(texture, _rows(sheet, *stations_m), _columns(sheet, *offsets_m), factor / 0.66)


def _crack(
    texture: Picture, sheet: Sheet, ends: list[tuple[float, float]], steps: int, wander_m: float, random: np.random.Generator
) -> None:
    along = np.linspace(0, 1, steps)[:, None]
    path = np.array(ends[0]) * (1 - along) + np.array(ends[1]) * along
    path += wander_m * np.cumsum(random.standard_normal((steps, 2)), axis=0) / steps**0.5
    texels = sheet.texels(path[:, 0].astype(np.float32), path[:, 1].astype(np.float32))
    cv2.polylines(texture, [np.round(texels).astype(np.int32)], False, (66, 64, 62, 255), 1, cv2.LINE_AA)


def _iron(texture: Picture, sheet: Sheet, edges: Edges, random: np.random.Generator) -> None:
    """Manhole covers in the lanes and drains at the kerb."""
    for station in np.arange(sheet.first_station_m + 9.0, sheet.last_station_m - 2, 31.0):
        at = float(station) + random.uniform(-6.0, 6.0)
        offset = float(random.choice([-1.0, 1.0])) * edges.kerb_m / 2 + random.uniform(-0.4, 0.4)
        for radius, grey in ((0.37, 72), (0.32, 58), (0.29, 82), (0.20, 66), (0.17, 80)):
            _disc(texture, sheet, at, offset, radius, (grey, grey, grey + 2, 255))
    for station in np.arange(sheet.first_station_m + 5.0, sheet.last_station_m - 2, 22.0):
        for side in (-1.0, 1.0):
            inner, outer = side * (edges.kerb_m - 0.45), side * (edges.kerb_m - 0.08)
            texture[_rows(sheet, float(station), float(station) + 0.5), _columns(sheet, inner, outer), :3] = 46
            for slot in np.arange(0.0, 0.5, 0.1):
                texture[
                    _rows(sheet, float(station) + slot, float(station) + slot + 0.05),
                    _columns(sheet, inner + side * 0.04, outer - side * 0.04),
                    :3,
                ] = 78


def _disc(
    texture: Picture, sheet: Sheet, station_m: float, offset_m: float, radius_m: float, colour: tuple[int, int, int, int]
) -> None:
    turn = np.linspace(0, 2 * np.pi, 28, endpoint=False)
    points = sheet.texels(
        (station_m + radius_m * np.sin(turn)).astype(np.float32), (offset_m + radius_m * np.cos(turn)).astype(np.float32)
    )
    cv2.fillPoly(texture, [np.round(points * 16).astype(np.int32)], colour, cv2.LINE_AA, 4)


def _kerbs(texture: Picture, sheet: Sheet, edges: Edges, random: np.random.Generator) -> None:
    """A light top with joints and a face in shade towards the road: the step is painted, the ground stays flat."""
    stones = np.floor(np.arange(sheet.rows) * sheet.row_m / KERB_STONE_M).astype(np.int64)
    tone = 1 + 0.05 * random.standard_normal(int(stones[-1]) + 1)[stones]
    joint = (np.arange(sheet.rows) * sheet.row_m) % KERB_STONE_M < sheet.row_m
    for side in (-1.0, 1.0):
        face = _columns(sheet, side * (edges.kerb_m - KERB_FACE_M), side * edges.kerb_m)
        top = _columns(sheet, side * edges.kerb_m, side * (edges.kerb_m + KERB_WIDTH_M))
        for columns, grey in ((face, 84.0), (top, 188.0)):
            lit = np.where(joint, 0.72, tone) * grey
            texture[:, columns, :3] = np.clip(lit[:, None, None] * (0.96, 0.99, 1.0), 0, 255).astype(np.uint8)


def _markings(texture: Picture, sheet: Sheet, edges: Edges, random: np.random.Generator) -> None:
    half = LINE_WIDTH_M / 2
    wear = np.clip(1.0 + 0.20 * fractal(random, TILE_ROWS, 64, 14, 12, 3), 0.55, 1.0)
    for side in (-1.0, 1.0):
        middle = side * (edges.kerb_m - EDGE_LINE_M - KERB_FACE_M)
        _line(
            texture, _rows(sheet, sheet.first_station_m, sheet.last_station_m), _columns(sheet, middle - half, middle + half), wear
        )
    for station in dash_starts(sheet.first_station_m, sheet.last_station_m):
        _line(texture, _rows(sheet, station, station + DASH_M), _columns(sheet, -half, half), wear)


def dash_starts(first_m: float, last_m: float) -> Iterable[float]:
    """Stations at which a dash of the centre line begins: every DASH_M + GAP_M, one of them at station 0."""
    period = DASH_M + GAP_M
    return (i * period for i in range(int(np.ceil(first_m / period)), int((last_m - DASH_M) / period) + 1))


def _line(texture: Picture, rows: slice, columns: slice, wear: Floats) -> None:
    part = texture[rows, columns, :3]
    at = (np.arange(part.shape[0]) + rows.start) % TILE_ROWS
    cover = wear[at][:, : part.shape[1], None].astype(np.float32)
    part[:] = (part * (1 - cover) + np.array(MARKING_BGR, dtype=np.float32) * cover).astype(np.uint8)
