"""From a planned way to the car's command: the tracker, given what the stack has measured, at the stamp of the cycle. Pure."""

from autonomy.control.mpcc.reference import Reference
from autonomy.control.mpcc.state import Measured, Setup, Tracked, TrackerState
from autonomy.control.mpcc.tracker import track
from autonomy.inputs import Inputs
from autonomy.localization.ekf import Pose


def follow(
    state: TrackerState,
    pose: Pose,
    inputs: Inputs,
    reference: Reference | None,
    now_ns: int,
    setup: Setup,
    most_m_s2: float,
) -> tuple[TrackerState, Tracked]:
    """reference None: no way to follow, it brakes. pose: the rear axle now. most_m_s2: of the acceleration."""
    return track(state, measured(pose, inputs, now_ns), reference, now_ns, setup, most_m_s2)


def measured(pose: Pose, inputs: Inputs, now_ns: int) -> Measured | None:
    """None before every sensor has spoken. Wheels and acceleration are at most one message of theirs old."""
    if inputs.wheels is None or inputs.imu is None:
        return None
    return Measured(
        stamp_ns=now_ns,
        x_m=pose.x_m,
        y_m=pose.y_m,
        heading_rad=pose.heading_rad,
        speed_m_s=pose.speed_m_s,
        yaw_rate_rad_s=pose.yaw_rate_rad_s,
        road_wheel_angle_rad=inputs.wheels.road_wheel_angle_rad,
        acceleration_m_s2=inputs.imu.acceleration_x_m_s2,
    )
