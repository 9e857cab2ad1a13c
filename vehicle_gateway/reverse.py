"""Driving backwards: only with a fresh picture to the rear, never faster than 5 km/h. Pure. Source: architecture.md, "Failsafe"."""

from msgspec.structs import replace

from vehicle_gateway.state import GatewayLimits, State
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation
from wire.rear_view import REAR

SPEED_MAX_M_S = 5 / 3.6
RULE = "reverse without rear picture"


def sees_rear(state: State, now_ns: int, limits: GatewayLimits) -> bool:
    """Whether the operator has a fresh, live picture of what lies behind the car."""
    picture, camera = state.pictures.get(REAR), state.cameras.get(REAR)
    fresh = picture is not None and (now_ns - picture.advanced_ns) / 1e6 <= limits.failsafe.picture_lost_ms
    return fresh and camera is not None and camera.live


def check_reverse(asked: Actuation, state: State, now_ns: int, limits: GatewayLimits) -> tuple[Actuation, tuple[str, ...]]:
    """What may be asked for, and the rule if it was changed: blind, a moving car brakes gently, a standing one stays in drive."""
    if asked.gear is not Gear.REVERSE or sees_rear(state, now_ns, limits):
        return asked, ()
    speed_m_s = state.feedback.speed_m_s if state.feedback else 0.0
    gear = state.applied.gear if abs(speed_m_s) >= limits.gate.reverse_shift_speed_m_s else Gear.DRIVE
    braking = min(asked.acceleration_m_s2, limits.failsafe.gentle_braking_m_s2)
    return replace(asked, gear=gear, acceleration_m_s2=braking), (RULE,)
