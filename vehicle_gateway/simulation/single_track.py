"""The simulated car's motion in the plane: a nonlinear single-track model with Fiala tyres. Pure, plain floats, 1 kHz.

Slip-driven above 3 m/s, kinematic below 1 m/s, a smooth blend of the two derivatives between; with the brakes on it
stands still exactly. Load moves between the axles with acceleration, the brakes share their force as the axles are
loaded (electronic distribution); drive (front) and brakes use up the friction circle. Not modelled: left-right load
transfer, wheel spin and lock (a demand beyond the grip is cut to it), aerodynamic lift, tyre relaxation.
Source: Rajamani, Vehicle Dynamics and Control (2012), ch. 2 and 13 (Fiala); Pacejka, Tire and Vehicle Dynamics, ch. 3.
Frame: ISO 8855. The pose is the rear axle's; vx, vy are those of the centre of gravity.
"""

from math import atan2, copysign, cos, sin, sqrt, tan
from typing import Annotated, NamedTuple

from msgspec import Meta

from wire.messages.base import Message

GRAVITY_M_S2 = 9.81
KINEMATIC_BELOW_M_S = 1.0  # slip angles say nothing at walking pace
DYNAMIC_ABOVE_M_S = 3.0  # the fastest lateral mode at 3 m/s decays with about 40/s: 1 ms explicit steps are stable
KINEMATIC_LAG_S = 0.03  # with which lateral speed and yaw rate follow the geometry at walking pace

Positive = Annotated[float, Meta(gt=0.0, le=1e6)]


class ChassisParameters(Message):
    """A compact car of 1450 kg. Mass, wheelbase and outline come from [vehicle]."""

    front_share: Annotated[float, Meta(gt=0.2, lt=0.8)] = 0.55  # of the weight, at rest
    yaw_inertia_kg_m2: Positive = 2200.0
    gravity_height_m: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.55
    front_stiffness_n_rad: Positive = 95000.0  # cornering stiffness of both tyres of the axle
    rear_stiffness_n_rad: Positive = 105000.0
    friction: Annotated[float, Meta(gt=0.0, le=1.2)] = 0.9  # dry asphalt
    rolling_resistance: Annotated[float, Meta(ge=0.0, le=0.1)] = 0.012  # share of the weight
    drag_kg_m: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.42  # 0.5 * air density * drag coefficient * area
    slope_rad: Annotated[float, Meta(ge=-0.3, le=0.3)] = 0.0  # of the ground, uphill positive, whatever the heading


class Chassis(NamedTuple):
    """Parameters as the integration wants them. See `chassis`."""

    mass_kg: float
    yaw_inertia_kg_m2: float
    front_m: float  # centre of gravity to front axle
    rear_m: float
    gravity_height_m: float
    front_stiffness_n_rad: float
    rear_stiffness_n_rad: float
    friction: float
    rolling_n: float
    drag_kg_m: float
    slope_n: float  # force along x, uphill is negative


class Body(NamedTuple):
    """State of the chassis."""

    x_m: float = 0.0  # rear axle, map frame
    y_m: float = 0.0
    heading_rad: float = 0.0
    vx_m_s: float = 0.0  # forward
    vy_m_s: float = 0.0  # of the centre of gravity, left positive
    yaw_rate_rad_s: float = 0.0
    forward_m_s2: float = 0.0  # d(vx)/dt of the last step
    ax_m_s2: float = 0.0  # acceleration of the rear axle over ground in the last step, along x
    ay_m_s2: float = 0.0  # the same, along y


def chassis(parameters: ChassisParameters, mass_kg: float, wheelbase_m: float) -> Chassis:
    return Chassis(
        mass_kg=mass_kg,
        yaw_inertia_kg_m2=parameters.yaw_inertia_kg_m2,
        front_m=wheelbase_m * (1 - parameters.front_share),
        rear_m=wheelbase_m * parameters.front_share,
        gravity_height_m=parameters.gravity_height_m,
        front_stiffness_n_rad=parameters.front_stiffness_n_rad,
        rear_stiffness_n_rad=parameters.rear_stiffness_n_rad,
        friction=parameters.friction,
        rolling_n=parameters.rolling_resistance * mass_kg * GRAVITY_M_S2 * cos(parameters.slope_rad),
        drag_kg_m=parameters.drag_kg_m,
        slope_n=-mass_kg * GRAVITY_M_S2 * sin(parameters.slope_rad),
    )


def on_slope(c: Chassis, slope_rad: float) -> Chassis:
    """The same chassis on ground that rises along the car by so much more; rolling resistance stays as it was (cos 0.3 = 0.96)."""
    return c._replace(slope_n=c.slope_n - c.mass_kg * GRAVITY_M_S2 * sin(slope_rad)) if slope_rad else c


def fiala(slip_angle_rad: float, stiffness_n_rad: float, grip_n: float) -> float:
    """Lateral force of an axle [N], same sign as the slip angle.

    grip_n  what friction leaves for the lateral direction, > 0
    """
    t = tan(slip_angle_rad)
    sliding = 3.0 * grip_n / stiffness_n_rad  # tan of the angle from which the whole contact patch slides
    if abs(t) >= sliding:
        return copysign(grip_n, t)
    share = t / sliding
    return 3.0 * grip_n * share * (1.0 - abs(share) + share * share / 3.0)


def step_body(body: Body, road_wheel_angle_rad: float, drive_n: float, brake_n: float, dt_s: float, c: Chassis) -> Body:
    """The state dt_s later (explicit Euler; made for 1 ms).

    drive_n  force at the front wheels, forward positive
    brake_n  >= 0, against whatever motion there is
    """
    x, y, heading, vx, vy, r, forward, _, _ = body
    load_f, load_r = _axle_loads(forward, c)
    braking = min(brake_n / (load_f + load_r), c.friction)  # of the load, the same on both axles
    brake_f, brake_r = braking * load_f, braking * load_r
    drive = min(max(drive_n, -c.friction * load_f), c.friction * load_f)
    moving = copysign(1.0, vx) if vx != 0.0 else 0.0

    # Lateral: slip forces, blended with the kinematic car at walking pace.
    weight = _dynamic_weight(abs(vx))
    lateral_f = lateral_r = 0.0
    slope = tan(road_wheel_angle_rad)
    geometric_r = vx * slope / (c.front_m + c.rear_m)
    vy_rate = (geometric_r * c.rear_m - vy) / KINEMATIC_LAG_S
    r_rate = (geometric_r - r) / KINEMATIC_LAG_S
    cos_d, sin_d = cos(road_wheel_angle_rad), sin(road_wheel_angle_rad)
    if weight > 0.0:
        # Travelling backwards mirrors the slip angle: the wheel's own speed is in front of the patch.
        slip_f = moving * road_wheel_angle_rad - atan2(vy + c.front_m * r, abs(vx))
        slip_r = -atan2(vy - c.rear_m * r, abs(vx))
        lateral_f = fiala(slip_f, c.front_stiffness_n_rad, _left_over(c.friction * load_f, drive - moving * brake_f))
        lateral_r = fiala(slip_r, c.rear_stiffness_n_rad, _left_over(c.friction * load_r, brake_r))
        dynamic_vy = (lateral_f * cos_d + (drive - moving * brake_f) * sin_d + lateral_r) / c.mass_kg - vx * r
        dynamic_r = (
            c.front_m * (lateral_f * cos_d + (drive - moving * brake_f) * sin_d) - c.rear_m * lateral_r
        ) / c.yaw_inertia_kg_m2
        vy_rate += weight * (dynamic_vy - vy_rate)
        r_rate += weight * (dynamic_r - r_rate)

    # Longitudinal: what pushes, then what resists; resistance never turns the car round, so it can stand still.
    pushing = drive * cos_d + c.slope_n - weight * lateral_f * sin_d - c.drag_kg_m * vx * abs(vx)
    vx_pushed = vx + (pushing / c.mass_kg + weight * vy * r) * dt_s
    resisting = (brake_f + brake_r + c.rolling_n) / c.mass_kg * dt_s
    vx_next = 0.0 if abs(vx_pushed) <= resisting else vx_pushed - copysign(resisting, vx_pushed)
    vy_next, r_next = vy + vy_rate * dt_s, r + r_rate * dt_s
    if vx_next == 0.0 and vx == 0.0:
        vy_next = r_next = 0.0

    forward = (vx_next - vx) / dt_s
    rear_vy = vy - c.rear_m * r
    cos_h, sin_h = cos(heading), sin(heading)
    return Body(
        x + (vx * cos_h - rear_vy * sin_h) * dt_s,
        y + (vx * sin_h + rear_vy * cos_h) * dt_s,
        heading + r * dt_s,
        vx_next,
        vy_next,
        r_next,
        forward,
        forward - rear_vy * r,
        (vy_next - vy - c.rear_m * (r_next - r)) / dt_s + vx * r,
    )


def _axle_loads(forward_m_s2: float, c: Chassis) -> tuple[float, float]:
    """Vertical forces front and rear [N]; neither axle ever lifts off wholly."""
    wheelbase = c.front_m + c.rear_m
    weight = c.mass_kg * GRAVITY_M_S2
    moved = c.mass_kg * forward_m_s2 * c.gravity_height_m / wheelbase
    front = min(max(weight * c.rear_m / wheelbase - moved, 0.05 * weight), 0.95 * weight)
    return front, weight - front


def _left_over(grip_n: float, longitudinal_n: float) -> float:
    """What the friction circle leaves for the lateral direction; a tenth always stays, a locked wheel still scrubs."""
    return sqrt(max(grip_n * grip_n - longitudinal_n * longitudinal_n, 0.01 * grip_n * grip_n))


def _dynamic_weight(speed_m_s: float) -> float:
    """0 for the kinematic car, 1 for the dynamic one; smooth in between (cubic)."""
    if speed_m_s <= KINEMATIC_BELOW_M_S:
        return 0.0
    s = min((speed_m_s - KINEMATIC_BELOW_M_S) / (DYNAMIC_ABOVE_M_S - KINEMATIC_BELOW_M_S), 1.0)
    return s * s * (3.0 - 2.0 * s)
