"""Painter's order: which block hides which small thing. Pure.

Blocks (convex footprints) go from far to near by their nearest corner; they stand side by side along the street, where that
is exact. A small thing is drawn before the first block that may hide it: a block may not hide a point when some side of it
has both the point and the camera on its outer side, because then the way between them stays outside.
"""

from dataclasses import dataclass

import numpy as np

from vehicle_gateway.video.render.projection import Floats


def far_to_near(footprints_m: Floats, numbers: list[int], eye_m: Floats) -> list[int]:
    """Blocks `numbers` sorted by the distance of the nearest point of their outline, farthest first."""
    if not numbers:
        return []
    corners = footprints_m[numbers]
    ways = np.roll(corners, -1, axis=1) - corners
    along = ((eye_m - corners) * ways).sum(axis=2) / np.maximum((ways * ways).sum(axis=2), 1e-9)
    nearest = corners + np.clip(along, 0, 1)[..., None] * ways
    distance = np.linalg.norm(nearest - eye_m, axis=2).min(axis=1)
    return [numbers[i] for i in np.argsort(-distance, kind="stable")]


def hidden_by(footprints_m: Floats, points_m: Floats, eye_m: Floats) -> Floats:
    """(points, blocks) whether the block may hide the point from the eye; footprints are counter-clockwise."""
    ways = np.roll(footprints_m, -1, axis=1) - footprints_m
    normals = np.stack((ways[..., 1], -ways[..., 0]), axis=-1)  # outward
    reach = (normals * footprints_m).sum(axis=2)
    block, side = np.nonzero(normals @ eye_m >= reach)  # only sides that look at the eye can part it from the point
    parted = points_m @ normals[block, side].T >= reach[block, side]
    hidden = np.ones((len(points_m), len(footprints_m)), dtype=bool)
    if len(block):
        first = np.flatnonzero(np.diff(block, prepend=-1))  # np.nonzero lists the sides of a block one after the other
        hidden[:, block[first]] = ~np.logical_or.reduceat(parted, first, axis=1)
    return hidden


def slots(blocks_far_to_near: list[int], footprints_m: Floats, points_m: Floats, eye_m: Floats) -> Floats:
    """For every point the place in the list of blocks before which it is drawn; the list's length: after all of them."""
    count = len(blocks_far_to_near)
    if not count or not len(points_m):
        return np.full(len(points_m), count)
    hidden = hidden_by(footprints_m[blocks_far_to_near], points_m, eye_m)
    places: Floats = np.where(hidden.any(axis=1), hidden.argmax(axis=1), count)
    return places


CELL_PX = 16  # columns of the picture that are judged together
EDGE_PX = 2  # along its outline a wall may be drawn so much smaller
Wall = tuple[float, float, float, float, float, float]  # left u, v of its top and of its foot; right u, v of top and foot


@dataclass(frozen=True, slots=True)
class Cover:
    """What walls leave to be seen, per CELL_PX columns of the picture."""

    sky_to: list[int]  # from this row down there is no sky
    ground_gap: list[tuple[int, int]]  # no ground in the rows [first, last)


def seen(
    boxes: list[tuple[int, int, int, int] | None], walls_px: list[Wall | None], width_px: int, height_px: int
) -> tuple[list[bool], Cover]:
    """Which of the things, listed far to near, are not wholly covered by upright walls in front of them; and what else is.

    boxes     rectangle x0, y0, x1, y1 each lies in; None: always seen
    walls_px  what a wall covers wholly: all between top and foot. What stands behind it has its own foot above the wall's,
              so that of a farther thing all below the wall's top is covered. None or NaN: covers nothing
    """
    cells = -(-width_px // CELL_PX)
    sky_to, gap = [height_px] * cells, [(0, 0)] * cells
    result = [True] * len(boxes)
    for k in range(len(boxes) - 1, -1, -1):
        box = boxes[k]
        if box is not None:
            x0, y0, x1, _ = box
            result[k] = max(sky_to[x0 // CELL_PX : -(-x1 // CELL_PX)], default=0) > y0
        wall = walls_px[k]
        if result[k] and wall is not None and wall[0] == wall[0]:
            _cover(sky_to, gap, wall)
    return result, Cover(sky_to, gap)


def _cover(sky_to: list[int], gap: list[tuple[int, int]], wall_px: Wall) -> None:
    u0, top, foot, u1, top_end, foot_end = wall_px
    first = max(0, int((u0 + EDGE_PX) // CELL_PX) + 1)  # only cells that lie wholly inside
    last = min(len(sky_to), int((u1 - EDGE_PX) // CELL_PX))
    if first >= last:
        return
    rise, fall = ((end - start) / (u1 - u0) * CELL_PX for start, end in ((top, top_end), (foot, foot_end)))
    top, foot = (v + step * (first * CELL_PX - u0) / CELL_PX for v, step in ((top, rise), (foot, fall)))
    top, foot = top + max(rise, 0.0) + EDGE_PX, foot + min(fall, 0.0) - EDGE_PX
    for cell in range(first, last):
        high, low = int(top), int(foot)
        if high < sky_to[cell]:
            sky_to[cell] = high
        before = gap[cell]
        if before[1] == 0 or (high <= before[1] and low >= before[0]):  # none yet, or it overlaps: one gap
            gap[cell] = (min(high, before[0]), max(low, before[1])) if before[1] else (high, max(low, high))
        top, foot = top + rise, foot + fall
