"""A steering wheel that is not there: inertia, bearing friction, hard stops; turned by its motor and by somebody's arms.

Used by every device without a wheel of its own (keyboard, scripted operator). Semi-implicit Euler, steps of about 4 ms.
Does not model: play, the elasticity of the rim, cogging and saturation of the motor.
"""

from dataclasses import dataclass
from math import tanh
from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message


class VirtualWheelSettings(Message):
    inertia_kg_m2: Annotated[float, Meta(gt=0.005, le=1.0)] = 0.035  # rim and gear train of a consumer wheel
    viscous_nm_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.02
    coulomb_nm: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.05
    coulomb_rate_rad_s: Annotated[float, Meta(gt=0.01, le=1.0)] = 0.05  # width of the smoothed sign function
    motor_max_nm: Annotated[float, Meta(gt=0.0, le=30.0)] = 2.2  # at a normalised torque of 1: the class of a G920


@dataclass(frozen=True, slots=True)
class VirtualWheel:
    angle_rad: float = 0.0  # at the steering wheel, left positive
    rate_rad_s: float = 0.0


def turned(
    wheel: VirtualWheel, torque: float, arms_nm: float, lock_rad: float, dt_s: float, settings: VirtualWheelSettings
) -> VirtualWheel:
    """The wheel after dt_s.

    torque   of the motor, normalised to [-1, 1]
    arms_nm  of whoever holds the rim; 0: hands off
    """
    drive_nm = torque * settings.motor_max_nm + arms_nm
    # viscous friction implicitly: stable for every dt; Coulomb friction may stop the wheel but never turn it
    free = (wheel.rate_rad_s + drive_nm * dt_s / settings.inertia_kg_m2) / (
        1.0 + settings.viscous_nm_s * dt_s / settings.inertia_kg_m2
    )
    drag = settings.coulomb_nm * abs(tanh(free / settings.coulomb_rate_rad_s)) * dt_s / settings.inertia_kg_m2
    rate = max(abs(free) - drag, 0.0) * (1.0 if free >= 0 else -1.0)
    angle = wheel.angle_rad + rate * dt_s
    if abs(angle) >= lock_rad:
        return VirtualWheel(lock_rad if angle > 0 else -lock_rad, 0.0)
    return VirtualWheel(angle, rate)
