"""Pedals to acceleration: dead zone, curve, brake over throttle, and the arming gate. Pure.

Acceleration is along the selected gear: positive drives, negative brakes. A released throttle is a gentle engine braking,
which also holds the car at standstill. Never lets a throttle through that was not seen released first: before its first report
a pedal's axis may read anything (the kernel's 0 on an inverted axis is full throttle). A wheel must have said where it stands.
"""

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from tower.cockpit.devices import Controls
from wire.messages.base import Message


class PedalSettings(Message):
    dead_zone: Annotated[float, Meta(ge=0.0, le=0.3)] = 0.04  # of the travel; a released pedal rattles this much
    throttle_exponent: Annotated[float, Meta(ge=1.0, le=3.0)] = 1.5  # finer at the beginning of the travel
    brake_exponent: Annotated[float, Meta(ge=1.0, le=3.0)] = 1.2
    engine_braking_m_s2: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.5
    braking_max_m_s2: Annotated[float, Meta(ge=1.0, le=10.0)] = 6.0  # pedal fully down
    released_below: Annotated[float, Meta(ge=0.0, le=0.3)] = 0.05  # counts as released for the arming gate


@dataclass(frozen=True, slots=True)
class Arming:
    throttle_seen_released: bool = False
    brake_seen_released: bool = False
    wheel_reported: bool = True

    @property
    def armed(self) -> bool:
        return self.throttle_seen_released and self.brake_seen_released and self.wheel_reported

    @property
    def missing(self) -> str:
        """What is still to be done, in words; "" when armed."""
        if not self.wheel_reported:
            return "Turn the wheel a little"
        both = not self.throttle_seen_released and not self.brake_seen_released
        which = "both pedals" if both else "the throttle" if not self.throttle_seen_released else "the brake"
        return "" if self.armed else f"Press and release {which} once"


def arm(state: Arming, controls: Controls, reset: bool, settings: PedalSettings) -> Arming:
    """Each pedal must have reported AND have been seen released; a real wheel must have reported.

    reset  the car was stopped, or the device is another or was plugged in again: what was seen before counts no more
    """
    before = Arming() if reset else state
    limit = settings.released_below
    return Arming(
        before.throttle_seen_released or (controls.throttle_reported and controls.throttle <= limit),
        before.brake_seen_released or (controls.brake_reported and controls.brake <= limit),
        controls.wheel_reported,
    )


def acceleration_m_s2(throttle: float, brake: float, traction_max_m_s2: float, settings: PedalSettings) -> float:
    """Wanted acceleration of pedal positions in 0..1. The brake wins: with it pressed the throttle does nothing."""
    braking = _shaped(brake, settings.dead_zone, settings.brake_exponent)
    if braking > 0.0:
        return min(-settings.braking_max_m_s2 * braking, -settings.engine_braking_m_s2)
    share = _shaped(throttle, settings.dead_zone, settings.throttle_exponent)
    return -settings.engine_braking_m_s2 + (traction_max_m_s2 + settings.engine_braking_m_s2) * share


def pedals_for(wanted_m_s2: float, traction_max_m_s2: float, settings: PedalSettings) -> tuple[float, float]:
    """(throttle, brake) that give the wanted acceleration: what a practised foot knows."""
    if wanted_m_s2 < -settings.engine_braking_m_s2:
        return 0.0, _travel(-wanted_m_s2 / settings.braking_max_m_s2, settings.dead_zone, settings.brake_exponent)
    share = (wanted_m_s2 + settings.engine_braking_m_s2) / (traction_max_m_s2 + settings.engine_braking_m_s2)
    return _travel(share, settings.dead_zone, settings.throttle_exponent), 0.0


def _shaped(travel: float, dead_zone: float, exponent: float) -> float:
    return float(min(max((travel - dead_zone) / (1.0 - dead_zone), 0.0), 1.0) ** exponent)


def _travel(share: float, dead_zone: float, exponent: float) -> float:
    within = min(max(share, 0.0), 1.0)
    return dead_zone + (1.0 - dead_zone) * float(within ** (1.0 / exponent)) if within > 0.0 else 0.0
