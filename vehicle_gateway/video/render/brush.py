"""Strokes on the canvas: polygons of the camera frame, pictures with transparency, textured flat panels. In place, clipped.

The canvas is (H, W, 4) BGRA; its fourth channel means nothing. OpenCV's middle of the first pixel is (0, 0): pixel
coordinates of render.projection are half a pixel larger.
"""

from functools import lru_cache
from math import log2

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import NEAR_M, Corners, Floats, Picture, View, clip_near

SHIFT = 4  # sub-pixel bits of OpenCV's polygon corners
_FARTHEST = 100000.0 * (1 << SHIFT)  # keeps shifted coordinates inside 32 bits
Colour = tuple[float, float, float]


@lru_cache(4096)  # a hundred times a picture, for a few dozen pairs
def shaded(colour: Colour, light: float) -> Colour:
    blue, green, red = (min(255.0, channel * light) for channel in colour)
    return blue, green, red


def fixed(pixels: Floats) -> Corners:
    """Pixel coordinates as OpenCV's fixed-point corners."""
    scaled = (pixels - 0.5) * (1 << SHIFT)
    np.minimum(scaled, _FARTHEST, out=scaled)  # a third of the time np.clip takes on a few corners
    np.maximum(scaled, -_FARTHEST, out=scaled)
    corners: Corners = np.rint(scaled).astype(np.int32, order="C")  # OpenCV wants a corner's two numbers side by side
    return corners


def fill(canvas: Picture, pixels: Floats, colour: Colour) -> None:
    """A convex polygon (N, 2), edges smooth."""
    cv2.fillConvexPoly(canvas, fixed(pixels), colour, cv2.LINE_AA, SHIFT)


def fill_in_space(canvas: Picture, view: View, camera_m: Floats, colour: Colour) -> None:
    """A convex polygon (N, 3) of the camera frame; what lies behind the near plane is cut off."""
    visible = clip_near(camera_m)
    if len(visible) >= 3:
        fill(canvas, view.to_pixels(visible), colour)


def line_in_space(canvas: Picture, view: View, camera_m: Floats, colour: Colour, width_px: int = 1) -> None:
    """A straight line between two points (2, 3) of the camera frame."""
    a, b = camera_m
    if max(a[2], b[2]) <= NEAR_M:
        return
    if a[2] < NEAR_M:
        a = a + (b - a) * ((NEAR_M - a[2]) / (b[2] - a[2]))
    if b[2] < NEAR_M:
        b = b + (a - b) * ((NEAR_M - b[2]) / (a[2] - b[2]))
    cv2.polylines(canvas, [fixed(view.to_pixels(np.stack((a, b))))], False, colour, width_px, cv2.LINE_AA, SHIFT)


def inside(canvas: Picture, low: Floats, high: Floats) -> tuple[int, int, int, int] | None:
    """Pixel rectangle x0, y0, x1, y1 between two corners, cut to the canvas; None when nothing is left."""
    height, width = canvas.shape[:2]
    x0, y0 = max(0, int(np.floor(low[0]))), max(0, int(np.floor(low[1])))
    x1, y1 = min(width, int(np.ceil(min(high[0], width)))), min(height, int(np.ceil(min(high[1], height))))
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None


def lay(target: Picture, source: Picture) -> None:
    """Premultiplied BGRA over the canvas, in place, same size."""
    rest = cv2.bitwise_not(cv2.extractChannel(source, 3))
    cv2.multiply(target, cv2.cvtColor(rest, cv2.COLOR_GRAY2BGRA), dst=target, scale=1 / 255)
    cv2.add(target, source, dst=target)


def darken(canvas: Picture, pixels: Floats, share: float) -> None:
    """Take `share` of the light away inside a convex polygon (N, 2): a soft shadow's cheap stand-in."""
    box = inside(canvas, pixels.min(axis=0) - 1, pixels.max(axis=0) + 1)
    if box is None:
        return
    x0, y0, x1, y1 = box
    keep = np.full((y1 - y0, x1 - x0), 255, np.uint8)
    cv2.fillConvexPoly(keep, fixed(pixels - (x0, y0)), (255 * (1 - share),), cv2.LINE_AA, SHIFT)
    part = canvas[y0:y1, x0:x1]
    cv2.multiply(part, cv2.cvtColor(keep, cv2.COLOR_GRAY2BGRA), dst=part, scale=1 / 255)


def halvings(picture: Picture, most: int) -> list[Picture]:
    """The picture and its copies at a half, a quarter, ... of its size, down to 4 pixels."""
    copies = [picture]
    while len(copies) <= most and min(copies[-1].shape[:2]) >= 8:
        last = copies[-1]
        size = (last.shape[1] // 2, last.shape[0] // 2)
        copies.append(np.asarray(cv2.resize(last, size, interpolation=cv2.INTER_AREA), dtype=np.uint8))
    return copies


def stamp(canvas: Picture, copies: list[Picture], rectangle_px: tuple[float, float, float, float]) -> None:
    """A premultiplied picture with its halved copies, stretched over a rectangle (left, top, right, bottom)."""
    u0, v0, u1, v1 = rectangle_px
    height, width = canvas.shape[:2]
    x0, y0, x1, y1 = max(0, int(u0)), max(0, int(v0)), min(width, int(u1) + 1), min(height, int(v1) + 1)
    if x0 >= x1 or y0 >= y1 or v1 - v0 < 1.0:
        return
    texels_per_px = copies[0].shape[0] / (v1 - v0)
    picture = copies[min(len(copies) - 1, max(0, int(log2(texels_per_px) + 0.4)))]
    sx, sy = picture.shape[1] / (u1 - u0), picture.shape[0] / (v1 - v0)
    back = np.array([[sx, 0, (x0 + 0.5 - u0) * sx - 0.5], [0, sy, (y0 + 0.5 - v0) * sy - 0.5]])
    drawn = cv2.warpAffine(picture, back, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
    lay(canvas[y0:y1, x0:x1], np.asarray(drawn, dtype=np.uint8))
