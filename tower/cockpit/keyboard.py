"""Keyboard and gamepad as a device: keys or a stick turn a virtual wheel and press its pedals, so that a person can drive well.

A held arrow key walks the wheel's target, faster the longer it is held and the slower the car; a released one lets it return to the
middle. A stick names the target itself, as a share of the sharpest bend at this speed. Before the wheel is the operator's (phase
ACTIVE) the arms are off it. Never reads keyboard or gamepad: the window does.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import atan
from typing import Annotated

from msgspec import Meta

from haptics.alignment import Phase
from haptics.torque import clamp
from haptics.virtual_wheel import VirtualWheel, VirtualWheelSettings, turned
from tower.cockpit.arms import ArmsSettings, arms_torque_nm
from tower.cockpit.command import SAMPLE_AGE_MAX_NS
from tower.cockpit.devices import Controls, View
from wire.messages.base import Message, Seconds
from wire.messages.operating import InputKind, OperatorInput
from wire.messages.vehicle import VehicleDescription

Rate = Annotated[float, Meta(gt=0.0, le=50.0)]
DEFAULT_LOCK_RAD = 7.85  # 450 deg, a consumer wheel's half range, until the car has described itself


class KeyboardSettings(Message):
    rate_slow_rad_s: Rate = 5.0  # of the wheel's target with a key held, at walking pace
    rate_fast_rad_s: Rate = 2.0  # at fast_m_s and above
    fast_m_s: Annotated[float, Meta(gt=0.5, le=40.0)] = 8.33
    tap_share: Annotated[float, Meta(gt=0.0, le=1.0)] = 0.35  # of that rate at the first moment: a tap corrects a little
    tap_s: Seconds = 0.4  # until the full rate
    return_rad_s: Rate = 6.0  # back to the middle, at most
    return_s: Annotated[float, Meta(gt=0.05, le=5.0)] = 0.35  # time constant of the last part
    lateral_max_m_s2: Annotated[float, Meta(gt=0.5, le=9.0)] = 2.5  # a held key asks for no sharper bend than this
    throttle_rise_1_s: Rate = 1.2
    throttle_fall_1_s: Rate = 4.0
    brake_rise_1_s: Rate = 2.0
    brake_fall_1_s: Rate = 5.0
    stick_rate_rad_s: Rate = 6.0  # of the wheel's target under a stick, as fast as arms turn
    arms: ArmsSettings = ArmsSettings()


@dataclass(frozen=True, slots=True, kw_only=True)
class Keys:
    """What the keys have made of wheel and pedals so far."""

    target_rad: float = 0.0
    held_s: float = 0.0  # the present steering key
    throttle: float = 0.0
    brake: float = 0.0


def steered(keys: Keys, steer: float, speed_m_s: float, target_max_rad: float, dt_s: float, settings: KeyboardSettings) -> Keys:
    """Target angle of the wheel after dt_s with `steer` in -1..1 held (left positive)."""
    if steer == 0.0:
        rate = clamp(-keys.target_rad / settings.return_s, settings.return_rad_s)
        return replace(keys, target_rad=keys.target_rad + rate * dt_s, held_s=0.0)
    share = min(abs(speed_m_s) / settings.fast_m_s, 1.0)
    full = settings.rate_slow_rad_s + (settings.rate_fast_rad_s - settings.rate_slow_rad_s) * share
    pressing = settings.tap_share + (1.0 - settings.tap_share) * min(keys.held_s / max(settings.tap_s, dt_s), 1.0)
    against = keys.target_rad * steer < 0.0  # countersteering begins with letting go, at that rate
    rate = steer * (max(full * pressing, settings.return_rad_s) if against else full * pressing)
    return replace(keys, target_rad=clamp(keys.target_rad + rate * dt_s, target_max_rad), held_s=keys.held_s + dt_s)


def stick_steered(
    keys: Keys, steer: float, speed_m_s: float, target_max_rad: float, dt_s: float, settings: KeyboardSettings
) -> Keys:
    """Target angle of the wheel after dt_s with a stick at `steer`: that share of the sharpest bend, and no faster than arms."""
    step = clamp(steer * target_max_rad - keys.target_rad, settings.stick_rate_rad_s * dt_s)
    return replace(keys, target_rad=clamp(keys.target_rad + step, target_max_rad), held_s=0.0)


def stick_pedalled(keys: Keys, throttle: float, brake: float, dt_s: float, settings: KeyboardSettings) -> Keys:
    """Triggers are pedals: they are where the fingers hold them."""
    return replace(keys, throttle=throttle, brake=brake)


def pedalled(keys: Keys, throttle: float, brake: float, dt_s: float, settings: KeyboardSettings) -> Keys:
    return replace(
        keys,
        throttle=_ramped(keys.throttle, throttle, settings.throttle_rise_1_s, settings.throttle_fall_1_s, dt_s),
        brake=_ramped(keys.brake, brake, settings.brake_rise_1_s, settings.brake_fall_1_s, dt_s),
    )


def _ramped(value: float, wanted: float, rise_1_s: float, fall_1_s: float, dt_s: float) -> float:
    return value + min(max(wanted - value, -fall_1_s * dt_s), rise_1_s * dt_s)


def target_max_rad(speed_m_s: float, description: VehicleDescription | None, settings: KeyboardSettings) -> float:
    """Steering wheel angle of the sharpest bend a held key asks for at this speed: atan(L a / v^2), and the car's own end."""
    if description is None:
        return DEFAULT_LOCK_RAD
    speed = max(abs(speed_m_s), 0.5)
    road_wheel = min(atan(description.wheelbase_m * settings.lateral_max_m_s2 / speed**2), description.road_wheel_angle_max_rad)
    return road_wheel * description.steering_ratio


def lock_rad(description: VehicleDescription | None) -> float:
    """Steering wheel angle at which the car's road wheels reach their end."""
    if description is None:
        return DEFAULT_LOCK_RAD
    return min(description.steering_ratio * description.road_wheel_angle_max_rad, 16.0)  # 16 rad: range of the message


Steer = Callable[[Keys, float, float, float, float, KeyboardSettings], Keys]
Press = Callable[[Keys, float, float, float, KeyboardSettings], Keys]
_HANDS: dict[InputKind, tuple[Steer, Press]] = {
    InputKind.KEYBOARD: (steered, pedalled),
    InputKind.GAMEPAD: (stick_steered, stick_pedalled),
}


class KeyboardDevice:
    def __init__(self, settings: KeyboardSettings, wheel_settings: VirtualWheelSettings, wheel: VirtualWheel) -> None:
        """wheel  where the wheel stands: that of the device used before"""
        self._settings = settings
        self._wheel_settings = wheel_settings
        self._wheel = wheel
        self._keys = Keys(target_rad=wheel.angle_rad)
        self._last: OperatorInput | None = None
        self._event_ns = 0

    @property
    def name(self) -> str:
        return self._last.device if self._last is not None else "keyboard"

    def step(self, view: View, torque: float, dt_s: float, now_ns: int) -> Controls:
        message = view.operator_input.message if view.operator_input is not None else None
        usable = message is not None and message.focus and now_ns - message.stamp_ns <= SAMPLE_AGE_MAX_NS
        self._notice(message)
        self._move(message if usable else None, view, torque, dt_s)
        controls = Controls(
            wheel=self._wheel,
            throttle=self._keys.throttle,
            brake=self._keys.brake,
            event_ns=self._event_ns,
            sample_ns=message.stamp_ns if message is not None else 0,
        )
        if message is None:
            return controls
        controls = replace(
            controls,
            gear=message.gear,
            indicators=message.indicators,
            hazard=message.hazard,
            lights=message.lights,
            wipers=message.wipers,
            throttle_reported=usable and message.pedals_reported,
            brake_reported=usable and message.pedals_reported,
        )
        return replace(controls, dead_man=message.dead_man, horn=message.horn, steer=message.steer) if usable else controls

    def _notice(self, message: OperatorInput | None) -> None:
        if message is None or message is self._last:
            return
        if self._last is None or held_levels(message) != held_levels(self._last):
            self._event_ns = message.stamp_ns
        self._last = message

    def _move(self, message: OperatorInput | None, view: View, torque: float, dt_s: float) -> None:
        description = view.description.message if view.description is not None else None
        throttle, brake = (message.throttle, message.brake) if message is not None else (0.0, 0.0)
        steer, press = _HANDS[message.kind if message is not None else InputKind.KEYBOARD]
        self._keys = press(self._keys, throttle, brake, dt_s, self._settings)
        arms_nm = 0.0
        if view.wheel_phase is Phase.ACTIVE:
            if message is not None:  # without keys to go by the arms hold still: straightening up would steer
                limit = target_max_rad(view.speed_m_s, description, self._settings)
                self._keys = steer(self._keys, message.steer, view.speed_m_s, limit, dt_s, self._settings)
            arms_nm = arms_torque_nm(self._wheel, self._keys.target_rad, self._settings.arms)
        else:
            self._keys = replace(self._keys, target_rad=self._wheel.angle_rad, held_s=0.0)
        self._wheel = turned(self._wheel, torque, arms_nm, lock_rad(description), dt_s, self._wheel_settings)


def held_levels(message: OperatorInput) -> tuple[object, ...]:
    return (
        message.focus,
        message.device,
        message.steer,
        message.steering_wheel_angle_rad,
        message.throttle,
        message.brake,
        message.dead_man,
        message.gear,
        message.indicators,
        message.hazard,
        message.horn,
        message.lights,
        message.wipers,
    )
