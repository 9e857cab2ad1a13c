"""Toyota's frames as bit fields: physical values to payload and back, with Toyota's checksum. Pure but for reading the DBC.

Motorola byte order, so a field is a run of bits in the payload read as one big-endian number. Source of the checksum: opendbc,
`toyota_checksum`; it holds on every frame of the recorded log that has one (tests/vehicle_gateway/test_toyota_recorded.py).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Any

from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import DELAY_TIME, Field, attribute_of, field_of, raw_of, shipped_database, values_in

CHECKSUM = "CHECKSUM"


def checksum(identifier: int, body: bytes) -> int:
    """The last byte of a frame whose other bytes are `body`."""
    return (len(body) + 1 + (identifier & 0xFF) + (identifier >> 8) + sum(body)) & 0xFF


@dataclass(frozen=True, slots=True)
class ToyotaLayout:
    name: str
    arbitration_id: int
    size: int  # bytes
    fields: tuple[Field, ...]  # without the checksum
    has_checksum: bool
    cycle_ms: int  # how often it comes
    least_period_ms: int  # from one to the next, of what we send; 0 of what we receive

    @property
    def protection(self) -> str:
        return "Toyota checksum" if self.has_checksum else "none"

    def pack(self, values: Mapping[str, float]) -> Frame:
        """The frame; a field not named is 0. Numbers saturate at the limits of the DBC.

        Toyota has no way to say "not available". A number that is not finite makes a frame of no bytes, which no list of
        what may be sent lets pass: it is counted, and the car hears nothing rather than something plausible.
        """
        if not all(map(isfinite, values.values())):
            return Frame(self.arbitration_id, b"")
        bits = 0
        for field in self.fields:
            bits |= raw_of(field, values.get(field.name, 0.0)) << field.start
        payload = bits.to_bytes(self.size, "big")
        if self.has_checksum:
            payload = payload[:-1] + bytes((checksum(self.arbitration_id, payload[:-1]),))
        return Frame(self.arbitration_id, payload)

    def is_intact(self, frame: Frame) -> bool:
        """Whether the frame has our length and its own checksum, if it has one."""
        if len(frame.data) != self.size:
            return False
        return not self.has_checksum or frame.data[-1] == checksum(frame.arbitration_id, frame.data[:-1])

    def receive(self, frame: Frame) -> tuple[dict[str, float], str]:
        """(values by name, "") of an acceptable frame, ({}, reason) of any other. Toyota's feedback has no counters."""
        if not self.is_intact(frame):
            return {}, "can crc"
        values = values_in(int.from_bytes(frame.data, "big"), self.fields)
        if values is None:
            return {}, "can range"
        return {field.name: values[number] for number, field in enumerate(self.fields)}, ""


@cache
def toyota_layouts() -> dict[str, ToyotaLayout]:
    """Every frame of config/toyota.dbc by name. Read once per process."""
    return {message.name: _layout_of(message) for message in shipped_database("toyota.dbc").messages}


def _layout_of(message: Any) -> ToyotaLayout:  # a cantools message
    return ToyotaLayout(
        name=message.name,
        arbitration_id=message.frame_id,
        size=message.length,
        fields=tuple(field_of(each, _lowest_bit(message, each)) for each in message.signals if each.name != CHECKSUM),
        has_checksum=any(each.name == CHECKSUM for each in message.signals),
        cycle_ms=message.cycle_time,
        least_period_ms=attribute_of(message, DELAY_TIME),
    )


def _lowest_bit(message: Any, signal: Any) -> int:
    """From a DBC's Motorola start bit (the highest bit, numbered from the right within its byte) to a shift."""
    from_the_left = signal.start // 8 * 8 + 7 - signal.start % 8
    return int(message.length * 8 - from_the_left - signal.length)
