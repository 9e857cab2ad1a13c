"""Trees as upright pictures that turn towards the camera: a few kinds, painted once of many leaves. Deterministic."""

from dataclasses import dataclass

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import SHIFT, fixed, halvings, stamp
from vehicle_gateway.video.render.perspective import Box
from vehicle_gateway.video.render.projection import NEAR_M, Corners, Floats, Numbers, Picture, View
from vehicle_gateway.video.render.scenery import KINDS_OF_TREE, Tree

SIZE_PX = 448  # of a tree's picture, both ways
WIDTH_SHARE = 0.78  # a tree is this much as wide as high
HALVED = 6
SMALLEST_PX = 5.0  # a tree lower than this is left out
LIT_FROM_PX = 40.0  # the trunk of a lower crown has no lit side: it would be about a pixel wide
HEAPS, LEAVES_PER_STEP = 46, 26
_BARK, _BARK_LIT = (52.0, 66.0, 80.0, 255.0), (70.0, 88.0, 104.0, 255.0)
_LEAF = np.array([np.stack((np.cos(np.arange(5) * 1.2566 + a), 0.7 * np.sin(np.arange(5) * 1.2566 + a)), axis=1) for a in range(6)])
_LEAVES = ((42.0, 94.0, 68.0), (46.0, 104.0, 84.0), (56.0, 98.0, 66.0), (48.0, 92.0, 84.0))  # BGR per kind


class Trees:
    def __init__(self, trees: tuple[Tree, ...], seed: int) -> None:
        random = np.random.default_rng(seed + 2)
        self._crowns = [_cropped(_paint(kind, random)) for kind in range(KINDS_OF_TREE)]
        self._kinds = np.array([tree.kind for tree in trees], dtype=np.int64)
        self._extents = np.array([crown.extent for crown in self._crowns]).reshape(-1, 4)[self._kinds]
        self.feet_m = np.array([(tree.x_m, tree.y_m, 0.0) for tree in trees]).reshape(-1, 3)
        self._tops_m = np.array([(tree.x_m, tree.y_m, tree.height_m) for tree in trees]).reshape(-1, 3)
        self._crowns_px: list[tuple[float, float, float, float]] = []  # left, top, right, bottom
        self._trunks: Corners = np.zeros((0, 2, 4, 2), np.int32)

    def look(self, view: View) -> Numbers:
        """Numbers of the trees that may be in the picture. Call before `box` and `draw`."""
        feet, tops = view.to_camera(self.feet_m), view.to_camera(self._tops_m)
        ahead = (feet[:, 2] > 2 * NEAR_M) & (tops[:, 2] > 2 * NEAR_M)
        foot, top = (view.to_pixels(np.where(ahead[:, None], p, (0.0, 0.0, 1.0))) for p in (feet, tops))
        size = np.linalg.norm(foot - top, axis=1)[:, None]
        extent = self._extents
        middle = foot + (top - foot) * (1 - extent[:, 1::2].mean(axis=1, keepdims=True))
        wide, high = (extent[:, 2] - extent[:, 0])[:, None] * WIDTH_SHARE, (extent[:, 3] - extent[:, 1])[:, None]
        aside = ((extent[:, 0] + extent[:, 2])[:, None] / 2 - 0.5) * WIDTH_SHARE * size * (1.0, 0.0)
        half = np.concatenate((wide, high), axis=1) * size / 2
        low, high = middle + aside - half, middle + aside + half
        self._crowns_px = [(u0, v0, u1, v1) for u0, v0, u1, v1 in np.concatenate((low, high), axis=1).tolist()]
        self._trunks = fixed(_trunks(foot, top))
        inside = (high[:, 0] > 0) & (low[:, 0] < view.width_px) & (foot[:, 1] > 0)
        return np.flatnonzero(ahead & inside & (size[:, 0] > SMALLEST_PX))

    def box(self, number: int) -> Box:
        """The part of the canvas a crown lies in; rows may lie outside."""
        u0, v0, u1, v1 = self._crowns_px[number]
        return max(0, int(u0)), int(v0), max(0, int(u1) + 1), int(v1) + 1

    def draw(self, canvas: Picture, number: int) -> None:
        trunk, lit = self._trunks[number]
        cv2.fillConvexPoly(canvas, trunk, _BARK, cv2.LINE_AA, SHIFT)
        crown_px = self._crowns_px[number]
        if crown_px[3] - crown_px[1] > LIT_FROM_PX:
            cv2.fillConvexPoly(canvas, lit, _BARK_LIT, cv2.LINE_AA, SHIFT)
        stamp(canvas, self._crowns[self._kinds[number]].copies, crown_px)


@dataclass(frozen=True, slots=True)
class _Crown:
    copies: list[Picture]
    extent: tuple[float, float, float, float]  # left, top, right, bottom in the square whose lowest row is the ground


def _cropped(picture: Picture) -> _Crown:
    """The painted part of a square, with its reduced copies."""
    rows, columns = (np.flatnonzero(picture[..., 3].any(axis=axis)) for axis in (1, 0))
    x0, y0, x1, y1 = int(columns[0]), int(rows[0]), int(columns[-1]) + 1, int(rows[-1]) + 1
    return _Crown(halvings(picture[y0:y1, x0:x1], HALVED), (x0 / SIZE_PX, y0 / SIZE_PX, x1 / SIZE_PX, y1 / SIZE_PX))


def _trunks(foot_px: Floats, top_px: Floats) -> Floats:
    """(N, 2, 4, 2): trunk and its lit side, from the ground up into the crown."""
    up = top_px - foot_px
    across = np.stack((-up[:, 1], up[:, 0]), axis=1)  # of the tree's height, to the right in the picture
    shapes = []
    for left_low, right_low, left_high, right_high in ((-0.022, 0.022, -0.012, 0.012), (0.003, 0.021, 0.002, 0.011)):
        shapes.append(
            np.stack(
                (
                    foot_px + across * left_low,
                    foot_px + across * right_low,
                    foot_px + 0.5 * up + across * right_high,
                    foot_px + 0.5 * up + across * left_high,
                ),
                axis=1,
            )
        )
    return np.stack(shapes, axis=1)


def _paint(kind: int, random: np.random.Generator) -> Picture:
    """A crown, premultiplied BGRA, in a square whose lowest row is the ground. Smooth edges on black give the alpha."""
    picture = np.zeros((SIZE_PX, SIZE_PX, 4), np.uint8)
    middle, fork = SIZE_PX / 2, SIZE_PX * 0.62
    for reach in (-70, -30, 40, 76):
        cv2.line(picture, (round(middle), round(fork)), (round(middle + reach), round(fork - 100)), _BARK, 6, cv2.LINE_AA)
    heaps = _heaps(kind, random)
    heaps = heaps[np.argsort(-heaps[:, 1])]
    spots, sizes, tones = _leaves(heaps, random)
    leaf = _LEAF[random.integers(len(_LEAF), size=len(spots))]
    shapes = fixed(spots[:, None] + sizes[:, None, None] * leaf)
    colours = np.clip(tones[:, None] * np.array(_LEAVES[kind]), 0, 255).tolist()
    for shape, colour in zip(shapes, colours, strict=True):
        cv2.fillConvexPoly(picture, shape, (*colour, 255.0), cv2.LINE_AA, SHIFT)
    return picture


def _heaps(kind: int, random: np.random.Generator) -> Floats:
    """Middles and radii (pixels) of the heaps of leaves that make a crown: round, or slimmer and higher."""
    slim = 0.62 if kind % 2 else 0.9
    turn, out = random.uniform(0, 2 * np.pi, HEAPS), np.sqrt(random.uniform(0, 1, HEAPS))
    x = SIZE_PX * (0.5 + 0.36 * slim * out * np.cos(turn))
    y = SIZE_PX * (0.36 + 0.27 * out * np.sin(turn))
    return np.stack((x, y, SIZE_PX * random.uniform(0.06, 0.11, HEAPS)), axis=1)


def _leaves(heaps: Floats, random: np.random.Generator) -> tuple[Floats, Floats, Floats]:
    """Middle, size and tone of every leaf, in drawing order: each heap dark below, lighter towards the upper left."""
    step = np.tile(np.repeat(np.arange(4), LEAVES_PER_STEP), len(heaps))
    x, y, radius = np.repeat(heaps, 4 * LEAVES_PER_STEP, axis=0).T
    spread = radius * (0.52 - 0.07 * step)
    spots = np.stack((x - 0.16 * radius * step, y - 0.20 * radius * step), axis=1)
    spots += np.clip(random.standard_normal((len(step), 2)), -1.7, 1.7) * spread[:, None]
    tones = (0.56 + 0.19 * step + 0.16 * (0.5 - y / SIZE_PX)) * random.uniform(0.86, 1.14, len(step))
    return spots, random.uniform(2.6, 6.0, len(step)), tones
