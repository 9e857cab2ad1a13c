"""The path on the road: against plainer rules, and against the projection of the simulated cameras."""

from math import cos, hypot, pi, sin, tan

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.window.course import Motion, Pose, in_car_frame, moved, predicted, remember, ribbon, stopping_distance_m, strip
from tower.window.projection import GroundCamera, camera_named
from vehicle_gateway.video.render.projection import project
from wire.configuration import read_sections, shipped
from wire.messages.sensing import Pose as MapPose
from wire.messages.vehicle import CameraCalibration, VehicleDescription

CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
MS = 1_000_000
ANGLES = st.floats(-0.5, 0.5)


def stepped(motions: list[Motion], capture_ns: int, loop_ms: int) -> Pose:
    """The plainer rule: steps of a millisecond with the newest motion not later than each."""
    x = y = heading = 0.0
    for i in range(loop_ms):
        at = capture_ns + i * MS
        now = next((motion for motion in reversed(motions) if motion.stamp_ns <= at), motions[0])
        middle = heading + now.speed_m_s * 0.0005 * tan(now.road_wheel_angle_rad) / CAR.wheelbase_m
        x += now.speed_m_s * 0.001 * cos(middle)
        y += now.speed_m_s * 0.001 * sin(middle)
        heading += now.speed_m_s * 0.001 * tan(now.road_wheel_angle_rad) / CAR.wheelbase_m
    return Pose(x, y, heading)


@given(
    st.lists(st.tuples(st.floats(-2.0, 9.0), ANGLES), min_size=1, max_size=12),
    st.integers(-5, 5).map(lambda k: 20 * k),
    st.integers(0, 600),
)
def test_the_predicted_pose_is_what_small_steps_along_the_measured_motions_give(
    driven: list[tuple[float, float]], offset_ms: int, loop_ms: int
) -> None:
    capture = 10_000 * MS
    motions = [Motion(capture + (offset_ms + 20 * i) * MS, speed, angle) for i, (speed, angle) in enumerate(driven)]
    ours, plain = predicted(motions, capture, loop_ms / 1000, CAR.wheelbase_m), stepped(motions, capture, loop_ms)
    assert (ours.x_m, ours.y_m, ours.heading_rad) == pytest.approx((plain.x_m, plain.y_m, plain.heading_rad), abs=1e-4)


def test_a_command_takes_effect_farther_on_the_older_the_loop_is() -> None:
    motions = [Motion(0, 8.0, 0.0)]
    assert predicted(motions, 0, 0.25, 2.7).x_m == pytest.approx(2.0)
    assert predicted(motions, 0, 0.0, 2.7) == Pose()


@given(ANGLES.filter(lambda angle: abs(angle) > 0.02), st.floats(1.0, 12.0))
def test_the_strip_is_as_wide_as_the_inner_rear_wheel_and_the_outer_front_corner_make_it(angle: float, length_m: float) -> None:
    """About the centre of the turn: no point of the inner edge is nearer than the body beside the rear axle (all but the last,
    which is the front corner), and the outer edge is the front corner's circle."""
    swept = strip(Pose(), 0.0, length_m, angle, CAR)
    radius = CAR.wheelbase_m / tan(angle)
    inner, outer = (swept.left, swept.right) if angle > 0 else (swept.right, swept.left)
    front = CAR.length_m - CAR.rear_overhang_m
    from_centre = [hypot(x, y - radius) for x, y in inner[:-1]]
    assert from_centre == pytest.approx([abs(radius) - CAR.width_m / 2] * len(from_centre))
    assert [hypot(x, y - radius) for x, y in outer] == pytest.approx([hypot(abs(radius) + CAR.width_m / 2, front)] * len(outer))
    assert hypot(inner[-1][0] - outer[-1][0], inner[-1][1] - outer[-1][1]) == pytest.approx(CAR.width_m)


def test_straight_ahead_the_strip_is_the_car_itself_and_ends_at_its_bumper() -> None:
    swept = strip(Pose(), 2.0, 6.0, 0.0, CAR)
    assert {round(y, 6) for _, y in swept.left} == {CAR.width_m / 2}
    assert {round(y, 6) for _, y in swept.right} == {-CAR.width_m / 2}
    assert swept.left[-1][0] == swept.right[-1][0] == pytest.approx(6.0 + 3.6)


def test_a_path_that_turns_out_of_the_picture_ends_there() -> None:
    poses = strip(Pose(), 0.0, 200.0, 0.5, CAR)
    assert max(hypot(x, y) for x, y in poses.left + poses.right) < 20.0


def braked(speed: float, braking: float, jerk: float) -> float:
    distance, deceleration, step = 0.0, 0.0, 1e-4
    while speed > 0.0:
        deceleration = min(deceleration + jerk * step, braking)
        distance += speed * step
        speed -= deceleration * step
    return distance


@pytest.mark.parametrize("speed", [0.0, 0.3, 1.0, 3.6, 8.33, 13.9])
def test_the_stopping_distance_is_what_braking_in_small_steps_takes(speed: float) -> None:
    assert stopping_distance_m(speed, 2.5, 5.0) == pytest.approx(braked(speed, 2.5, 5.0), abs=0.01)


def test_the_stopping_distance_agrees_with_the_published_one() -> None:
    """21.8 m from 30 km/h with 150 ms of reaction, -2.5 m/s2, jerk 1.5 (reference/remote-driving.md)."""
    assert stopping_distance_m(30 / 3.6, 2.5, 1.5) + 0.15 * 30 / 3.6 == pytest.approx(21.8, abs=0.06)


def test_motions_older_than_a_second_and_a_half_are_forgotten_and_a_restarted_clock_begins_anew() -> None:
    motions: tuple[Motion, ...] = ()
    for i in range(200):
        motions = remember(motions, Motion(i * 20 * MS, 1.0, 0.0))
    assert len(motions) == 76
    assert remember(motions, motions[-1]) == motions
    assert remember(motions, Motion(5, 1.0, 0.0)) == (Motion(5, 1.0, 0.0),)


@given(st.floats(-50, 50), st.floats(-50, 50), st.floats(-3.2, 3.2), st.floats(-20, 20), st.floats(-20, 20))
def test_the_frame_of_the_car_is_undone_by_moving_out_of_it(x: float, y: float, heading: float, px: float, py: float) -> None:
    ahead, left = in_car_frame((px, py), x, y, heading)
    along = moved(Pose(x, y, heading), ahead, 0.0)
    aside = moved(Pose(along.x_m, along.y_m, heading + pi / 2), left, 0.0)
    assert (aside.x_m, aside.y_m) == pytest.approx((px, py), abs=1e-6)


def test_a_corridor_has_the_width_of_the_car_and_one_point_is_none() -> None:
    band = ribbon([(0.0, 0.0), (5.0, 0.0), (10.0, 0.0)], 1.8)
    assert band is not None
    assert np.allclose(band.left, [(0.0, 0.9), (5.0, 0.9), (10.0, 0.9)])
    assert np.allclose(band.right, [(0.0, -0.9), (5.0, -0.9), (10.0, -0.9)])
    assert ribbon([(1.0, 1.0)], 1.8) is None


@given(st.floats(3.0, 60.0), st.floats(-10.0, 10.0), st.floats(0.0, 2.0), st.floats(-1.2, 1.2), st.floats(-0.2, 0.4))
def test_a_point_of_the_road_appears_where_the_simulated_camera_draws_it(
    x_m: float, y_m: float, z_m: float, yaw_rad: float, pitch_rad: float
) -> None:
    camera = CameraCalibration(
        name="a",
        required=False,
        width_px=1280,
        height_px=720,
        frame_rate_hz=30.0,
        focal_length_px=760.0,
        x_m=1.7,
        y_m=0.3,
        z_m=1.35,
        yaw_rad=yaw_rad,
        pitch_rad=pitch_rad,
    )
    theirs, depth = project(camera, MapPose(x_m=0.0, y_m=0.0, heading_rad=0.0), 0.0, 0.0, np.array([[x_m, y_m, z_m]]))
    ours = GroundCamera(camera).pixel(x_m, y_m, z_m)
    if depth[0] > 0.61:
        assert ours == pytest.approx(tuple(theirs[0]), rel=1e-6, abs=1e-6)
    elif depth[0] < 0.59:
        assert ours is None


def test_a_camera_is_found_by_its_name() -> None:
    assert camera_named(CAR, "front") == CAR.cameras[0]
    assert camera_named(CAR, "roof") is None
    assert camera_named(None, "front") is None
