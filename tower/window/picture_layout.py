"""Where the cameras' pictures stand: left, front and right side by side over the whole width, one continuous view. Pure.

The front picture keeps its shape and stands in the middle. The sides join its edges and are as high as it is; where there is
no room for the whole of a side picture its outer part is cut off, so that the three still meet at the seams. The rear picture
is a mirror over the front one, above the horizon. Cameras of other names are recorded but have no place in the window.
"""

from collections.abc import Mapping
from typing import NamedTuple

from wire.rear_view import REAR

FRONT, LEFT, RIGHT = "front", "left", "right"
SHOWN = (FRONT, LEFT, RIGHT, REAR)
Shape = tuple[int, int]  # width and height, pixels
ASSUMED: dict[str, Shape] = {FRONT: (1280, 720)}  # until the car has described its cameras
FRONT_SHARE = 0.625  # ours: of the width, where the sides could have more; 80 of 126 degrees with the simulated cameras
_ABOVE_SHARE = 0.44  # ours: of the height that the pictures leave: banner and warnings need a little less than the figures below
_MIRROR_SHARE, _MIRROR_END_SHARE = 0.42, 0.435  # of the front picture: the mirror's width; its foot, just above the horizon
_MIRROR_TOP = 102.0  # design units: below the banner and its line of words


class Box(NamedTuple):
    """Pixels: left, top, width, height."""

    x: int
    y: int
    w: int
    h: int

    def overlaps(self, other: "Box") -> bool:
        return self.x < other.x + other.w and other.x < self.x + self.w and self.y < other.y + other.h and other.y < self.y + self.h


def places(width_px: int, height_px: int, shapes: Mapping[str, Shape], scale: float) -> dict[str, Box]:
    """Where the picture of each camera goes, by name; `shapes` must hold the front camera's.

    scale  pixels per design unit
    """
    front = _front(width_px, height_px, shapes)
    boxes = {FRONT: front}
    room = (width_px - front.w) // 2
    for name in (LEFT, RIGHT):
        if name in shapes and room > 0:
            wide = min(room, round(front.h * _aspect(shapes[name])))
            boxes[name] = Box(front.x - wide if name == LEFT else front.x + front.w, front.y, wide, front.h)
    if REAR in shapes:
        boxes[REAR] = _mirror(front, shapes[REAR], scale)
    return boxes


def _front(width_px: int, height_px: int, shapes: Mapping[str, Shape]) -> Box:
    aspect = _aspect(shapes[FRONT])
    sides = 2 * max((_aspect(shapes[name]) for name in (LEFT, RIGHT) if name in shapes), default=0.0)
    all_fit = width_px / (1 + sides / aspect)
    wide = min(height_px * aspect, max(all_fit, width_px * FRONT_SHARE))
    w, h = max(1, round(wide)), max(1, round(wide / aspect))
    return Box((width_px - w) // 2, round((height_px - h) * _ABOVE_SHARE), w, h)


def _mirror(front: Box, shape: Shape, scale: float) -> Box:
    top = max(front.y, round(_MIRROR_TOP * scale))
    high = max(1.0, min(front.w * _MIRROR_SHARE / _aspect(shape), front.y + front.h * _MIRROR_END_SHARE - top))
    w, h = max(1, round(high * _aspect(shape))), round(high)
    return Box(front.x + (front.w - w) // 2, top, w, h)


def part(camera: str, shape: Shape, box: Box) -> Box:
    """The part of a picture that its box shows: all of its height; of a side picture what lies next to the seam."""
    wide = min(shape[0], max(1, round(shape[1] * box.w / box.h)))
    left = {LEFT: shape[0] - wide, RIGHT: 0}.get(camera, (shape[0] - wide) // 2)
    return Box(left, 0, wide, shape[1])


def bare(width_px: int, height_px: int, boxes: Mapping[str, Box]) -> tuple[Box, ...]:
    """What of the window no picture covers: above, below, left and right of them."""
    row = [box for name, box in boxes.items() if name != REAR]
    left, right = min(box.x for box in row), max(box.x + box.w for box in row)
    top, bottom = row[0].y, row[0].y + row[0].h
    strips = (
        Box(0, 0, width_px, top),
        Box(0, bottom, width_px, height_px - bottom),
        Box(0, top, left, bottom - top),
        Box(right, top, width_px - right, bottom - top),
    )
    return tuple(strip for strip in strips if strip.w > 0 and strip.h > 0)


def _aspect(shape: Shape) -> float:
    return shape[0] / shape[1]
