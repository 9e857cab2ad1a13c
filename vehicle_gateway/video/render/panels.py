"""Textured upright rectangles: walls and hedges, drawn in true perspective from a copy of fitting size.

A panel that is near is cut into bays, each short enough that one reduced copy suits it. All panels are transformed together,
then drawn one by one in the painter's order.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import SHIFT, Colour, fixed
from vehicle_gateway.video.render.order import Wall
from vehicle_gateway.video.render.perspective import Box, Copies, boxes, from_pixels, in_picture, levels, reduce, to_texture
from vehicle_gateway.video.render.projection import Corners, Flags, Floats, Numbers, Picture, View

BAY_M = 5.0
FLAT_BELOW_PX2 = 120
NEAR_LENGTHS = 1.6  # a panel nearer than so many of its lengths is drawn by bays


@dataclass(frozen=True, slots=True)
class Panel:
    """Seen from outside: `left` and `right` foot (x, y) in the map frame, standing on the ground."""

    left_m: tuple[float, float]
    right_m: tuple[float, float]
    height_m: float
    texture: Picture  # BGRA, opaque; one picture may serve several panels
    columns: int  # of the texture, from its left edge, that the panel shows


@dataclass(slots=True)  # not frozen: made dozens of times a picture, and a frozen one takes three times as long to make
class Job:
    """One call to OpenCV: a texture, the way from the canvas to it, the part of the canvas, and what it covers."""

    texture: Picture
    to_texture: Floats
    box: Box
    covers_px: Wall  # NaN when cut by the near plane
    outline: Corners
    colour: Colour | None  # of a panel so small that its texture would not show

    def draw(self, canvas: Picture) -> None:
        if self.colour is not None:
            cv2.fillConvexPoly(canvas, self.outline, self.colour, cv2.LINE_AA, SHIFT)
            return
        x0, y0, x1, y1 = self.box
        cv2.warpPerspective(
            self.texture,
            self.to_texture,
            (x1 - x0, y1 - y0),
            dst=canvas[y0:y1, x0:x1],
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_TRANSPARENT,
        )


class Panels:
    """All panels of a scene. The owner of a panel is the number of the block it belongs to."""

    def __init__(self, panels: list[tuple[int, Panel]]) -> None:
        reduced: dict[int, Copies] = {}
        for _, panel in panels:
            if id(panel.texture) not in reduced:
                reduced[id(panel.texture)] = reduce(panel.texture)
        cuts = [(number, cut) for number, (_, panel) in enumerate(panels) for cut in _cuts(panel)]
        self._copies = [reduced[id(panel.texture)] for _, panel in panels]
        self._colours = [_mean(panel.texture) for _, panel in panels]
        self._owners = [owner for owner, _ in panels]
        self._numbers = np.array([number for number, _ in cuts], dtype=np.int64)
        self._whole = np.array([whole for _, (_, _, whole) in cuts], dtype=bool)
        quads = [_quad(panels[number][1], first, last) for number, (first, last, _) in cuts]
        self._corners = np.array(quads, dtype=np.float64).reshape(-1, 4, 3)
        shown = [(first * panels[number][1].columns, last * panels[number][1].columns) for number, (first, last, _) in cuts]
        self._columns = np.array(shown, dtype=np.float64).reshape(-1, 2)
        self._ends = np.array([[panel.left_m, panel.right_m] for _, panel in panels], dtype=np.float64).reshape(-1, 2, 2)
        self._lengths = np.linalg.norm(self._ends[:, 1] - self._ends[:, 0], axis=1)
        sizes = [panel.texture.shape[1::-1] for _, panel in panels]
        self._sizes = np.array(sizes, dtype=np.int64).reshape(-1, 2)[self._numbers]

    def look(self, view: View) -> dict[int, list[Job]]:
        """What may be seen, per owner, farthest first."""
        if not len(self._corners):
            return {}
        near = _distance(self._ends, view.position_m[:2]) < NEAR_LENGTHS * self._lengths
        picked = np.flatnonzero(_faces(view, self._corners) & (self._whole != near[self._numbers]))
        camera = view.to_camera(self._corners[picked])
        maybe = in_picture(view, camera)
        picked, camera = picked[maybe], camera[maybe]
        places, pixels = boxes(view, camera)
        seen = (places[:, 0] < places[:, 2]) & (places[:, 1] < places[:, 3])
        return self._jobs(view, picked[seen], camera[seen], places[seen], pixels[seen])

    def _jobs(self, view: View, picked: Numbers, camera_m: Floats, places: Numbers, pixels: Floats) -> dict[int, list[Job]]:
        columns, sizes = self._columns[picked], self._sizes[picked]
        i, j = levels(view, camera_m, np.stack((columns[:, 1] - columns[:, 0], sizes[:, 1]), axis=1), sizes)
        size = sizes >> np.stack((i, j), axis=1)
        # the panel's outline lies on the middles of the outermost texels: OpenCV leaves out what lies beyond them
        shown = columns * ((size[:, :1] - 1) / sizes[:, :1])
        first = np.maximum(0, shown[:, 0].astype(np.int64) - 1)  # a bay reads one column more than it shows:
        last = np.minimum(size[:, 0], shown[:, 1].astype(np.int64) + 2)  # no gap between neighbours
        start = np.stack((shown[:, 0] - first, np.zeros(len(first))), axis=1)
        extent = np.stack((shown[:, 1] - shown[:, 0], size[:, 1] - 1.0), axis=1)
        matrices = to_texture(from_pixels(view, camera_m), start, extent, places[:, :2])
        outlines = fixed(np.nan_to_num(pixels))
        area = (places[:, 2] - places[:, 0]) * (places[:, 3] - places[:, 1])
        flat = ((area < FLAT_BELOW_PX2) & ~np.isnan(pixels[:, 0, 0])).tolist()
        lists = zip(
            self._numbers[picked].tolist(),
            i.tolist(),
            j.tolist(),
            first.tolist(),
            last.tolist(),
            matrices,
            places.tolist(),
            _covers(pixels).tolist(),
            outlines,
            flat,
            strict=True,
        )
        jobs = [
            (
                self._owners[number],
                Job(
                    self._copies[number][a, b][:, low:high],
                    matrix,
                    tuple(box),
                    tuple(top),
                    outline,
                    self._colours[number] if is_flat else None,
                ),
            )
            for number, a, b, low, high, matrix, box, top, outline, is_flat in lists
        ]
        order: dict[int, list[Job]] = {}
        for k in np.argsort(-np.linalg.norm(camera_m.mean(axis=1), axis=1)).tolist():
            owner, job = jobs[k]
            order.setdefault(owner, []).append(job)
        return order


def _covers(pixels: Floats) -> Floats:
    """(N, 4, 2) corners -> render.order.Wall: the part whose columns run from the top edge down to the foot."""
    (u0, v0), (u1, v1), (u2, v2), (u3, v3) = (pixels[:, k].T for k in range(4))
    left, right = np.maximum(u0, u3), np.minimum(u1, u2)  # a leaning camera shifts one edge over the other
    rise, fall = (v1 - v0) / np.maximum(u1 - u0, 1e-6), (v2 - v3) / np.maximum(u2 - u3, 1e-6)
    return np.stack(
        (left, v0 + rise * (left - u0), v3 + fall * (left - u3), right, v0 + rise * (right - u0), v3 + fall * (right - u3)), axis=1
    )


def _mean(texture: Picture) -> Colour:
    blue, green, red, _ = cv2.mean(texture)
    return blue, green, red


def _cuts(panel: Panel) -> list[tuple[float, float, bool]]:
    """The whole panel, and its bays: from and to as shares of its length, and whether it is the whole."""
    length = float(np.hypot(panel.right_m[0] - panel.left_m[0], panel.right_m[1] - panel.left_m[1]))
    count = max(1, round(length / BAY_M))
    return [(0.0, 1.0, True)] + [(k / count, (k + 1) / count, False) for k in range(count)]


def _quad(panel: Panel, first: float, last: float) -> list[list[float]]:
    left, right = np.array(panel.left_m), np.array(panel.right_m)
    a, b = left + (right - left) * first, left + (right - left) * last
    return [[*a, panel.height_m], [*b, panel.height_m], [*b, 0.0], [*a, 0.0]]


def _distance(ends_m: Floats, eye_m: Floats) -> Floats:
    """From the eye to each stretch of wall, on the ground."""
    way = ends_m[:, 1] - ends_m[:, 0]
    along = ((eye_m - ends_m[:, 0]) * way).sum(axis=1) / np.maximum((way * way).sum(axis=1), 1e-9)
    nearest = ends_m[:, 0] + np.clip(along, 0, 1)[:, None] * way
    distance: Floats = np.linalg.norm(nearest - eye_m, axis=1)
    return distance


def _faces(view: View, corners_m: Floats) -> Flags:
    """Whether the camera stands on the outer side."""
    along = corners_m[:, 1, :2] - corners_m[:, 0, :2]
    away = view.position_m[:2] - corners_m[:, 0, :2]
    outside: Flags = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0] < 0
    return outside
