"""Points on the road in front of the car -> pixels of a camera's picture. Pure; flat ground, no lens distortion.

Frames: the car's is ISO 8855 (x forward, y left, z up, origin: rear axle on the ground); pixels run right and down from the
picture's upper left corner. Pinhole as in CameraCalibration. Body pitch and roll are not known here and are left out.
"""

from collections.abc import Iterable
from math import cos, sin

from wire.messages.vehicle import CameraCalibration, VehicleDescription

NEAR_M = 0.6  # depth below which a ground point is under the car anyway; keeps pixels finite
XY = tuple[float, float]


def camera_named(description: VehicleDescription | None, name: str) -> CameraCalibration | None:
    cameras = description.cameras if description is not None else ()
    return next((camera for camera in cameras if camera.name == name), None)


class GroundCamera:
    """Made once per calibration; `pixels` per point costs about a microsecond."""

    def __init__(self, calibration: CameraCalibration) -> None:
        self._at = (calibration.x_m, calibration.y_m, calibration.z_m)
        cy, sy, cp, sp = cos(calibration.yaw_rad), sin(calibration.yaw_rad), cos(calibration.pitch_rad), sin(calibration.pitch_rad)
        self._forward = (cy * cp, sy * cp, -sp)
        self._right = (sy, -cy, 0.0)
        self._down = (-cy * sp, -sy * sp, -cp)
        self._focal_px = calibration.focal_length_px
        self._centre = (calibration.width_px / 2, calibration.height_px / 2)

    def pixel(self, x_m: float, y_m: float, z_m: float = 0.0) -> XY | None:
        """None: the point is behind the camera or nearer than NEAR_M."""
        x, y, z = x_m - self._at[0], y_m - self._at[1], z_m - self._at[2]
        depth = x * self._forward[0] + y * self._forward[1] + z * self._forward[2]
        if depth < NEAR_M:
            return None
        zoom = self._focal_px / depth
        right = x * self._right[0] + y * self._right[1]
        down = x * self._down[0] + y * self._down[1] + z * self._down[2]
        return self._centre[0] + right * zoom, self._centre[1] + down * zoom

    def line(self, points_m: Iterable[XY]) -> list[XY]:
        """Pixels of a polyline on the ground; what the camera cannot see is left out."""
        return [pixel for x, y in points_m if (pixel := self.pixel(x, y)) is not None]
