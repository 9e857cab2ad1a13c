"""The torque law as effects of a real wheel: what its firmware renders by itself, and the rest as one constant force. Pure.

A spring or a damper in the firmware has no delay, so the wheel gets as much of the law as it can render; what is left of it is
sent as a constant force. A wheel that knows only constant forces (G29 in the kernel's own driver) gets the whole law that way.
The sum of the parts is the law of haptics.torque and haptics.alignment but for bearing friction: a real wheel has its own.
Source: Linux Documentation/input/ff.rst and input.h; what a firmware makes of a damper's full coefficient is nowhere written
(`full_damper_s` is an assumption), of a spring's: full force at full deflection, as DirectInput defines it.
"""

from dataclasses import dataclass, replace
from typing import Annotated

from msgspec import Meta

from haptics.alignment import Phase, WheelInputs, WheelLimits, WheelState, is_fresh, ramp
from haptics.torque import TorqueSettings, clamp, damping_s, end_stop_torque, lateral_torque, limited, spring_torque_max
from wire.messages.base import Message, Ratio

CENTRE_JUMP_RAD = 0.1  # a spring whose centre jumps farther begins again from no force


class ForceFeedbackSettings(Message):
    gain: Ratio = 1.0  # FF_GAIN: of everything the wheel renders
    full_damper_s: Annotated[float, Meta(gt=0.0, le=5.0)] = 0.5  # per rad/s at the full coefficient: assumed, not measured
    uploads_max_1_s: Annotated[float, Meta(ge=1.0, le=100.0)] = 100.0  # in total: each waits in an unbounded queue of the kernel


@dataclass(frozen=True, slots=True, kw_only=True)
class Abilities:
    """What the wheel said it can do. Probed, never assumed."""

    constant: bool = False
    spring: bool = False
    damper: bool = False
    half_range_rad: float = 7.85  # from the middle to the end


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """What the wheel should render, normalised; left positive."""

    spring: float = 0.0  # coefficient, 1: full force at full deflection
    spring_max: float = 0.0  # saturation
    centre: float = 0.0  # of the half range
    damper: float = 0.0  # coefficient
    constant: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Law:
    """The torque law as a spring, a damper and a rest, all normalised torques."""

    stiffness_1_rad: float = 0.0
    spring_max: float = 0.0
    centre_rad: float = 0.0
    damping_s: float
    rest: float
    torque_max: float


def law(state: WheelState, seen: WheelInputs, now_ns: int, limits: WheelLimits) -> Law:
    """The parts of haptics.alignment.wanted_torque, without friction and before slew."""
    torque = limits.torque
    if state.phase is Phase.ACTIVE:
        spring = spring_torque_max(seen.speed_m_s, torque)
        return Law(
            stiffness_1_rad=spring / torque.spring_saturation_rad,
            spring_max=spring,
            damping_s=damping_s(seen.speed_m_s, torque),
            rest=end_stop_torque(seen.angle_rad, seen.lock_rad, torque) + lateral_torque(state.lateral_m_s2, torque),
            torque_max=torque.torque_max,
        )
    if state.phase in (Phase.ALIGN, Phase.READY) and is_fresh(seen, limits.alignment):
        pull = ramp(state, now_ns, limits.alignment)
        return Law(
            stiffness_1_rad=limits.alignment.stiffness_1_rad * pull,
            spring_max=limits.alignment.torque_max * pull,
            centre_rad=state.centre_rad,
            damping_s=limits.alignment.damping_s,
            rest=limits.alignment.damping_s * state.centre_rate_rad_s,
            torque_max=limits.alignment.torque_max,
        )
    rest = end_stop_torque(seen.angle_rad, seen.lock_rad, torque)
    return Law(damping_s=damping_s(seen.speed_m_s, torque), rest=rest, torque_max=torque.torque_max)


def effects(
    previous: Effects,
    wanted: Law,
    seen: WheelInputs,
    dt_s: float,
    can: Abilities,
    torque: TorqueSettings,
    settings: ForceFeedbackSettings,
) -> Effects:
    """The effects a tick later: no part of them grows faster than the slew limit, and together they stay below the law's limit."""
    share = min(1.0 / max(wanted.stiffness_1_rad * can.half_range_rad, 1e-9), 1.0) if can.spring else 0.0
    damper = min(wanted.damping_s / settings.full_damper_s, 1.0) if can.damper else 0.0
    spring = clamp(wanted.stiffness_1_rad * (wanted.centre_rad - seen.angle_rad), wanted.spring_max)
    damping = -(wanted.damping_s - damper * settings.full_damper_s) * seen.rate_rad_s
    room = wanted.torque_max - share * wanted.spring_max  # what a firmware stiffer than assumed could add is taken off beforehand
    constant = clamp(spring * (1.0 - share) + damping + wanted.rest, max(room, 0.0)) if can.constant else 0.0
    return Effects(
        spring=wanted.stiffness_1_rad * share * can.half_range_rad,
        spring_max=_slewed_spring(previous, share * wanted.spring_max, wanted.centre_rad, dt_s, can, torque),
        centre=clamp(wanted.centre_rad / can.half_range_rad, 1.0),
        damper=damper,
        constant=limited(constant, previous.constant, dt_s, torque),
    )


def _slewed_spring(
    previous: Effects, wanted_max: float, centre_rad: float, dt_s: float, can: Abilities, torque: TorqueSettings
) -> float:
    jumped = abs(centre_rad - previous.centre * can.half_range_rad) > CENTRE_JUMP_RAD
    return limited(wanted_max, 0.0 if jumped else previous.spring_max, dt_s, torque)


def silent(can: Abilities) -> Effects:
    """Nothing pulls; a wheel with a damper keeps a little of it, so that it does not swing when it is let go."""
    return replace(Effects(), damper=0.2 if can.damper else 0.0)
