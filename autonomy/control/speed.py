"""Longitudinal control: keep to the plan's ceiling, with its slope as feed-forward, limited in jerk. Pure, 100 Hz.

Comfort bounds the jerk of starting and of gentle braking; firm braking is built up fast, because late braking is what
would make it firmer still. At standstill the brakes are closed softly and held.
"""

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from autonomy.control.steering import toward
from autonomy.planning.speed_limits import Ceiling
from wire.messages.base import Message

Positive = Annotated[float, Meta(gt=0.0, le=50.0)]
WALKING_M_S = 2.0
ROLLS_M_S = 0.02


class SpeedSettings(Message):
    gain_1_s: Positive = 1.0
    integral_1_s2: Positive = 0.15
    integral_max_m_s2: Positive = 0.4
    preview_s: Positive = 0.5  # command to effect, jerk included: the ceiling is read where the car will be by then
    start_m_s2: Positive = 1.2
    brake_max_m_s2: Positive = 8.0
    jerk_m_s3: Positive = 2.0
    firm_from_m_s2: Positive = 1.8
    firm_jerk_m_s3: Positive = 20.0  # as soon as more than firm_from is asked for
    emergency_from_m_s2: Positive = 4.5  # only ever asked for to avoid a person
    emergency_jerk_m_s3: Annotated[float, Meta(gt=0.0, le=200.0)] = 100.0  # electro-hydraulic brakes build up in 0.1 s
    near_m_s: Positive = 0.6  # this close under the ceiling its slope counts in full at 0
    stand_m_s: Positive = 0.45  # both the ceiling and the car slower than this: it stands, or is about to
    go_m_s: Positive = 0.8  # from there it goes on only for a ceiling above this: no creeping after a breath of noise
    settle_m_s2: Positive = 0.35  # while it still rolls then
    hold_m_s2: Positive = 0.8  # at standstill


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedState:
    acceleration_m_s2: float = 0.0  # commanded last
    integral_m_s2: float = 0.0
    standing: bool = False


def preview_m(state: SpeedState, speed_m_s: float, settings: SpeedSettings) -> float:
    """How far ahead the ceiling is read. A car that still accelerates needs the time to let go of that first."""
    letting_go_s = max(state.acceleration_m_s2, 0.0) / settings.jerk_m_s3
    walking = min(max(speed_m_s, 0.0) / WALKING_M_S, 1.0)  # at the end of a stop a preview would only make it creep
    return max(speed_m_s, 0.0) * (settings.preview_s + letting_go_s) * walking


def wanted_acceleration(
    state: SpeedState, speed_m_s: float, ceiling: Ceiling, driving: bool, dt_s: float, settings: SpeedSettings
) -> SpeedState:
    """The next command. driving False (somebody else drives): what the first command would be, no memory kept."""
    needed = settings.go_m_s if state.standing else settings.stand_m_s
    standing = ceiling.speed_m_s < needed and speed_m_s < settings.stand_m_s
    if standing:
        target, integral = -(settings.settle_m_s2 if speed_m_s > ROLLS_M_S else settings.hold_m_s2), 0.0
    else:
        error = ceiling.speed_m_s - speed_m_s
        near = min(max(1.0 - error / settings.near_m_s, 0.0), 1.0)
        integral = _integral(state, error, near, dt_s, settings)
        target = settings.gain_1_s * error + near * ceiling.slope_m_s2 + integral
    target = min(max(target, -settings.brake_max_m_s2), settings.start_m_s2)
    jerk = _jerk(min(target, state.acceleration_m_s2), settings)
    if not driving:
        return SpeedState(acceleration_m_s2=toward(0.0, target, jerk * dt_s), standing=standing)
    return SpeedState(
        acceleration_m_s2=toward(state.acceleration_m_s2, target, jerk * dt_s), integral_m_s2=integral, standing=standing
    )


def _jerk(target_m_s2: float, settings: SpeedSettings) -> float:
    """By the firmer of what is asked for and what is on: brakes let go as fast as they came."""
    if target_m_s2 < -settings.emergency_from_m_s2:
        return settings.emergency_jerk_m_s3
    return settings.firm_jerk_m_s3 if target_m_s2 < -settings.firm_from_m_s2 else settings.jerk_m_s3


def _integral(state: SpeedState, error_m_s: float, near: float, dt_s: float, settings: SpeedSettings) -> float:
    """Collects only close to the ceiling: what is missing on the way up to it is no disturbance."""
    if near == 0.0:
        return 0.0
    grown = state.integral_m_s2 + settings.integral_1_s2 * error_m_s * dt_s
    return min(max(grown, -settings.integral_max_m_s2), settings.integral_max_m_s2)
