"""Extended Kalman filter over x, y, heading, speed and gyro bias. Pure: measurements in, estimate out.

Motion: the gyro and the IMU's forward acceleration drive a planar kinematic model (no sideslip at the rear axle, level
road); wheel speeds, the steering angle and a dual-antenna GNSS correct it. A correction that does not fit (normalised
innovation squared above the chi-square gate) is rejected and counted. It never smooths backwards and models no slip.
Source: the paper's III-C (predict with a kinematic model, correct with pose and twist), with GNSS in the place of NDT.
"""

from dataclasses import dataclass
from math import cos, inf, sin, sqrt, tan
from typing import Annotated

import numpy as np
from msgspec import Meta, Struct
from msgspec.structs import replace
from numpy.typing import NDArray

from wire.messages.base import Message
from wire.messages.sensing import Gnss, Imu, WheelSpeeds
from wire.road import wrap_angle

X, Y, HEADING, SPEED, BIAS = range(5)
Matrix = NDArray[np.float64]
Deviation = Annotated[float, Meta(gt=0.0, le=100.0)]
CHI_SQUARE_1 = 10.83  # 99.9 % quantile, one degree of freedom
CHI_SQUARE_2 = 13.82  # 99.9 % quantile, two degrees of freedom
STANDSTILL_M_S = 0.05  # slower than this on all wheels: the car stands, and what the gyro says is its bias
_EYE = np.eye(5)


class LocalizationSettings(Message):
    """Standard deviations the filter reckons with; of inputs, what a good series sensor keeps."""

    gyro_rad_s: Deviation = 0.01  # per square root of Hz: noise and scale of a MEMS gyro
    bias_walk_rad_s: Deviation = 0.0003  # per square root of s
    bias_start_rad_s: Deviation = 0.01
    acceleration_m_s2: Deviation = 1.0  # IMU against true forward acceleration: noise, pitch, slope
    wheel_speed_m_s: Deviation = 0.06
    steering_yaw_rate_rad_s: Deviation = 0.06  # v tan(angle) / wheelbase against the true yaw rate
    gnss_least_m: Deviation = 0.03  # never believe GNSS to be better than this


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Rear axle in the map frame."""

    stamp_ns: int
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    yaw_rate_rad_s: float


class Estimate(Struct, frozen=True, kw_only=True):
    stamp_ns: int
    mean: Matrix  # (5,)
    covariance: Matrix  # (5, 5)
    gyro_rad_s: float = 0.0  # last raw reading
    acceleration_m_s2: float = 0.0  # last raw reading
    stands: bool = False  # by its wheels: what the accelerometer then feels is a slope
    rejected_in_a_row: int = 0  # GNSS positions
    innovation: float = 2.0  # running mean of the normalised innovation squared of GNSS positions; 2 when all is well

    @property
    def deviation_m(self) -> float:
        """One standard deviation of the position along the longer axis of its error ellipse."""
        a, b, c = self.covariance[X, X], self.covariance[X, Y], self.covariance[Y, Y]
        return sqrt(max((a + c) / 2 + sqrt(((a - c) / 2) ** 2 + b * b), 0.0))


def start(gnss: Gnss, settings: LocalizationSettings) -> Estimate:
    """The first estimate: where GNSS says, standing still as far as is known."""
    position = max(gnss.deviation_m, settings.gnss_least_m) ** 2
    variances = [position, position, gnss.heading_deviation_rad**2 + 1e-6, 9.0, settings.bias_start_rad_s**2]
    return Estimate(
        stamp_ns=gnss.stamp_ns, mean=np.array([gnss.x_m, gnss.y_m, gnss.heading_rad, 0.0, 0.0]), covariance=np.diag(variances)
    )


def pose_at(estimate: Estimate, now_ns: int) -> Pose:
    """The pose at any time near the estimate's, before or after, along the present arc."""
    x, y, heading, speed, bias = (float(value) for value in estimate.mean)
    dt = (now_ns - estimate.stamp_ns) * 1e-9
    rate = estimate.gyro_rad_s - bias
    middle = heading + rate * dt / 2
    return Pose(
        stamp_ns=now_ns,
        x_m=x + speed * dt * cos(middle),
        y_m=y + speed * dt * sin(middle),
        heading_rad=wrap_angle(heading + rate * dt),
        speed_m_s=speed,
        yaw_rate_rad_s=rate,
    )


def advance(estimate: Estimate, to_ns: int, settings: LocalizationSettings) -> Estimate:
    """Predict to `to_ns` with the last gyro and acceleration. Going backwards in time changes nothing."""
    dt = (to_ns - estimate.stamp_ns) * 1e-9
    if dt <= 0.0:
        return estimate
    pose = pose_at(estimate, to_ns)
    speed, heading = pose.speed_m_s, pose.heading_rad
    c, s = cos(heading), sin(heading)
    jacobian = _EYE.copy()
    jacobian[X, HEADING], jacobian[X, SPEED] = -speed * s * dt, c * dt
    jacobian[Y, HEADING], jacobian[Y, SPEED] = speed * c * dt, s * dt
    jacobian[HEADING, BIAS] = -dt
    covariance = jacobian @ estimate.covariance @ jacobian.T
    covariance[HEADING, HEADING] += settings.gyro_rad_s**2 * dt
    covariance[SPEED, SPEED] += settings.acceleration_m_s2**2 * dt * max(dt, 0.02)
    covariance[BIAS, BIAS] += settings.bias_walk_rad_s**2 * dt
    gained = 0.0 if estimate.stands else estimate.acceleration_m_s2 * dt
    mean = np.array([pose.x_m, pose.y_m, heading, speed + gained, estimate.mean[BIAS]])
    return replace(estimate, stamp_ns=to_ns, mean=mean, covariance=covariance)


def on_imu(estimate: Estimate, imu: Imu, settings: LocalizationSettings) -> Estimate:
    moved = advance(estimate, imu.stamp_ns, settings)
    return replace(moved, gyro_rad_s=imu.yaw_rate_rad_s, acceleration_m_s2=imu.acceleration_x_m_s2)


def on_wheels(estimate: Estimate, wheels: WheelSpeeds, wheelbase_m: float, settings: LocalizationSettings) -> Estimate:
    """Speed from the rear wheels; the gyro's bias from standstill or from the steering angle."""
    moved = advance(estimate, wheels.stamp_ns, settings)
    speed = (wheels.rear_left_m_s + wheels.rear_right_m_s) / 2
    moved, _ = _correct(moved, SPEED, speed - moved.mean[SPEED], settings.wheel_speed_m_s**2, inf)
    stands = abs(speed) < STANDSTILL_M_S
    if stands:
        moved = replace(moved, mean=np.array([*moved.mean[:SPEED], speed, moved.mean[BIAS]]))  # without pulses there is no noise
        turned, deviation = 0.0, settings.gyro_rad_s
    else:
        turned, deviation = speed * tan(wheels.road_wheel_angle_rad) / wheelbase_m, settings.steering_yaw_rate_rad_s
    moved, _ = _correct(moved, BIAS, moved.gyro_rad_s - turned - moved.mean[BIAS], deviation**2, CHI_SQUARE_1)
    return replace(moved, stands=stands)


def on_gnss(estimate: Estimate, gnss: Gnss, settings: LocalizationSettings) -> Estimate:
    """Position, then heading. A late fix is compared with where the filter says the car was then.

    Of a fix whose position is rejected the heading is not believed either: one that stands still fits a straight road, holds the
    heading there and lets the gyro's bias explain every turn.
    """
    moved = advance(estimate, gnss.stamp_ns, settings)
    then = pose_at(moved, gnss.stamp_ns)
    variance = max(gnss.deviation_m, settings.gnss_least_m) ** 2
    moved = _correct_position(moved, gnss.x_m - then.x_m, gnss.y_m - then.y_m, variance)
    if moved.rejected_in_a_row:
        return moved
    turn = wrap_angle(gnss.heading_rad - pose_at(moved, gnss.stamp_ns).heading_rad)
    moved, _ = _correct(moved, HEADING, turn, gnss.heading_deviation_rad**2 + 1e-6, CHI_SQUARE_1)
    return moved


def _correct(estimate: Estimate, index: int, innovation: float, variance: float, gate: float) -> tuple[Estimate, bool]:
    """One scalar measurement of state `index`: (estimate, accepted)."""
    covariance = estimate.covariance
    total = float(covariance[index, index]) + variance
    if innovation * innovation > gate * total:
        return estimate, False
    gain = covariance[:, index] / total
    mean = estimate.mean + gain * innovation
    mean[HEADING] = wrap_angle(mean[HEADING])
    return replace(estimate, mean=mean, covariance=covariance - np.outer(gain, covariance[index])), True


def _correct_position(estimate: Estimate, dx: float, dy: float, variance: float) -> Estimate:
    covariance = estimate.covariance
    a, b, c = covariance[X, X] + variance, covariance[X, Y], covariance[Y, Y] + variance
    inverse = np.array([[c, -b], [-b, a]]) / (a * c - b * b)
    innovation = np.array([dx, dy])
    normalised = float(innovation @ inverse @ innovation)
    running = estimate.innovation + 0.1 * (min(normalised, 100.0) - estimate.innovation)
    if normalised > CHI_SQUARE_2:
        return replace(estimate, rejected_in_a_row=estimate.rejected_in_a_row + 1, innovation=running)
    gain = covariance[:, :2] @ inverse
    mean = estimate.mean + gain @ innovation
    mean[HEADING] = wrap_angle(mean[HEADING])
    smaller = covariance - gain @ covariance[:2]
    return replace(estimate, mean=mean, covariance=(smaller + smaller.T) / 2, rejected_in_a_row=0, innovation=running)
