"""Localization against a car whose true motion is a circle or a straight, computed by the circle's own formula."""

from math import cos, hypot, pi, sin
from random import Random

import pytest

from autonomy.localization.ekf import Estimate, LocalizationSettings, on_gnss, on_imu, on_wheels, pose_at, start
from wire.messages.sensing import Gnss, Imu, WheelSpeeds

SETTINGS = LocalizationSettings()
SPEED, RATE = 6.0, 0.12  # a circle of 50 m


def truth(t: float) -> tuple[float, float, float]:
    radius, angle = SPEED / RATE, RATE * t
    return radius * sin(angle), radius * (1 - cos(angle)), angle


def imu(t: float, rate: float, ax: float = 0.0) -> Imu:
    return Imu(
        stamp_ns=round(t * 1e9),
        acceleration_x_m_s2=ax,
        acceleration_y_m_s2=0.0,
        acceleration_z_m_s2=9.81,
        roll_rate_rad_s=0.0,
        pitch_rate_rad_s=0.0,
        yaw_rate_rad_s=rate,
    )


def wheels(t: float, speed: float, angle: float = 0.0) -> WheelSpeeds:
    return WheelSpeeds(
        stamp_ns=round(t * 1e9),
        front_left_m_s=speed,
        front_right_m_s=speed,
        rear_left_m_s=speed,
        rear_right_m_s=speed,
        road_wheel_angle_rad=angle,
    )


def gnss(t: float, place: tuple[float, float, float], deviation: float = 0.05) -> Gnss:
    return Gnss(
        stamp_ns=round(t * 1e9),
        x_m=place[0],
        y_m=place[1],
        deviation_m=deviation,
        heading_rad=place[2],
        heading_deviation_rad=0.006,
    )


def circle(seconds: float, random: Random, bias: float = 0.004, gnss_until: float = 1e9) -> Estimate:
    estimate = start(gnss(0.0, truth(0.0)), SETTINGS)
    for tick in range(1, round(seconds * 100)):
        t = tick / 100
        estimate = on_imu(estimate, imu(t, random.gauss(RATE + bias, 0.003)), SETTINGS)
        if tick % 2 == 0:
            estimate = on_wheels(estimate, wheels(t, random.gauss(SPEED, 0.03), 0.054), 2.7, SETTINGS)
        if tick % 10 == 0 and t < gnss_until:
            x, y, heading = truth(t)
            noisy = (random.gauss(x, 0.05), random.gauss(y, 0.05), random.gauss(heading, 0.006))
            estimate = on_gnss(estimate, gnss(t, noisy), SETTINGS)
    return estimate


@pytest.mark.parametrize("seed", range(4))
def test_on_a_circle_the_pose_stays_within_three_of_its_own_deviations(seed: int) -> None:
    pose = pose_at(circle(12.0, Random(seed)), 12_000_000_000)
    x, y, heading = truth(12.0)
    deviation = circle(12.0, Random(seed)).deviation_m
    assert deviation < 0.05  # better than one fix
    assert abs(pose.x_m - x) < 3 * deviation + 0.02 and abs(pose.y_m - y) < 3 * deviation + 0.02
    assert pose.heading_rad == pytest.approx(heading, abs=0.01)
    assert pose.yaw_rate_rad_s == pytest.approx(RATE, abs=0.012)
    assert pose.speed_m_s == pytest.approx(SPEED, abs=0.05)


def test_a_fix_far_off_is_rejected_and_counted_and_one_good_fix_clears_the_count() -> None:
    estimate = circle(5.0, Random(1))
    x, y, heading = truth(5.0)
    before = pose_at(estimate, 5_000_000_000)
    for i in range(3):
        estimate = on_gnss(estimate, gnss(5.0, (x + 5.0, y, heading)), SETTINGS)
        assert estimate.rejected_in_a_row == i + 1
    after = pose_at(estimate, 5_000_000_000)
    assert after.x_m == pytest.approx(before.x_m, abs=0.02)
    assert on_gnss(estimate, gnss(5.0, (x, y, heading)), SETTINGS).rejected_in_a_row == 0


@pytest.mark.parametrize("rate_hz", [10, 50])
def test_a_receiver_that_stands_still_with_fresh_stamps_does_not_hide_a_turn(rate_hz: int) -> None:
    """Straight on for two seconds; then its fixes stand still, and half a second later the car turns for five."""
    turn_rad_s, stuck_s, turns_s, end_s = -0.045, 2.0, 2.5, 7.5

    def place(t: float) -> tuple[float, float, float]:
        turned, radius = turn_rad_s * max(t - turns_s, 0.0), SPEED / turn_rad_s
        return SPEED * min(t, turns_s) + radius * sin(turned), radius * (1 - cos(turned)), turned

    random, estimate = Random(5), start(gnss(0.0, place(0.0)), SETTINGS)
    for tick in range(1, round(end_s * 100) + 1):
        t = tick / 100
        rate = turn_rad_s if t > turns_s else 0.0
        estimate = on_imu(estimate, imu(t, random.gauss(rate + 0.004, 0.003)), SETTINGS)
        if tick % 2 == 0:
            estimate = on_wheels(estimate, wheels(t, random.gauss(SPEED, 0.03), rate * 2.7 / SPEED), 2.7, SETTINGS)
        if tick % (100 // (rate_hz if t > stuck_s else 10)) == 0:
            estimate = on_gnss(estimate, gnss(t, place(min(t, stuck_s))), SETTINGS)
    pose, (x, y, heading) = pose_at(estimate, round(end_s * 1e9)), place(end_s)
    assert estimate.rejected_in_a_row > 20
    assert pose.heading_rad == pytest.approx(heading, abs=0.03)
    assert hypot(pose.x_m - x, pose.y_m - y) < 0.6


def test_a_late_fix_does_not_pull_the_car_back() -> None:
    estimate = circle(6.0, Random(2))
    x, y, heading = truth(5.8)  # 0.2 s old: 1.2 m behind
    pose = pose_at(on_gnss(estimate, gnss(5.8, (x, y, heading)), SETTINGS), 6_000_000_000)
    true_x, true_y, _ = truth(6.0)
    assert (pose.x_m - true_x) ** 2 + (pose.y_m - true_y) ** 2 < 0.1**2


def test_without_fixes_the_deviation_grows_and_the_pose_follows_wheels_and_gyro() -> None:
    with_fixes, without = circle(12.0, Random(3)), circle(12.0, Random(3), gnss_until=6.0)
    assert without.deviation_m > 2 * with_fixes.deviation_m
    x, y, _ = truth(12.0)
    pose = pose_at(without, 12_000_000_000)
    assert (pose.x_m - x) ** 2 + (pose.y_m - y) ** 2 < 1.0**2  # 36 m driven blind


def test_a_standing_car_learns_the_bias_of_its_gyro() -> None:
    estimate = start(gnss(0.0, (0.0, 0.0, pi)), SETTINGS)
    for tick in range(1, 500):
        estimate = on_imu(estimate, imu(tick / 100, 0.008), SETTINGS)
        estimate = on_wheels(estimate, wheels(tick / 100, 0.0), 2.7, SETTINGS)
    assert pose_at(estimate, 5_000_000_000).yaw_rate_rad_s == pytest.approx(0.0, abs=0.0005)


def test_a_car_that_stands_on_a_hill_stands_and_one_that_sets_off_is_followed_at_once() -> None:
    """Its accelerometer feels 0.9 m/s2 of a slope; taken for motion, that is 2 cm/s between two messages of the wheels."""
    estimate = start(gnss(0.0, (0.0, 0.0, 0.0)), SETTINGS)
    for tick in range(1, 100):
        estimate = on_imu(estimate, imu(tick / 100, 0.0, 0.9), SETTINGS)
        if tick % 2 == 0:
            estimate = on_wheels(estimate, wheels(tick / 100, 0.0), 2.7, SETTINGS)
            assert pose_at(estimate, (tick + 1) * 10_000_000).speed_m_s == 0.0
    for tick in range(100, 130):
        estimate = on_imu(estimate, imu(tick / 100, 0.0, 2.0), SETTINGS)
        if tick % 2 == 0:
            estimate = on_wheels(estimate, wheels(tick / 100, (tick - 99) * 0.02), 2.7, SETTINGS)
    assert estimate.mean[3] == pytest.approx(0.6, abs=0.06)
