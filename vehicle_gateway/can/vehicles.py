"""Which messages a car speaks: the codec that [vehicle_gateway.can] `vehicle` chooses. Its gateway knows no other difference.

To add a car: a DBC in config/, a codec with the methods of `CarCodec`, a line in `_CARS`, its checks in vehicle_gateway.check.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from vehicle_gateway.can.codec import Feedback, codec_of
from vehicle_gateway.can.cyclic import Sent
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import HealthCodec, health_codec_of
from vehicle_gateway.can.settings import DRIVE_BY_WIRE, TOYOTA, CanSettings
from vehicle_gateway.can.toyota_codec import toyota_codec
from vehicle_gateway.can.transmit import Permit
from vehicle_gateway.can.watch_codec import WatchCodec, watch_codec_of
from wire.messages.vehicle import Actuation, Mode, VehicleDescription


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
    watch: WatchCodec | None = None  # None: its far side obeys no watchdog

    @property
    def permits(self) -> Mapping[int, Permit]:
        """All that the gateway may send."""
        return {**self.codec.permits, **(self.watch.gateway_permits if self.watch is not None else {})}


def car_bus_of(settings: CanSettings, vehicle: VehicleDescription) -> CarBus:
    """Raises ConfigurationError when the configuration does not describe such a car."""
    return _CARS[settings.vehicle](settings, vehicle)


def _drive_by_wire(settings: CanSettings, _: VehicleDescription) -> CarBus:
    frames = read_layouts(settings.dbc)
    return CarBus(codec_of(frames), health_codec_of(frames), watch_codec_of(frames))


_CARS: dict[str, Callable[[CanSettings, VehicleDescription], CarBus]] = {
    DRIVE_BY_WIRE: _drive_by_wire,
    TOYOTA: lambda settings, vehicle: CarBus(toyota_codec(settings.dbc, vehicle), None),
}
