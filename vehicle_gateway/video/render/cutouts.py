"""Flat things with an outline of their own: barriers with their boards, lamps and arrow, and the road-works sign.

Painted once as pictures with transparency, drawn upright in true perspective. Barriers and signs after the German
TL-Absperrschranken and the signs 222 (pass here) and 123 (road works), in outline only.
"""

from dataclasses import dataclass
from math import cos, sin, tau

import cv2
import numpy as np

from vehicle_gateway.simulation.site import StaticObject
from vehicle_gateway.video.render.brush import Colour, fixed, lay, shaded
from vehicle_gateway.video.render.perspective import Copies, boxes, from_pixels, in_picture, levels, reduce, to_texture
from vehicle_gateway.video.render.projection import Floats, Picture, View

TEXEL_M = 0.006
RED: Colour = (36.0, 32.0, 196.0)
WHITE: Colour = (236.0, 238.0, 238.0)
STEEL: Colour = (142.0, 138.0, 132.0)
DARK: Colour = (34.0, 32.0, 30.0)
YELLOW: Colour = (30.0, 196.0, 250.0)
BLUE: Colour = (168.0, 84.0, 22.0)
ABOVE_BARRIER_M = 0.85  # room for lamps and arrow
SIGN_HEIGHT_M = 2.35
BLINK_NS = 700_000_000  # half a period of a warning lamp


class Paper:
    """A transparent picture in metres: x to the right from the middle, y up from the ground."""

    def __init__(self, width_m: float, height_m: float) -> None:
        self.picture: Picture = np.zeros((round(height_m / TEXEL_M), round(width_m / TEXEL_M), 4), np.uint8)

    def polygon(self, points_m: list[tuple[float, float]], colour: Colour) -> None:
        rows, columns = self.picture.shape[:2]
        pixels = np.array(points_m) * (1 / TEXEL_M, -1 / TEXEL_M) + (columns / 2, rows)
        cv2.fillPoly(self.picture, [fixed(pixels)], (*colour, 255.0), cv2.LINE_AA, 4)

    def box(self, left_m: float, right_m: float, low_m: float, high_m: float, colour: Colour) -> None:
        self.polygon([(left_m, low_m), (right_m, low_m), (right_m, high_m), (left_m, high_m)], colour)

    def disc(self, x_m: float, y_m: float, radius_m: float, colour: Colour) -> None:
        turn = np.arange(40) * (tau / 40)
        self.polygon([(x_m + radius_m * cos(a), y_m + radius_m * sin(a)) for a in turn], colour)


def barrier(length_m: float, height_m: float, arrow: int, lit: bool) -> Picture:
    """Two striped boards on feet with warning lamps; arrow: -1 pass on its left, 1 on its right, 0 seen from behind."""
    paper = Paper(length_m + 0.2, height_m + ABOVE_BARRIER_M)
    half = length_m / 2
    for at in (-half + 0.3, 0.0, half - 0.3):
        paper.box(at - 0.2, at + 0.2, 0.0, 0.12, (52.0, 50.0, 48.0))
        paper.box(at - 0.2, at + 0.2, 0.09, 0.12, (96.0, 94.0, 92.0))
        paper.box(at - 0.03, at + 0.03, 0.12, height_m, shaded(STEEL, 0.8))
    for low in (height_m - 0.64, height_m - 0.25):
        _striped(paper, half, low, low + 0.25)
    for i, at in enumerate((-half + 0.3, 0.0, half - 0.3)):
        _lamp(paper, at, height_m, lit == (i % 2 == 0))
    if arrow:
        _pass_here(paper, height_m + 0.46, float(arrow))
    return paper.picture


def _striped(paper: Paper, half_m: float, low_m: float, high_m: float) -> None:
    """White, with slanted red stripes of 0.25 m and a dark lower edge."""
    paper.box(-half_m, half_m, low_m, high_m, WHITE)
    for left in np.arange(-half_m + 0.06, half_m - 0.26, 0.5):
        a, b = float(left), float(left) + 0.25
        paper.polygon([(a, low_m), (b, low_m), (min(b + 0.13, half_m), high_m), (min(a + 0.13, half_m), high_m)], RED)
    paper.box(-half_m, half_m, low_m, low_m + 0.02, (110.0, 108.0, 120.0))


def _lamp(paper: Paper, x_m: float, low_m: float, lit: bool) -> None:
    paper.box(x_m - 0.07, x_m + 0.07, low_m, low_m + 0.10, (50.0, 60.0, 66.0))
    paper.disc(x_m, low_m + 0.20, 0.12, (30.0, 70.0, 90.0))
    paper.disc(x_m, low_m + 0.20, 0.10, YELLOW if lit else (26.0, 130.0, 180.0))
    paper.disc(x_m, low_m + 0.20, 0.055, (190.0, 248.0, 255.0) if lit else (46.0, 160.0, 206.0))


def _pass_here(paper: Paper, y_m: float, side: float) -> None:
    """Sign 222: a white arrow down to the side on a blue disc."""
    paper.box(-0.03, 0.03, y_m - 0.5, y_m, STEEL)
    paper.disc(0.0, y_m, 0.34, WHITE)
    paper.disc(0.0, y_m, 0.315, BLUE)
    shaft = [(-0.17, 0.11), (-0.11, 0.17), (0.11, -0.05), (0.05, -0.11)]
    head = [(0.20, -0.20), (0.20, 0.07), (-0.07, -0.20)]
    for shape in (shaft, head):
        paper.polygon([(side * x, y_m + y) for x, y in shape], WHITE)


_DIGGER = (
    [(-0.03, 1.72), (0.05, 1.72), (0.07, 1.90), (0.0, 1.91)],
    [(-0.02, 1.74), (0.05, 1.74), (0.11, 1.59), (0.06, 1.59)],
    [(-0.02, 1.74), (0.03, 1.74), (-0.01, 1.59), (-0.06, 1.59)],
    [(0.05, 1.89), (0.03, 1.83), (-0.16, 1.63), (-0.19, 1.66)],
    [(-0.10, 1.59), (-0.26, 1.59), (-0.19, 1.67)],
)


def works_sign(is_front: bool) -> Picture:
    """Sign 123 on a post: a red-bordered triangle with a person digging; its grey back without."""
    paper = Paper(1.1, SIGN_HEIGHT_M)
    paper.box(-0.03, 0.03, 0.0, 2.2, STEEL)
    if not is_front:
        paper.polygon([(-0.47, 1.48), (0.47, 1.48), (0.0, 2.30)], shaded(STEEL, 0.9))
        return paper.picture
    paper.polygon([(-0.50, 1.46), (0.50, 1.46), (0.0, 2.33)], WHITE)
    paper.polygon([(-0.47, 1.48), (0.47, 1.48), (0.0, 2.30)], RED)
    paper.polygon([(-0.33, 1.56), (0.33, 1.56), (0.0, 2.13)], WHITE)
    paper.disc(0.02, 1.95, 0.045, DARK)
    for limb in _DIGGER:
        paper.polygon(limb, DARK)
    return paper.picture


@dataclass(frozen=True, slots=True)
class Cutout:
    """An upright picture: its foot's middle in the map frame; whoever looks along `heading_rad` sees the front."""

    x_m: float
    y_m: float
    heading_rad: float
    width_m: float
    height_m: float
    front: tuple[Copies, ...]  # one, or two between which it blinks
    back: tuple[Copies, ...]

    def draw(self, canvas: Picture, view: View, stamp_ns: int) -> None:
        eye = view.position_m[:2] - (self.x_m, self.y_m)
        from_behind = eye[0] * cos(self.heading_rad) + eye[1] * sin(self.heading_rad) > 0
        quad = view.to_camera(self._corners(from_behind))[None]
        if not in_picture(view, quad)[0]:
            return
        sides = self.back if from_behind else self.front
        copies = sides[stamp_ns // BLINK_NS % len(sides)]
        size = np.array([copies[0, 0].shape[1::-1]])
        i, j = levels(view, quad, size, size)
        copy = copies[int(i[0]), int(j[0])]
        box = boxes(view, quad)[0]
        x0, y0, x1, y1 = box[0].tolist()
        if x0 < x1 and y0 < y1:
            extent = np.array([copy.shape[1::-1]], dtype=np.float64)
            matrix = to_texture(from_pixels(view, quad), np.full((1, 2), -0.5), extent, box[:, :2])[0]
            drawn = cv2.warpPerspective(copy, matrix, (x1 - x0, y1 - y0), flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)
            lay(canvas[y0:y1, x0:x1], np.asarray(drawn, dtype=np.uint8))

    def _corners(self, from_behind: bool) -> Floats:
        half = self.width_m / 2 * (-1 if from_behind else 1)
        x, y = half * sin(self.heading_rad), -half * cos(self.heading_rad)  # to the right of the heading
        left, right = (self.x_m - x, self.y_m - y), (self.x_m + x, self.y_m + y)
        return np.array([[*left, self.height_m], [*right, self.height_m], [*right, 0.0], [*left, 0.0]])


def barrier_cutout(thing: StaticObject, pass_on_left: bool) -> Cutout:
    arrow = -1 if pass_on_left else 1
    front, back = (tuple(reduce(barrier(thing.length_m, thing.height_m, way, lit)) for lit in (True, False)) for way in (arrow, 0))
    return Cutout(thing.x_m, thing.y_m, thing.heading_rad, thing.length_m + 0.2, thing.height_m + ABOVE_BARRIER_M, front, back)


def sign_cutout(x_m: float, y_m: float, heading_rad: float) -> Cutout:
    return Cutout(x_m, y_m, heading_rad, 1.1, SIGN_HEIGHT_M, (reduce(works_sign(True)),), (reduce(works_sign(False)),))
