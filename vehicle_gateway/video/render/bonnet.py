"""The car's own bonnet at the bottom of the picture: rigid with the camera, painted once from the car's size.

Its shape is a plain curved sheet between windscreen and front bumper, as wide as the car. Not modelled: wipers, mirrors,
the windscreen's frame, reflections of what passes.
"""

import cv2
import numpy as np

from vehicle_gateway.video.render.brush import fixed
from vehicle_gateway.video.render.projection import NEAR_M, Flags, Floats, Numbers, Picture, View, view_of
from wire.messages.sensing import Pose
from wire.messages.vehicle import CameraCalibration, VehicleDescription

REAR_M = 1.35  # length of the bonnet, from the front bumper to the windscreen
FRONT_HEIGHT_SHARE, REAR_HEIGHT_SHARE = 0.455, 0.61  # of the car's height
PAINT = np.array([116.0, 86.0, 58.0])  # BGR
SKY = np.array([232.0, 214.0, 190.0])
STEPS = 48


class Bonnet:
    def __init__(self, calibration: CameraCalibration, vehicle: VehicleDescription) -> None:
        view = view_of(calibration, Pose(x_m=0.0, y_m=0.0, heading_rad=0.0))
        picture = _paint(view, vehicle)
        cover = picture[..., 3]
        used = np.flatnonzero(cover.any(axis=1))
        self.first_row = int(used[0]) if len(used) else view.height_px
        full = np.flatnonzero((cover == 255).all(axis=1))
        self.hides_from_row = int(full[0]) if len(full) else view.height_px  # every row from here on is bonnet alone
        self._picture = np.ascontiguousarray(picture[self.first_row :])
        self._solid = np.where(self._picture[..., 3] == 255, 255, 0).astype(np.uint8)
        rim = (self._picture[..., 3] > 0) & (self._picture[..., 3] < 255)
        self._rim = np.nonzero(rim)
        self._over = self._picture[self._rim].astype(np.uint16)
        self._rest = 255 - self._over[:, 3:]

    def solid_from(self, cell_px: int) -> Numbers:
        """Per `cell_px` columns the row from which on all is bonnet; below the picture when there is none."""
        rows, columns = self._solid.shape
        bare = np.zeros((rows + 1, -(-columns // cell_px) * cell_px), dtype=bool)
        bare[:rows, :columns] = self._solid == 0
        cells: Flags = bare.reshape(rows + 1, -1, cell_px).max(axis=2)
        last_bare = rows - np.argmax(cells[::-1], axis=0)
        return np.where(cells.any(axis=0), last_bare + 1, 0) + self.first_row

    def draw(self, canvas: Picture) -> None:
        """Over everything else."""
        part = canvas[self.first_row :]
        if not part.size:
            return
        if len(self._rim[0]):
            part[self._rim] = (self._over + part[self._rim] * self._rest // 255).astype(np.uint8)
        cv2.copyTo(self._picture, self._solid, part)


def _surface(vehicle: VehicleDescription) -> tuple[Floats, Floats]:
    """Points (STEPS, STEPS, 3) of the sheet in the car's frame, from the windscreen to the front, right to left; normals."""
    front = vehicle.length_m - vehicle.rear_overhang_m
    along = np.linspace(0, 1, STEPS)[:, None]
    across = np.linspace(-1, 1, STEPS)[None, :]
    half = vehicle.width_m / 2 - 0.06
    x = front - REAR_M + along * (REAR_M - 0.26 * across**4 - 0.05 * across**2)
    y = across * half * (1 - 0.10 * along**2)
    low, high = FRONT_HEIGHT_SHARE * vehicle.height_m, REAR_HEIGHT_SHARE * vehicle.height_m
    z = high + (low - high) * (0.45 * along + 0.55 * along**3) - 0.05 * across**2 - 0.06 * across**6
    z = z + 0.016 * np.exp(-(((np.abs(across) - 0.62) / 0.09) ** 2)) * (1 - 0.5 * along)  # two ridges
    points = np.stack((x, y + 0 * x, z), axis=-1)
    normals = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
    return points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)


def _paint(view: View, vehicle: VehicleDescription) -> Picture:
    """(H, W, 4) premultiplied. The sheet's small faces are filled far to near, then smoothed inside the outline."""
    points, normals = _surface(vehicle)
    camera = view.to_camera(points)
    colours = _colours(points, normals, view)
    picture = np.zeros((view.height_px, view.width_px, 4), np.uint8)
    outline = np.zeros((view.height_px, view.width_px), np.uint8)
    safe = np.concatenate((camera[..., :2], np.maximum(camera[..., 2:], NEAR_M)), axis=-1)
    pixels = view.to_pixels(safe)
    for i in reversed(range(STEPS - 1)):
        for j in range(STEPS - 1):
            if camera[i : i + 2, j : j + 2, 2].min() < NEAR_M:
                continue
            quad = fixed(np.array([pixels[i, j], pixels[i, j + 1], pixels[i + 1, j + 1], pixels[i + 1, j]]))
            cv2.fillConvexPoly(picture, quad, (*colours[i, j], 255.0), cv2.LINE_AA, 4)
            cv2.fillConvexPoly(outline, quad, (255,), cv2.LINE_AA, 4)
    used = np.flatnonzero(outline.any(axis=1))
    if len(used):
        rows = slice(int(used[0]), view.height_px)
        picture[rows] = _smoothed(picture[rows], outline[rows])
    return picture


def _smoothed(picture: Picture, outline: Picture) -> Picture:
    """The small faces melted into one sheet, its rim darker, its edge as sharp as before."""
    colour = cv2.GaussianBlur(picture[..., :3].astype(np.float32), (0, 0), 5)
    weight = cv2.GaussianBlur((picture[..., 3] > 0).astype(np.float32), (0, 0), 5)
    edge = cv2.GaussianBlur(outline, (0, 0), 3).astype(np.float32) / 255
    shade = (np.clip((edge - 0.5) * 2, 0, 1) * 0.45 + 0.55) * outline / 255 / np.maximum(weight, 1e-3)
    return np.concatenate((colour * shade[..., None], outline[..., None]), axis=-1).clip(0, 255).astype(np.uint8)


def _colours(points_m: Floats, normals: Floats, view: View) -> Floats:
    """Paint that mirrors the sky: the flatter the look, the brighter (Schlick's approximation of Fresnel's equations)."""
    look = points_m - view.position_m
    look = look / np.linalg.norm(look, axis=-1, keepdims=True)
    up = np.where(normals[..., 2:] < 0, -normals, normals)
    facing = np.clip(-(look * up).sum(axis=-1, keepdims=True), 0, 1)
    mirrored = 0.05 + 0.95 * (1 - facing) ** 5
    bounce = look - 2 * (look * up).sum(axis=-1, keepdims=True) * up
    high = np.clip(bounce[..., 2:], 0, 1)
    sky = SKY * (1 - 0.55 * high**0.6)
    diffuse = PAINT * (0.55 + 0.45 * up[..., 2:])
    colours: Floats = diffuse * (1 - mirrored) * 0.75 + sky * np.clip(mirrored * 1.1, 0, 0.75)
    return colours
