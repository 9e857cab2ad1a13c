"""What the gateway needs of a car's bus, whatever its messages are. It knows no other difference between two cars."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from vehicle_gateway.can.codec import Feedback, codec_of
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import HealthCodec, health_codec_of
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.transmit import Permit
from wire.messages.vehicle import Actuation, Mode


class CarCodec(Protocol):
    """Commands out, feedback in. Pure."""

    @property
    def permits(self) -> Mapping[int, Permit]:
        """All that the gateway may send to this car."""

    def start(self) -> Any:
        """The state of `decode` before the first frame. Its `feedback` is None, or a NEW object with every motion frame."""

    def decode(self, state: Any, frame: Frame) -> tuple[Any, str]:
        """The state after one frame from the car, and why the frame was dropped ("" when it was not)."""

    def commands(
        self, sent: Sent, actuation: Actuation, mode: Mode, brake_hold: bool, feedback: Feedback | None, now_ns: int
    ) -> tuple[Sent, tuple[Frame, ...]]:
        """The state after one cycle, and the frames that are due in it. feedback: the newest, for what follows the car."""


class CarBus(NamedTuple):
    codec: CarCodec
    health: HealthCodec | None  # None: the far side tells nothing about its loop


def car_bus_of(settings: CanSettings) -> CarBus:
    """Raises ConfigurationError when the car's DBC cannot be spoken."""
    frames = read_layouts(settings.dbc)
    return CarBus(codec_of(frames), health_codec_of(frames))
