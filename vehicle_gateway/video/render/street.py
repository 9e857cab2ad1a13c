"""Traffic cones and street lamps: a few flat polygons each, transformed all together, drawn one by one.

Cones after DIN EN 13422: orange, two white reflective bands, on a plate. Shadows are on the ground already (render.shadows).
"""

from math import cos, sin

import cv2
import numpy as np

from vehicle_gateway.simulation.site import StaticObject, object_corners
from vehicle_gateway.video.render.brush import SHIFT, Colour, fixed, shaded
from vehicle_gateway.video.render.cutouts import STEEL
from vehicle_gateway.video.render.projection import NEAR_M, Corners, Floats, Numbers, Picture, View
from vehicle_gateway.video.render.scenery import LAMP_HEIGHT_M, Lamp

ORANGE: Colour = (20.0, 92.0, 245.0)
BAND: Colour = (236.0, 240.0, 240.0)
PLATE: Colour = (30.0, 62.0, 176.0)
# slices of a cone from below: height as share of the whole, colour of what is between it and the next
_SLICES = ((0.05, ORANGE), (0.34, BAND), (0.52, ORANGE), (0.62, BAND), (0.78, ORANGE), (1.0, ORANGE))
_FOOT_SHARE, _TIP_SHARE = 0.75, 0.10  # radius of the body at foot and tip, of half the plate
_PLATE_SHARE = 0.04  # height of the plate, of the whole
_ARC = np.linspace(0.0, np.pi, 9)  # the front half of a slice, from left to right
_STRIPS = ((0, 2, 1.0), (2, 4, 1.10), (4, 6, 0.94), (6, 8, 0.74))  # first and last point on the arc, light
DETAIL_PX = 9.0  # a cone narrower than this is drawn in one colour across


def _strips(strips: tuple[tuple[int, int, float], ...]) -> tuple[Numbers, list[Colour]]:
    """Of every polygon of a cone's body its corners, as numbers of points counted slice by slice, and its colour."""
    points, colours = [], []
    for k, (_, colour) in enumerate(_SLICES[:-1]):
        low, high = k * len(_ARC), (k + 1) * len(_ARC)
        for a, b, light in strips:
            points.append([*range(low + a, low + b + 1), *range(high + b, high + a - 1, -1)])
            colours.append(shaded(colour, light))
    return np.array(points), colours


_DETAILED, _PLAIN = _strips(_STRIPS), _strips(((0, 8, 1.0),))


def _fill(canvas: Picture, corners: Corners, colour: Colour) -> None:
    cv2.fillConvexPoly(canvas, corners, colour, cv2.LINE_AA, SHIFT)


class Cones:
    def __init__(self, cones: list[StaticObject]) -> None:
        self.feet_m = np.array([(cone.x_m, cone.y_m, 0.0) for cone in cones]).reshape(-1, 3)
        share = np.array([height for height, _ in _SLICES])
        size = np.array([(cone.length_m, cone.height_m) for cone in cones]).reshape(-1, 2)
        self._radii = size[:, :1] / 2 * (_FOOT_SHARE + (_TIP_SHARE - _FOOT_SHARE) * share)
        self._heights = size[:, 1:] * share
        flat = np.array([object_corners(cone) for cone in cones]).reshape(-1, 4, 2)
        lift = np.broadcast_to((size[:, 1] * _PLATE_SHARE)[:, None, None], (len(cones), 4, 1))
        self._plates = np.stack((np.concatenate((flat, 0 * lift), axis=2), np.concatenate((flat, lift), axis=2)), axis=1)
        self._rings_px: Corners = np.zeros((0, 0, 0, 2), np.int32)
        self._plates_px: Corners = np.zeros((0, 0, 0, 2), np.int32)

    def look(self, view: View, numbers: Numbers) -> None:
        """Transform those named. Call before `draw`."""
        if not len(numbers):
            return
        feet = self.feet_m[numbers]
        towards = (view.position_m - feet) * (1.0, 1.0, 0.0)
        towards /= np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-6)
        right = np.stack((-towards[:, 1], towards[:, 0], towards[:, 2]), axis=1)
        arc = -np.cos(_ARC)[:, None] * right[:, None] + np.sin(_ARC)[:, None] * towards[:, None]  # (N, arc, 3)
        rings = feet[:, None, None] + self._radii[numbers][:, :, None, None] * arc[:, None]
        rings[..., 2] += self._heights[numbers][:, :, None]
        self._rings_px = np.zeros((len(self.feet_m), *rings.shape[1:3], 2), np.int32)
        self._plates_px = np.zeros((len(self.feet_m), 2, 4, 2), np.int32)
        self._rings_px[numbers] = _pixels(view, rings)
        self._plates_px[numbers] = _pixels(view, self._plates[numbers])

    def draw(self, canvas: Picture, number: int) -> None:
        rings, plates = self._rings_px[number], self._plates_px[number]
        _fill(canvas, plates[0], shaded(PLATE, 0.65))
        _fill(canvas, plates[1], PLATE)
        width = abs(int(rings[0, -1, 0]) - int(rings[0, 0, 0])) >> SHIFT
        points, strips = _DETAILED if width > DETAIL_PX else _PLAIN
        for corners, colour in zip(rings.reshape(-1, 2)[points], strips, strict=True):
            _fill(canvas, corners, colour)


def _pixels(view: View, points_m: Floats) -> Corners:
    """(..., 3) map frame to OpenCV's corners; a point behind the near plane is drawn onto it."""
    camera = view.to_camera(points_m)
    camera[..., 2] = np.maximum(camera[..., 2], NEAR_M)
    return fixed(view.to_pixels(camera))


ARM_M, ARM_RISE_M = 1.5, 0.25


def _post(top_m: float, foot_half_m: float, top_half_m: float) -> list[tuple[float, float, float]]:
    return [(0.0, 0.0, -foot_half_m), (0.0, 0.0, foot_half_m), (0.0, top_m, top_half_m), (0.0, top_m, -top_half_m)]


_END_M = LAMP_HEIGHT_M + ARM_RISE_M
# corners of the shapes of a lamp: along its arm, up from its foot, to the right in the picture
_SHAPES_M = np.array(
    [
        _post(LAMP_HEIGHT_M, 0.075, 0.045),
        _post(LAMP_HEIGHT_M, 0.030, 0.018),
        _post(0.7, 0.11, 0.10),
        [
            (0.0, LAMP_HEIGHT_M - 0.035, 0.0),
            (0.0, LAMP_HEIGHT_M + 0.035, 0.0),
            (ARM_M, _END_M + 0.03, 0.0),
            (ARM_M, _END_M - 0.03, 0.0),
        ],
        [
            (ARM_M - 0.1, _END_M + 0.05, 0.0),
            (ARM_M + 0.6, _END_M + 0.09, 0.0),
            (ARM_M + 0.6, _END_M - 0.01, 0.0),
            (ARM_M - 0.1, _END_M - 0.05, 0.0),
        ],
    ]
)
_ALONG_M, _UP_M, _RIGHT_M = (_SHAPES_M[..., k, None] for k in range(3))


class Lamps:
    """Each: post, its lit side, base, arm, head."""

    def __init__(self, lamps: tuple[Lamp, ...]) -> None:
        self.feet_m = np.array([(lamp.x_m, lamp.y_m, 0.0) for lamp in lamps]).reshape(-1, 3)
        arms = np.array([(cos(lamp.towards_road_rad), sin(lamp.towards_road_rad), 0.0) for lamp in lamps]).reshape(-1, 3)
        self._middles_m = self.feet_m[:, None, None] + arms[:, None, None] * _ALONG_M + np.array([0.0, 0.0, 1.0]) * _UP_M
        self._px: Corners = np.zeros((0, 5, 4, 2), np.int32)

    def look(self, view: View, numbers: Numbers) -> None:
        """Transform those named. Call before `draw`."""
        if not len(numbers):
            return
        right = view.axes[0] * (1.0, 1.0, 0.0)
        self._px = np.zeros((len(self.feet_m), 5, 4, 2), np.int32)
        self._px[numbers] = _pixels(view, self._middles_m[numbers] + right * _RIGHT_M)

    def draw(self, canvas: Picture, number: int) -> None:
        for shape, light in zip(self._px[number], (0.62, 0.95, 0.52, 0.6, 0.8), strict=True):
            _fill(canvas, shape, shaded(STEEL, light))
