"""The pinhole model against plain formulas: one rotation after the other, by hand."""

from math import cos, isnan, pi, sin, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.render.projection import NEAR_M, clip_near, project, view_of
from wire.messages.sensing import Pose
from wire.messages.vehicle import CameraCalibration


def calibration(**changes: float) -> CameraCalibration:
    values: dict[str, float] = {"focal_length_px": 760.0, "x_m": 1.7, "y_m": 0.2, "z_m": 1.35, "yaw_rad": 0.0, "pitch_rad": 0.06}
    return CameraCalibration(name="front", required=True, width_px=1280, height_px=720, frame_rate_hz=30.0, **{**values, **changes})


def turned(a: float, b: float, angle: float) -> tuple[float, float]:
    """The coordinates (a, b) in a frame turned by `angle` from a towards b."""
    return a * cos(angle) + b * sin(angle), b * cos(angle) - a * sin(angle)


def by_hand(
    camera: CameraCalibration, pose: Pose, pitch: float, roll: float, point: tuple[float, float, float]
) -> tuple[float, float, float]:
    """u, v, depth: undo heading, body pitch, body roll, mounting, camera yaw, camera pitch, one after the other."""
    x, y = turned(point[0] - pose.x_m, point[1] - pose.y_m, pose.heading_rad)
    z, x = turned(point[2], x, pitch)  # about y (left): positive turns z towards x, the nose down
    y, z = turned(y, z, roll)  # about x (ahead): positive turns left towards up
    x, y, z = x - camera.x_m, y - camera.y_m, z - camera.z_m
    x, y = turned(x, y, camera.yaw_rad)
    z, x = turned(z, x, camera.pitch_rad)
    return (camera.width_px / 2 - camera.focal_length_px * y / x, camera.height_px / 2 - camera.focal_length_px * z / x, x)


angle = st.floats(-0.3, 0.3)


@given(angle, angle, st.floats(-3, 3), angle, angle, st.floats(3, 80), st.floats(-0.5, 0.5), st.floats(-2, 8))
def test_every_point_appears_where_one_rotation_after_the_other_puts_it(
    yaw: float, tilt: float, heading: float, pitch: float, roll: float, away: float, aside: float, up: float
) -> None:
    camera = calibration(yaw_rad=yaw, pitch_rad=tilt)
    pose = Pose(x_m=123.0, y_m=-45.0, heading_rad=heading)
    point = (123.0 + away * cos(heading + aside), -45.0 + away * sin(heading + aside), up)
    u, v, depth = by_hand(camera, pose, pitch, roll, point)
    pixels, depths = project(camera, pose, pitch, roll, [point])
    assert depths[0] == pytest.approx(depth, abs=1e-9)
    if depth > NEAR_M:
        assert pixels[0] == pytest.approx((u, v), abs=1e-5 * max(1.0, abs(u), abs(v)))


def test_a_point_ahead_at_camera_height_lies_above_the_middle_by_the_tangent_of_the_pitch() -> None:
    pixels, _ = project(calibration(y_m=0.0), Pose(x_m=0, y_m=0, heading_rad=0), 0.0, 0.0, [(1e6, 0.0, 1.35)])
    assert pixels[0] == pytest.approx((640.0, 360.0 - 760.0 * tan(0.06)), abs=0.01)


def test_a_nose_that_dips_sees_the_horizon_higher_and_a_lean_to_the_right_raises_the_right_side() -> None:
    pose = Pose(x_m=0, y_m=0, heading_rad=0)
    far = [(1e5, 2e4, 0.0), (1e5, -2e4, 0.0)]  # left and right
    level, _ = project(calibration(), pose, 0.0, 0.0, far)
    dipped, _ = project(calibration(), pose, 0.03, 0.0, far)
    leaning, _ = project(calibration(), pose, 0.0, 0.03, far)
    assert (dipped[:, 1] < level[:, 1]).all()
    assert leaning[0, 1] > level[0, 1] and leaning[1, 1] < level[1, 1]


def test_a_point_behind_the_camera_has_no_pixel_and_a_negative_depth() -> None:
    pixels, depth = project(calibration(), Pose(x_m=0, y_m=0, heading_rad=pi), 0.0, 0.0, [(5.0, 0.0, 0.0)])
    assert depth[0] < 0 and isnan(pixels[0, 0]) and isnan(pixels[0, 1])


def test_the_horizon_of_a_level_camera_is_its_middle_row_and_rises_by_the_tangent_of_the_pitch() -> None:
    pose = Pose(x_m=0, y_m=0, heading_rad=1.0)
    assert view_of(calibration(pitch_rad=0.0), pose).horizon_px == pytest.approx(360.0)
    assert view_of(calibration(), pose).horizon_px == pytest.approx(360.0 - 760.0 * tan(0.06))


@given(st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9), st.floats(-9, 9)), min_size=3, max_size=6))
def test_nothing_nearer_than_the_near_plane_survives_clipping(corners: list[tuple[float, float, float]]) -> None:
    clipped = clip_near(np.array(corners))
    assert (clipped[:, 2] >= NEAR_M - 1e-9).all()
    if all(z >= NEAR_M for _, _, z in corners):
        assert len(clipped) == len(corners)


def test_a_square_half_behind_the_camera_keeps_its_front_half() -> None:
    square = np.array([[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]])
    clipped = clip_near(square)
    x, z = clipped[:, 0], clipped[:, 2]
    area = 0.5 * abs(float(np.dot(x, np.roll(z, -1)) - np.dot(z, np.roll(x, -1))))
    assert area == pytest.approx(2.0 * (1.0 - NEAR_M))
