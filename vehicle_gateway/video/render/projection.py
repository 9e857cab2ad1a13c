"""The pinhole camera: points of the map frame to pixels, and what is clipped before it is drawn. Pure.

Frames: the map and the car's body are ISO 8855 (x forward, y left, z up); the camera's is x right, y down, z forward.
A body turns by heading about z, then pitch about y (positive: nose down), then roll about x (positive: leans right), about
the rear axle on the ground. A pixel (u, v) in the picture is measured from the outer corner of the first pixel, so the
principal point lies at (width / 2, height / 2) and the pixel in column 0 has its middle at u = 0.5.
No lens distortion: CameraCalibration has none.
"""

from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from wire.messages.sensing import Pose
from wire.messages.vehicle import CameraCalibration

Floats = NDArray[np.floating[Any]]
Picture = NDArray[np.uint8]
Flags = NDArray[np.bool_]
Numbers = NDArray[np.int64]
Corners = NDArray[np.int32]  # fixed-point pixels of OpenCV's polygons

NEAR_M = 0.15  # nothing closer to the camera's plane is drawn: keeps pixel coordinates finite


def rotation(heading_rad: float, pitch_rad: float, roll_rad: float) -> Floats:
    """(3, 3) matrix from the turned frame to the frame it is turned in: Rz(heading) Ry(pitch) Rx(roll)."""
    ch, sh, cp, sp = cos(heading_rad), sin(heading_rad), cos(pitch_rad), sin(pitch_rad)
    cr, sr = cos(roll_rad), sin(roll_rad)
    return np.array(
        [
            [ch * cp, ch * sp * sr - sh * cr, ch * sp * cr + sh * sr],
            [sh * cp, sh * sp * sr + ch * cr, sh * sp * cr - ch * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


_OPTICAL = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # rows: right, down, forward of a body frame


@dataclass(frozen=True, slots=True)
class View:
    """A camera at one moment."""

    focal_px: float
    width_px: int
    height_px: int
    position_m: Floats  # (3,) map frame
    axes: Floats  # (3, 3) rows: right, down, forward, as unit vectors of the map frame

    @property
    def centre_px(self) -> tuple[float, float]:
        return self.width_px / 2, self.height_px / 2

    @property
    def horizon_px(self) -> float:
        """Row of the horizon in the middle column; may lie outside the picture."""
        return self.height_px / 2 + self.focal_px * float(self.axes[2, 2]) / max(1e-6, -float(self.axes[1, 2]))

    def to_camera(self, points_m: ArrayLike) -> Floats:
        """(..., 3) map frame -> (..., 3) camera frame."""
        moved: Floats = (np.asarray(points_m, dtype=np.float64) - self.position_m) @ self.axes.T
        return moved

    def to_pixels(self, camera_m: Floats) -> Floats:
        """(..., 3) camera frame with positive depth -> (..., 2) pixels."""
        pixels: Floats = camera_m[..., :2] * (self.focal_px / camera_m[..., 2:]) + self.centre_px
        return pixels


def view_of(calibration: CameraCalibration, pose: Pose, pitch_rad: float = 0.0, roll_rad: float = 0.0) -> View:
    """The camera of a car whose rear axle stands at `pose` (map frame) and whose body is pitched and rolled."""
    body = rotation(pose.heading_rad, pitch_rad, roll_rad)
    mounted = body @ rotation(calibration.yaw_rad, calibration.pitch_rad, 0.0)
    position = body @ (calibration.x_m, calibration.y_m, calibration.z_m) + (pose.x_m, pose.y_m, 0.0)
    return View(calibration.focal_length_px, calibration.width_px, calibration.height_px, position, _OPTICAL @ mounted.T)


def project(
    calibration: CameraCalibration, pose: Pose, pitch_rad: float, roll_rad: float, points_m: ArrayLike
) -> tuple[Floats, Floats]:
    """Where points (N, 3) of the map frame appear: pixels (N, 2) and depth along the optical axis (N,) in metres.

    A point nearer than NEAR_M or behind the camera has NaN pixels.
    """
    view = view_of(calibration, pose, pitch_rad, roll_rad)
    camera = view.to_camera(np.atleast_2d(np.asarray(points_m, dtype=np.float64)))
    depth = camera[:, 2]
    pixels = np.full((len(camera), 2), np.nan)
    visible = depth >= NEAR_M
    pixels[visible] = view.to_pixels(camera[visible])
    return pixels, depth


def clip_near(polygon_m: Floats, near_m: float = NEAR_M) -> Floats:
    """A polygon (N, 3) of the camera frame, cut at the near plane; may come back with fewer than three corners."""
    depth = polygon_m[:, 2]
    if float(depth.min()) >= near_m:
        return polygon_m
    return _cut(polygon_m, depth - near_m)


def _cut(polygon: Floats, inside: Floats) -> Floats:
    """Sutherland-Hodgman against one plane: keeps where `inside` (signed distance of each corner) is not negative."""
    kept = []
    for here, there, a, b in zip(polygon, np.roll(polygon, -1, axis=0), inside, np.roll(inside, -1), strict=True):
        if a >= 0:
            kept.append(here)
        if (a >= 0) != (b >= 0):
            kept.append(here + (there - here) * (a / (a - b)))
    return np.array(kept).reshape(-1, polygon.shape[1])
