"""A steering wheel that the window reads through SDL: any wheel without evdev. Angle and pedals as they are; no forces."""

from dataclasses import replace

from haptics.torque import low_passed
from haptics.virtual_wheel import VirtualWheel
from tower.cockpit.command import SAMPLE_AGE_MAX_NS
from tower.cockpit.devices import Controls, View
from tower.cockpit.keyboard import held_levels
from tower.devices.wheel_state import RATE_TIME_CONSTANT_S
from wire.messages.operating import InputKind, OperatorInput


class WindowWheel:
    def __init__(self, wheel: VirtualWheel) -> None:
        """wheel  where the wheel of the device used before stands, until ours has said where it is"""
        self.name = "wheel"
        self._wheel = wheel
        self._last: OperatorInput | None = None
        self._event_ns = 0

    def step(self, view: View, torque: float, dt_s: float, now_ns: int) -> Controls:
        message = view.operator_input.message if view.operator_input is not None else None
        if message is None or message.kind is not InputKind.WHEEL:
            return Controls(wheel=self._wheel, wheel_reported=False)
        self._notice(message)
        usable = message.focus and now_ns - message.stamp_ns <= SAMPLE_AGE_MAX_NS
        if usable and message.pedals_reported:
            moved = (message.steering_wheel_angle_rad - self._wheel.angle_rad) / dt_s
            rate = low_passed(self._wheel.rate_rad_s, moved, dt_s, RATE_TIME_CONSTANT_S)
            self._wheel = VirtualWheel(message.steering_wheel_angle_rad, rate)
        now = Controls(
            wheel=self._wheel,
            wheel_reported=message.pedals_reported,
            gear=message.gear,
            indicators=message.indicators,
            hazard=message.hazard,
            lights=message.lights,
            wipers=message.wipers,
            sample_ns=message.stamp_ns,
            event_ns=self._event_ns,
        )
        if not usable:
            return now
        return replace(
            now,
            throttle=message.throttle,
            brake=message.brake,
            throttle_reported=message.pedals_reported,
            brake_reported=message.pedals_reported,
            dead_man=message.dead_man,
            horn=message.horn,
        )

    def _notice(self, message: OperatorInput) -> None:
        self.name = message.device
        if self._last is None or held_levels(message) != held_levels(self._last):
            self._event_ns = message.stamp_ns
        self._last = message
