"""The [haptics] section: the feel of the wheel, its hand-over, and the wheel that stands in where there is none."""

from haptics.alignment import AlignmentSettings, WheelLimits
from haptics.force_feedback import ForceFeedbackSettings
from haptics.torque import TorqueSettings
from haptics.virtual_wheel import VirtualWheelSettings
from wire.messages.base import Message


class HapticsSettings(Message):
    torque: TorqueSettings = TorqueSettings()
    alignment: AlignmentSettings = AlignmentSettings()
    force_feedback: ForceFeedbackSettings = ForceFeedbackSettings()
    virtual_wheel: VirtualWheelSettings = VirtualWheelSettings()

    def wheel_limits(self) -> WheelLimits:
        return WheelLimits(torque=self.torque, alignment=self.alignment)
