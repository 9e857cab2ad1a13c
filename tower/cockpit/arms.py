"""Arms on a steering wheel: they turn it towards an angle they have in mind, with the strength and speed of a person. Pure."""

from typing import Annotated

from msgspec import Meta

from haptics.torque import clamp
from haptics.virtual_wheel import VirtualWheel
from wire.messages.base import Message


class ArmsSettings(Message):
    torque_max_nm: Annotated[float, Meta(gt=0.0, le=20.0)] = 3.0  # at ease, both hands
    stiffness_nm_rad: Annotated[float, Meta(gt=0.0, le=100.0)] = 12.0
    damping_nm_s: Annotated[float, Meta(ge=0.0, le=10.0)] = 0.9  # about 0.7 of critical with 0.035 kg m2
    rate_max_rad_s: Annotated[float, Meta(gt=0.0, le=20.0)] = 6.0  # 340 deg/s: hand over hand, not in alarm


def moved_target(target_rad: float, wanted_rad: float, dt_s: float, settings: ArmsSettings) -> float:
    """The angle in mind, one tick later: it moves no faster than arms do."""
    return target_rad + clamp(wanted_rad - target_rad, settings.rate_max_rad_s * dt_s)


def arms_torque_nm(wheel: VirtualWheel, target_rad: float, settings: ArmsSettings) -> float:
    return clamp(
        settings.stiffness_nm_rad * (target_rad - wheel.angle_rad) - settings.damping_nm_s * wheel.rate_rad_s,
        settings.torque_max_nm,
    )
