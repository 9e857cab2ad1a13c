"""Where the car will be when a command given now takes effect, and the strip of road it sweeps from there. Pure.

The picture shows the car as it was at its capture stamp. What the operator does now reaches the car one loop age after that
stamp, so the path begins at the pose the car will have then, and the stopping line one stopping distance farther.

Kinematic bicycle about the rear axle; no slip, no actuator lag: at the speeds of remote driving the front tyres follow within
centimetres. Frame of every point: the car's own at the capture stamp (ISO 8855, origin: rear axle on the ground).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2, cos, sin, tan

from wire.messages.vehicle import VehicleDescription

XY = tuple[float, float]
_STEP_M, _STEP_SHARE = 0.75, 0.2  # between points of an edge, or this share of the way so far: far away they stand close
_SAGITTA_M = 0.015  # how far an arc may lie from its chords
_STRAIGHT_1_M = 1e-5
_TURN_MAX_RAD = 1.6  # a path that turns farther leaves the front picture
KEEP_NS = 1_500_000_000  # nobody drives with a loop older than that


@dataclass(frozen=True, slots=True)
class Motion:
    """The car's own measurement at one moment, vehicle clock."""

    stamp_ns: int
    speed_m_s: float  # forward positive
    road_wheel_angle_rad: float  # left positive


@dataclass(frozen=True, slots=True)
class Pose:
    x_m: float = 0.0
    y_m: float = 0.0
    heading_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Strip:
    """The road the body sweeps: its two edges from the near end to the far one. The inner edge is the rear wheel's track."""

    left: tuple[XY, ...]
    right: tuple[XY, ...]


def remember(motions: tuple[Motion, ...], new: Motion) -> tuple[Motion, ...]:
    """The motions of the last 1.5 s; a stamp that falls back begins anew (a restarted car)."""
    if motions and new.stamp_ns <= motions[-1].stamp_ns:
        return motions if new.stamp_ns == motions[-1].stamp_ns else (new,)
    return (*(motion for motion in motions if new.stamp_ns - motion.stamp_ns <= KEEP_NS), new)


def predicted(motions: Sequence[Motion], capture_ns: int, loop_s: float, wheelbase_m: float) -> Pose:
    """The pose `loop_s` after the capture: along the measured motions, and the last of them held beyond the newest."""
    end_ns = capture_ns + round(loop_s * 1e9)
    pose = Pose()
    for i, motion in enumerate(motions):
        begin = capture_ns if i == 0 else max(motion.stamp_ns, capture_ns)
        until = end_ns if i + 1 == len(motions) else min(motions[i + 1].stamp_ns, end_ns)
        if until > begin:
            distance = motion.speed_m_s * (until - begin) / 1e9
            pose = moved(pose, distance, tan(motion.road_wheel_angle_rad) / wheelbase_m)
    return pose


def moved(pose: Pose, distance_m: float, curvature_1_m: float) -> Pose:
    """Along a circle; left positive."""
    turn = distance_m * curvature_1_m
    if abs(curvature_1_m) < _STRAIGHT_1_M:
        ahead, aside = distance_m, 0.0
    else:
        ahead, aside = sin(turn) / curvature_1_m, (1 - cos(turn)) / curvature_1_m
    c, s = cos(pose.heading_rad), sin(pose.heading_rad)
    return Pose(pose.x_m + ahead * c - aside * s, pose.y_m + ahead * s + aside * c, pose.heading_rad + turn)


def strip(begin: Pose, begin_m: float, end_m: float, road_wheel_angle_rad: float, car: VehicleDescription) -> Strip:
    """What the body sweeps between two distances of travel from `begin` at a constant angle of the road wheels.

    The outer edge is drawn by the outer front corner; the inner one by the body beside the rear axle, and at the far end by
    the side of the body up to its front corner.
    """
    curvature = tan(road_wheel_angle_rad) / car.wheelbase_m
    end_m = max(begin_m, min(end_m, _TURN_MAX_RAD / max(abs(curvature), 1e-6)))
    poses = [moved(begin, way, curvature) for way in _ways(begin_m, end_m, curvature)]
    front_m, half_m = car.length_m - car.rear_overhang_m, car.width_m / 2
    inner = 1.0 if curvature >= 0 else -1.0
    swept = tuple(beside(pose, 0.0, inner * half_m) for pose in poses) + (beside(poses[-1], front_m, inner * half_m),)
    outer = tuple(beside(pose, front_m, -inner * half_m) for pose in poses)
    return Strip(left=swept, right=outer) if inner > 0 else Strip(left=outer, right=swept)


def _ways(begin_m: float, end_m: float, curvature_1_m: float) -> list[float]:
    """Distances of travel at which an edge has a point, both ends among them."""
    longest = max((8 * _SAGITTA_M / max(abs(curvature_1_m), _STRAIGHT_1_M)) ** 0.5, _STEP_M / 2)
    ways = [begin_m]
    while ways[-1] < end_m:
        step = min(max(_STEP_M, _STEP_SHARE * (ways[-1] - begin_m)), longest)
        ways.append(end_m if ways[-1] + 1.3 * step >= end_m else ways[-1] + step)
    return ways


def beside(pose: Pose, ahead_m: float, left_m: float) -> XY:
    c, s = cos(pose.heading_rad), sin(pose.heading_rad)
    return pose.x_m + ahead_m * c - left_m * s, pose.y_m + ahead_m * s + left_m * c


def ribbon(middle: Sequence[XY], width_m: float) -> Strip | None:
    """A strip of constant width along a line of points; None with fewer than two."""
    if len(middle) < 2:
        return None
    left, right = [], []
    for i, (x, y) in enumerate(middle):
        before, after = middle[max(i - 1, 0)], middle[min(i + 1, len(middle) - 1)]
        pose = Pose(x, y, atan2(after[1] - before[1], after[0] - before[0]))
        left.append(beside(pose, 0.0, width_m / 2))
        right.append(beside(pose, 0.0, -width_m / 2))
    return Strip(left=tuple(left), right=tuple(right))


def stopping_distance_m(speed_m_s: float, braking_m_s2: float, jerk_m_s3: float) -> float:
    """To standstill, braking that builds up with constant jerk; the reaction is in the predicted pose already.

    Formula: v t - j t^3 / 6 + v_j^2 / (2 b), with t = b / j and v_j = v - b t / 2; or, where the car stands before the braking
    has built up, (2/3) v sqrt(2 v / j).
    """
    speed, build_s = abs(speed_m_s), braking_m_s2 / jerk_m_s3
    after = speed - braking_m_s2 * build_s / 2
    if after <= 0.0:
        return float(speed * (2 * speed / jerk_m_s3) ** 0.5 * 2 / 3)
    return speed * build_s - jerk_m_s3 * build_s**3 / 6 + after**2 / (2 * braking_m_s2)


def in_car_frame(point: XY, x_m: float, y_m: float, heading_rad: float) -> XY:
    """A point of the map frame as the car at that pose sees it."""
    dx, dy, c, s = point[0] - x_m, point[1] - y_m, cos(heading_rad), sin(heading_rad)
    return dx * c + dy * s, dy * c - dx * s
