"""Flat rectangles in space and the pictures on them: reduced copies, which of them to read, where they lie on the canvas. Pure.

A rectangle is four corners of the camera frame: top left, top right, bottom right, bottom left, as seen from its front.
"""

import cv2
import numpy as np

from vehicle_gateway.video.render.projection import NEAR_M, Flags, Floats, Numbers, Picture, View, clip_near

HALVINGS_ACROSS, HALVINGS_UP = 6, 5
SMALLEST_PX = 3  # of a reduced copy
FLAT_M3 = 1e-12  # volume of the box between the camera and two edges of a rectangle it sees edge-on
Box = tuple[int, int, int, int]  # pixels: x0, y0, x1, y1, the last two outside
Copies = dict[tuple[int, int], Picture]


def reduce(texture: Picture) -> Copies:
    """Copies halved i times across and j <= i times up: a wall along a street is foreshortened across."""
    copies: Copies = {}
    column = texture
    for j in range(HALVINGS_UP + 1):
        copy = column
        for i in range(HALVINGS_ACROSS + 1):
            if i >= j:
                copies[i, j] = copy
            if copy.shape[1] < 2 * SMALLEST_PX:
                break
            copy = _resized(copy, copy.shape[1] // 2, copy.shape[0])
        if column.shape[0] < 2 * SMALLEST_PX:
            break
        column = _resized(column, column.shape[1], column.shape[0] // 2)
    return copies


def _resized(picture: Picture, width: int, height: int) -> Picture:
    return np.asarray(cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def levels(view: View, camera_m: Floats, texels: Floats, sizes: Numbers) -> tuple[Numbers, Numbers]:
    """Halvings across and up for rectangles (N, 4, 3), so that a texel is about a pixel in the middle of each.

    texels  (N, 2) columns and rows of the texture that lie on the rectangle
    sizes   (N, 2) columns and rows of the whole texture
    """
    middle = camera_m.mean(axis=1)
    depth = np.maximum(middle[:, 2], NEAR_M)
    side = (camera_m[:, 1] + camera_m[:, 2] - camera_m[:, 0] - camera_m[:, 3]) / 2
    shift = side[:, :2] - middle[:, :2] * (side[:, 2] / depth)[:, None]
    across_px = view.focal_px / depth * np.hypot(shift[:, 0], shift[:, 1])
    up_px = view.focal_px / depth * np.linalg.norm(camera_m[:, 0] - camera_m[:, 3], axis=1)
    i = _halvings(texels[:, 0] / np.maximum(across_px, 1e-3), sizes[:, 0], HALVINGS_ACROSS)
    j = _halvings(texels[:, 1] / np.maximum(up_px, 1e-3), sizes[:, 1], HALVINGS_UP)
    return i, np.minimum(i, j)


def _halvings(texels_per_px: Floats, size: Numbers, most: int) -> Numbers:
    wanted = np.log2(np.maximum(texels_per_px, 1.0)) + 0.4
    possible = np.floor(np.log2(size / SMALLEST_PX))
    whole: Numbers = np.clip(np.minimum(wanted, possible), 0, most).astype(np.int64)
    return whole


def in_picture(view: View, camera_m: Floats) -> Flags:
    """Whether a rectangle of (N, 4, 3) may be seen: not wholly behind, left, right, above or below."""
    x, y, z = camera_m[..., 0], camera_m[..., 1], camera_m[..., 2]
    wide, high = view.width_px / 2 / view.focal_px * z, view.height_px / 2 / view.focal_px * z
    outside = np.stack((z < NEAR_M, x > wide, x < -wide, y > high, y < -high)).all(axis=2)
    return np.logical_not(outside.any(axis=0))


def boxes(view: View, camera_m: Floats) -> tuple[Numbers, Floats]:
    """The part of the canvas each of (N, 4, 3) lies in, x0, y0, x1, y1 (empty when it misses it); the corners' pixels (N, 4, 2).

    Corners of a rectangle that reaches behind the near plane are NaN.
    """
    in_front = camera_m[:, :, 2].min(axis=1, initial=np.inf) >= NEAR_M
    pixels = view.to_pixels(np.where(in_front[:, None, None], camera_m, (0.0, 0.0, 1.0)))
    low, high = pixels.min(axis=1), pixels.max(axis=1)
    for k in np.flatnonzero(~in_front):
        clipped = view.to_pixels(clip_near(camera_m[k]))
        low[k], high[k] = clipped.min(axis=0), clipped.max(axis=0)
        pixels[k] = np.nan
    size = (view.width_px, view.height_px)
    corners = np.concatenate((np.clip(np.floor(low), 0, size), np.clip(np.ceil(high), 0, size)), axis=1)
    return corners.astype(np.int64), pixels


def from_pixels(view: View, camera_m: Floats) -> Floats:
    """(N, 3, 3): homogeneous pixels to 0..1 from a rectangle's top left corner to the right and down."""
    across, down, corner = camera_m[:, 1] - camera_m[:, 0], camera_m[:, 3] - camera_m[:, 0], camera_m[:, 0]
    # adjugate instead of inverse: a homography's scale does not matter
    back = np.stack((_cross(down, corner), _cross(corner, across), _cross(across, down)), axis=1)
    flat = np.abs((back[:, 0] * across).sum(axis=1)) < FLAT_M3  # seen exactly edge-on: shows nothing
    back[:, :, 2] -= (back[:, :, 0] * view.centre_px[0] + back[:, :, 1] * view.centre_px[1]) / view.focal_px
    back[:, :, :2] /= view.focal_px
    back[flat] = np.array([[0, 0, -9.0], [0, 0, -9.0], [0, 0, 1.0]])
    return back


def _cross(a: Floats, b: Floats) -> Floats:
    """Of two (N, 3): a quarter of the time np.cross takes on a few rows."""
    (a0, a1, a2), (b0, b1, b2) = a.T, b.T
    return np.stack((a1 * b2 - a2 * b1, a2 * b0 - a0 * b2, a0 * b1 - a1 * b0), axis=1)


def to_texture(back: Floats, first: Floats, size: Floats, low_px: Numbers) -> Floats:
    """OpenCV's matrices (N, 3, 3) from parts of the canvas to textures, both with the middle of the first pixel at 0.

    back     what `from_pixels` gave
    first    (N, 2) column and row of the texture at the rectangle's upper left corner
    size     (N, 2) columns and rows from there to its lower right corner
    low_px   (N, 2) the canvas parts' upper left corners
    """
    scaled = np.empty_like(back)
    scaled[:, :2] = back[:, :2] * size[:, :, None] + back[:, 2:] * first[:, :, None]
    scaled[:, 2] = back[:, 2]
    scaled[:, :, 2] += scaled[:, :, 0] * (low_px[:, :1] + 0.5) + scaled[:, :, 1] * (low_px[:, 1:] + 0.5)
    return scaled
