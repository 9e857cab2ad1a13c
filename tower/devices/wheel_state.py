"""A steering wheel's readings, tick by tick: angle, rate, pedals, switches, and whether a person has touched it. Pure.

Turning the rim is no touch: wheels turn by themselves when they are plugged in, and under their own force feedback.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from haptics.torque import low_passed
from haptics.virtual_wheel import VirtualWheel
from tower.cockpit.devices import Controls
from tower.devices.profile import Profile, held, meant, noticed, travel, wheel_angle_rad
from tower.devices.switches import Control, Switches, changes

RATE_TIME_CONSTANT_S = 0.02  # one count of a G920 in one tick is 0.06 rad/s of noise
TOUCHED_FROM = 0.2  # of a pedal's travel: feet rest on pedals


@dataclass(frozen=True, slots=True, kw_only=True)
class WheelReadings:
    levels: Mapping[str, float] = field(default_factory=dict)
    angle_rad: float = 0.0  # left positive; 0 until it has reported
    rate_rad_s: float = 0.0
    switches: Switches = Switches()
    pressed: frozenset[Control] = frozenset()  # in this tick
    touched: bool = False  # a pedal or the dead-man is pressed
    touches: int = 0
    event_ns: int = 0


def advanced(
    state: WheelReadings,
    readings: Iterable[tuple[str, float]],
    age_ns: int | None,
    profile: Profile,
    *,
    standing: bool,
    dt_s: float,
    now_ns: int,
) -> WheelReadings:
    """The readings after one tick.

    age_ns    of the newest reading; None when there was none
    standing  the car stands: the gear may change
    """
    levels, pressed = noticed(state.levels, readings)
    presses = meant(pressed, profile)
    switches = state.switches
    for press in presses:
        switches = replace(switches, **changes(switches, press, standing))
    angle = wheel_angle_rad(levels, profile.steering)
    touched = _is_touched(levels, profile)
    known_before = profile.steering.axis in state.levels
    moved = 0.0 if angle is None or not known_before else (angle - state.angle_rad) / dt_s
    return WheelReadings(
        levels=levels,
        angle_rad=angle or 0.0,
        rate_rad_s=low_passed(state.rate_rad_s, moved, dt_s, RATE_TIME_CONSTANT_S),
        switches=switches,
        pressed=frozenset(presses),
        touched=touched,
        touches=state.touches + (touched and not state.touched),
        event_ns=state.event_ns if age_ns is None else now_ns - age_ns,
    )


def _is_touched(levels: Mapping[str, float], profile: Profile) -> bool:
    pedals = (travel(levels, profile.throttle), travel(levels, profile.brake))
    return Control.DEAD_MAN in held(levels, profile) or any(value is not None and value > TOUCHED_FROM for value in pedals)


def controls(state: WheelReadings, profile: Profile, sampled_ns: int) -> Controls:
    """Where the controls are. sampled_ns: when the device was last known to be there; a wheel only speaks when it changes."""
    throttle, brake = travel(state.levels, profile.throttle), travel(state.levels, profile.brake)
    down = held(state.levels, profile)
    return Controls(
        wheel=VirtualWheel(state.angle_rad, state.rate_rad_s),
        wheel_reported=profile.steering.axis in state.levels,
        throttle=throttle or 0.0,
        brake=brake or 0.0,
        throttle_reported=throttle is not None,
        brake_reported=brake is not None,
        dead_man=Control.DEAD_MAN in down,
        gear=state.switches.gear,
        indicators=state.switches.indicators,
        hazard=state.switches.hazard,
        lights=state.switches.lights,
        wipers=state.switches.wipers,
        horn=Control.HORN in down,
        sample_ns=sampled_ns,
        event_ns=state.event_ns,
    )


def missing(state: WheelReadings, profile: Profile) -> tuple[str, ...]:
    """What has not reported yet, in words: before it has, its position is not known."""
    parts = (("the wheel", profile.steering.axis), ("the throttle", profile.throttle.axis), ("the brake", profile.brake.axis))
    return tuple(words for words, axis in parts if axis not in state.levels)
