"""Hand-over of the wheel: it turns to the car's angle before control passes, and lets go without a jerk afterwards. Pure.

IDLE -> ALIGN (a spring whose centre walks to the car's angle, torque ramped in) -> READY (aligned for a while, pedals armed,
telemetry fresh) -> ACTIVE (steering feel; what is left of the misalignment is blended out of the command) -> RELEASE -> IDLE.
Never decides who drives: `driving` comes from the car. Stale telemetry removes the aligning torque and keeps the damping.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated

from msgspec import Meta, Struct
from msgspec.structs import replace

from haptics.torque import TorqueSettings, clamp, damping_torque, end_stop_torque, limited, low_passed, steering_torque
from wire.messages.base import Message, Milliseconds, Seconds


class Phase(StrEnum):
    IDLE = "idle"
    ALIGN = "align"
    READY = "ready"
    ACTIVE = "active"
    RELEASE = "release"


class AlignmentSettings(Message):
    # Strength and stiffness together: a torque that may change by 2 a second comes late, and a stronger or stiffer spring then
    # swings a free wheel to and fro for good, once a swinging car has set it off (tests: 0.02 and 0.035 kg m2, 2.2 and 3.5 Nm).
    torque_max: Annotated[float, Meta(gt=0.0, le=0.6)] = 0.2
    ramp_s: Annotated[float, Meta(gt=0.05, le=5.0)] = 1.0
    stiffness_1_rad: Annotated[float, Meta(gt=0.1, le=10.0)] = 1.4  # leaves 1 deg against 0.05 Nm of friction
    damping_s: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.2  # per rad/s, against the rate of the centre
    rate_max_rad_s: Annotated[float, Meta(gt=0.1, le=5.0)] = 1.5  # of the walking centre: a hand on the rim can let it pass
    approach_s: Annotated[float, Meta(gt=0.05, le=2.0)] = 0.15  # the centre's last bit is exponential, not a stop
    ready_error_rad: Annotated[float, Meta(gt=0.0, le=0.2)] = 0.0524  # 3 deg at the steering wheel
    ready_after_s: Seconds = 0.5
    telemetry_age_max_ms: Milliseconds = 200.0
    blend_s: Annotated[float, Meta(ge=1.0, le=2.0)] = 1.5
    release_s: Annotated[float, Meta(gt=0.05, le=2.0)] = 0.3


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelInputs:
    angle_rad: float  # operator's wheel, local
    rate_rad_s: float
    car_angle_rad: float | None  # at the steering wheel: the car's road wheel angle * steering ratio; None: unknown
    telemetry_age_ns: int | None
    speed_m_s: float
    lateral_m_s2: float  # of the car, as reported
    lock_rad: float
    wanted: bool  # a take-over is asked for or wished
    driving: bool  # the car says so, or has just granted it
    armed: bool


class WheelState(Struct, frozen=True, kw_only=True):
    phase: Phase = Phase.IDLE
    since_ns: int = 0
    centre_rad: float = 0.0  # of the aligning spring
    centre_rate_rad_s: float = 0.0
    aligned_since_ns: int | None = None
    rest_offset_rad: float = 0.0  # wheel minus car when ACTIVE began
    lateral_m_s2: float = 0.0  # low-passed
    torque: float = 0.0  # last sent, normalised


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelLimits:
    torque: TorqueSettings
    alignment: AlignmentSettings


def is_fresh(seen: WheelInputs, settings: AlignmentSettings) -> bool:
    age = seen.telemetry_age_ns
    return seen.car_angle_rad is not None and age is not None and age <= settings.telemetry_age_max_ms * 1e6


def alignment_error_rad(seen: WheelInputs) -> float:
    """Operator's angle minus the car's, at the steering wheel; 0 when the car's is unknown."""
    return 0.0 if seen.car_angle_rad is None else seen.angle_rad - seen.car_angle_rad


def step(state: WheelState, seen: WheelInputs, now_ns: int, dt_s: float, limits: WheelLimits) -> WheelState:
    """Phase and torque one tick later. The torque keeps its slew and limit whatever the phase does."""
    moved = _walk(_NEXT[state.phase](state, seen, now_ns, limits.alignment), seen, now_ns, dt_s, limits.alignment)
    # what the car said last fades out when it falls silent
    said = seen.lateral_m_s2 if is_fresh(seen, limits.alignment) else 0.0
    lateral = low_passed(moved.lateral_m_s2, said, dt_s, limits.torque.lateral_time_constant_s)
    moved = replace(moved, lateral_m_s2=lateral)
    wanted = wanted_torque(moved, seen, now_ns, limits)
    return replace(moved, torque=limited(wanted, state.torque, dt_s, limits.torque))


def command_angle_rad(state: WheelState, angle_rad: float, now_ns: int, settings: AlignmentSettings) -> float:
    """The steering wheel angle to command: the wheel's own, less what is left of the rest offset."""
    if state.phase is not Phase.ACTIVE:
        return angle_rad
    share = min(_in_phase_s(state, now_ns) / settings.blend_s, 1.0)
    return angle_rad - state.rest_offset_rad * (1.0 - share)


def _enter(state: WheelState, phase: Phase, now_ns: int, **changes: float | None) -> WheelState:
    return replace(state, phase=phase, since_ns=now_ns, aligned_since_ns=None, **changes)


def _begin(state: WheelState, seen: WheelInputs, now_ns: int) -> WheelState:
    return _enter(state, Phase.ACTIVE, now_ns, rest_offset_rad=alignment_error_rad(seen))


def _from_idle(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> WheelState:
    if seen.driving:
        return _begin(state, seen, now_ns)
    if seen.wanted and is_fresh(seen, settings):
        return _enter(state, Phase.ALIGN, now_ns, centre_rad=seen.angle_rad, centre_rate_rad_s=0.0)
    return state


def _from_align(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> WheelState:
    if seen.driving:
        return _begin(state, seen, now_ns)
    if not seen.wanted:
        return _enter(state, Phase.RELEASE, now_ns)
    if not _is_aligned(seen, settings):
        return replace(state, aligned_since_ns=None)
    since = now_ns if state.aligned_since_ns is None else state.aligned_since_ns
    if now_ns - since >= settings.ready_after_s * 1e9:
        # the phase changes, the ramp of the spring does not start again
        return replace(state, phase=Phase.READY, aligned_since_ns=since)
    return replace(state, aligned_since_ns=since)


def _from_ready(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> WheelState:
    if seen.driving:
        return _begin(state, seen, now_ns)
    if not seen.wanted:
        return _enter(state, Phase.RELEASE, now_ns)
    return state if _is_aligned(seen, settings) else replace(state, phase=Phase.ALIGN, aligned_since_ns=None)


def _from_active(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> WheelState:
    return state if seen.driving else _enter(state, Phase.RELEASE, now_ns, rest_offset_rad=0.0)


def _from_release(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> WheelState:
    if seen.driving:
        return _begin(state, seen, now_ns)
    return _enter(state, Phase.IDLE, now_ns) if _in_phase_s(state, now_ns) >= settings.release_s else state


_NEXT: dict[Phase, Callable[[WheelState, WheelInputs, int, AlignmentSettings], WheelState]] = {
    Phase.IDLE: _from_idle,
    Phase.ALIGN: _from_align,
    Phase.READY: _from_ready,
    Phase.ACTIVE: _from_active,
    Phase.RELEASE: _from_release,
}


def _is_aligned(seen: WheelInputs, settings: AlignmentSettings) -> bool:
    return is_fresh(seen, settings) and seen.armed and abs(alignment_error_rad(seen)) < settings.ready_error_rad


def _walk(state: WheelState, seen: WheelInputs, now_ns: int, dt_s: float, settings: AlignmentSettings) -> WheelState:
    """Move the spring's centre towards the car's angle: never faster than rate_max, which is ramped in like the torque, and
    never farther ahead of the wheel than the spring pulls - a wheel that was held back does not shoot off when let go."""
    if state.phase not in (Phase.ALIGN, Phase.READY) or seen.car_angle_rad is None:
        return state
    rate_max = settings.rate_max_rad_s * ramp(state, now_ns, settings)
    rate = clamp((seen.car_angle_rad - state.centre_rad) / (settings.approach_s + dt_s), rate_max)
    lead = clamp(state.centre_rad + rate * dt_s - seen.angle_rad, settings.torque_max / settings.stiffness_1_rad)
    return replace(state, centre_rad=seen.angle_rad + lead, centre_rate_rad_s=rate)


def wanted_torque(state: WheelState, seen: WheelInputs, now_ns: int, limits: WheelLimits) -> float:
    """The torque the phase asks for, before slew and limit."""
    if state.phase is Phase.ACTIVE:
        return steering_torque(seen.angle_rad, seen.rate_rad_s, seen.speed_m_s, state.lateral_m_s2, seen.lock_rad, limits.torque)
    if state.phase in (Phase.ALIGN, Phase.READY) and is_fresh(seen, limits.alignment):
        return _aligning_torque(state, seen, now_ns, limits.alignment)
    # idle, releasing or without telemetry: nothing pulls; the slew limit of RELEASE's 0.3 s is the torque's own
    return damping_torque(seen.rate_rad_s, seen.speed_m_s, limits.torque) + end_stop_torque(
        seen.angle_rad, seen.lock_rad, limits.torque
    )


def _aligning_torque(state: WheelState, seen: WheelInputs, now_ns: int, settings: AlignmentSettings) -> float:
    spring = clamp(settings.stiffness_1_rad * (state.centre_rad - seen.angle_rad), settings.torque_max)
    damping = settings.damping_s * (state.centre_rate_rad_s - seen.rate_rad_s)
    return clamp(spring * ramp(state, now_ns, settings) + damping, settings.torque_max)


def ramp(state: WheelState, now_ns: int, settings: AlignmentSettings) -> float:
    """Share of the aligning pull, 0..1 from the beginning of ALIGN."""
    return min(_in_phase_s(state, now_ns) / settings.ramp_s, 1.0)


def _in_phase_s(state: WheelState, now_ns: int) -> float:
    return (now_ns - state.since_ns) / 1e9
