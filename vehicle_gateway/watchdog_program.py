"""`vehicle-gateway watchdog`: the shell of the watchdog. Owns its own end of the vehicle bus and nothing else; decides nothing.

No link, no file, no word of the gateway but its frames: what stops the gateway does not stop it. Its own death is noticed by
whoever supervises it, and it is started again; meanwhile the drive goes on: the ECU still answers silence by itself.
"""

import logging
import threading
from pathlib import Path

from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.dbc import read_layouts
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout
from vehicle_gateway.can.settings import DRIVE_BY_WIRE
from vehicle_gateway.can.watch_codec import Fault, WatchCodec, watch_codec_of
from vehicle_gateway.settings import VehicleGatewaySettings
from vehicle_gateway.watchdog import Heard, Watch, watch_step
from vehicle_gateway.watchdog_ear import Ear, ears_of, hear
from wire.clock import car_clock
from wire.configuration import ConfigurationError, read_sections
from wire.logs import fields
from wire.pace import Pace
from wire.settings import WireSettings

log = logging.getLogger(__name__)
PERIOD_S = 0.02


class Listener:
    """The reader thread's end: the newest of the bus."""

    def __init__(self, listened: dict[int, Layout]) -> None:
        self._listened, self.ear = listened, Ear()

    def on_frame(self, frame: Frame, received_ns: int) -> None:
        self.ear, _ = hear(self.ear, frame, received_ns, self._listened)


def run(config: Path, stop: threading.Event) -> int:
    """The watchdog until `stop` is set. Raises ConfigurationError at start."""
    read = read_sections(config, {"wire": WireSettings, "vehicle_gateway": VehicleGatewaySettings})
    settings: VehicleGatewaySettings = read["vehicle_gateway"]
    frames, codec = _frames_of(settings)
    clock, listener, watch = car_clock(read["wire"].clock), Listener(ears_of(frames)), Watch()
    priority = read["wire"].pace.fifo_priority
    with (
        open_bus(settings.can, "vehicle", listener.on_frame, clock, fifo_priority=priority, permits=codec.watchdog_permits) as bus,
        Pace(PERIOD_S, clock, stop, fifo_priority=priority) as pace,
    ):
        for counter, now_ns in enumerate(pace):
            before, watch = watch, watch_step(watch, listener.ear.heard, now_ns, settings.watchdog)
            bus.send(codec.encode_stop(watch.fault, counter))
            if watch.fault is not before.fault:
                _say(watch.fault, listener.ear.heard)
            if not bus.reading:
                return 1  # the reader has died and said why
    return 0


def _frames_of(settings: VehicleGatewaySettings) -> tuple[dict[str, Layout], WatchCodec]:
    frames = read_layouts(settings.can.dbc) if settings.can.vehicle == DRIVE_BY_WIRE else {}
    codec = watch_codec_of(frames)
    if codec is None:
        raise ConfigurationError(
            "[vehicle_gateway.can] this car's DBC has no GATEWAY_SOURCES and WATCHDOG_STOP: its ECU would not obey a watchdog; "
            "add both frames, or do not start one"
        )
    return frames, codec


def _say(fault: Fault, heard: Heard) -> None:
    if fault:
        log.error("the gateway is not to be trusted: the ECU is asked to stop", extra=fields(fault=fault.name, mode=heard.mode))
    else:
        log.info("the gateway is sane again and the car stands")
