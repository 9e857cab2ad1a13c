"""Steering feel: the torque of the operator's wheel, normalised to [-1, 1] (positive turns the wheel left).

tau = -k(v) sat(delta / delta_s) - b(v) d(delta)/dt - c tanh(d(delta)/dt / w0) - end stop - lateral acceleration.
delta is the LOCAL wheel angle: a torque computed from the delayed state of the car oscillates (a spring on theta(t - T) needs
damping above stiffness * T), so what the car says only moves slow parameters. Never raises torque faster than the slew limit.
Source: our reference measurements and simulation of delayed torque laws, J = 0.035 kg m2, delays 50..200 ms.
"""

from math import tanh
from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message

Coefficient = Annotated[float, Meta(ge=0.0, le=2.0)]


class TorqueSettings(Message):
    torque_max: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.6  # of the wheel's own maximum: a person can always overpower it
    slew_max_1_s: Annotated[float, Meta(gt=0.0, le=10.0)] = 2.0
    spring_at_rest: Coefficient = 0.1  # k at standstill
    spring_at_speed: Coefficient = 0.5  # k from spring_full_speed_m_s on
    spring_full_speed_m_s: Annotated[float, Meta(gt=0.0, le=40.0)] = 8.33  # 30 km/h, the cap of remote driving
    spring_saturation_rad: Annotated[float, Meta(gt=0.0, le=10.0)] = 2.1  # delta_s, 120 deg at the steering wheel
    damping_at_rest_s: Coefficient = 0.06  # b, per rad/s
    damping_at_speed_s: Coefficient = 0.12
    friction: Coefficient = 0.03  # c
    friction_rate_rad_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.2  # w0
    end_stop_rad: Annotated[float, Meta(gt=0.0, le=2.0)] = 0.35  # the stop is felt from 20 deg before lock
    lateral_gain_s2_m: Annotated[float, Meta(ge=0.0, le=0.1)] = 0.02  # per m/s2 of low-passed lateral acceleration
    lateral_max: Annotated[float, Meta(ge=0.0, le=0.2)] = 0.06  # small: it comes delayed
    lateral_time_constant_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.5


def steering_torque(
    angle_rad: float, rate_rad_s: float, speed_m_s: float, lateral_m_s2: float, lock_rad: float, settings: TorqueSettings
) -> float:
    """Wanted torque, not yet limited: see `limited`.

    angle_rad, rate_rad_s  of the steering wheel, local, left positive
    lateral_m_s2           low-passed lateral acceleration of the car, left positive
    lock_rad               steering wheel angle at which the road wheels reach their end
    """
    return (
        -spring_torque_max(speed_m_s, settings) * clamp(angle_rad / settings.spring_saturation_rad, 1.0)
        + damping_torque(rate_rad_s, speed_m_s, settings)
        + end_stop_torque(angle_rad, lock_rad, settings)
        + lateral_torque(lateral_m_s2, settings)
    )


def spring_torque_max(speed_m_s: float, settings: TorqueSettings) -> float:
    """k(v): what the centring spring pulls with beyond spring_saturation_rad."""
    return _between(settings.spring_at_rest, settings.spring_at_speed, _speed_share(speed_m_s, settings))


def lateral_torque(lateral_m_s2: float, settings: TorqueSettings) -> float:
    return -clamp(settings.lateral_gain_s2_m * lateral_m_s2, settings.lateral_max)


def damping_torque(rate_rad_s: float, speed_m_s: float, settings: TorqueSettings) -> float:
    """Damping and friction alone: what stays when nothing may pull the wheel."""
    friction = settings.friction * tanh(rate_rad_s / settings.friction_rate_rad_s)
    return -damping_s(speed_m_s, settings) * rate_rad_s - friction


def damping_s(speed_m_s: float, settings: TorqueSettings) -> float:
    """b(v): torque per rad/s."""
    return _between(settings.damping_at_rest_s, settings.damping_at_speed_s, _speed_share(speed_m_s, settings))


def end_stop_torque(angle_rad: float, lock_rad: float, settings: TorqueSettings) -> float:
    """Rises from 0 at end_stop_rad before lock to torque_max at lock, towards the middle."""
    over = max(abs(angle_rad) - (lock_rad - settings.end_stop_rad), 0.0) / settings.end_stop_rad
    return -settings.torque_max * min(over, 1.0) * (1.0 if angle_rad > 0 else -1.0)


def limited(wanted: float, previous: float, dt_s: float, settings: TorqueSettings) -> float:
    """The torque that may go to the wheel: within +-torque_max, and no step above slew_max * dt."""
    step = settings.slew_max_1_s * dt_s
    return clamp(min(max(clamp(wanted, settings.torque_max), previous - step), previous + step), settings.torque_max)


def low_passed(state: float, value: float, dt_s: float, time_constant_s: float) -> float:
    """First-order low-pass, exact for a constant input over dt and never overshooting."""
    return state + (value - state) * dt_s / (time_constant_s + dt_s)


def clamp(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


def _speed_share(speed_m_s: float, settings: TorqueSettings) -> float:
    return min(abs(speed_m_s) / settings.spring_full_speed_m_s, 1.0)


def _between(at_zero: float, at_one: float, share: float) -> float:
    return at_zero + (at_one - at_zero) * share
