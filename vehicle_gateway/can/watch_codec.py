"""The two frames of the watchdog: what the gateway shows it, and what it tells the ECU. Pure.

GATEWAY_SOURCES says when the newest command of who drives was taken: a gateway whose cycle hangs cannot make it change.
WATCHDOG_STOP is sent all the time, and asks for a stop while its fault is not "none". A car whose DBC lacks them is driven all
the same.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum

from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout, layouts
from vehicle_gateway.can.transmit import Permit, permits_of

MODULUS = 65535


class Fault(IntEnum):
    """What the watchdog holds against the gateway."""

    NONE = 0
    SILENT = 1  # no valid command frame
    UNDRIVEN = 2  # traction in a mode in which nobody drives
    LEFT_STOP = 3  # out of a safe stop while the car moves
    STARVED = 4  # driven by nobody's commands: fresh frames, nothing new behind them


@dataclass(frozen=True, slots=True)
class WatchCodec:
    sources: Layout
    stop: Layout

    @property
    def gateway_permits(self) -> dict[int, Permit]:
        return permits_of((self.sources,))

    @property
    def watchdog_permits(self) -> dict[int, Permit]:
        return permits_of((self.stop,))

    def speaks(self, frame: Frame) -> bool:
        return frame.arbitration_id in (self.sources.arbitration_id, self.stop.arbitration_id)

    def encode_sources(self, newest_ns: int, counter: int) -> Frame:
        return self.sources.pack((newest_ns // 1_000_000 % MODULUS,), counter)

    def encode_stop(self, fault: Fault, counter: int) -> Frame:
        return self.stop.pack((fault,), counter)


def watch_codec_of(frames: Mapping[str, Layout]) -> WatchCodec | None:
    """None for a car whose DBC has no such frames."""
    sources, stop = frames.get("GATEWAY_SOURCES"), frames.get("WATCHDOG_STOP")
    return WatchCodec(sources, stop) if sources is not None and stop is not None else None


SHIPPED = WatchCodec(layouts()["GATEWAY_SOURCES"], layouts()["WATCHDOG_STOP"])


@dataclass(frozen=True, slots=True)
class StopState:
    """What the ECU knows of the watchdog: a NEW object with every valid frame."""

    fault: Fault = Fault.NONE
    trail: Trail = START


def decode_stop(state: StopState, frame: Frame) -> tuple[StopState, str]:
    """The state after one WATCHDOG_STOP, and why it was dropped ("" when it was not)."""
    trail, values, reason = SHIPPED.stop.receive(frame, state.trail)
    return StopState(state.fault if values is None else Fault(int(values[0])), trail), reason
