"""Frames of config/drive_by_wire.dbc as bit fields: physical values to payload and back, protected and range-checked.

The DBC is read with cantools once, at start; packing is integer shifting: it stands between a command and the bus.
A number is saturated at the limits of the DBC. One that is not finite is never turned into a plausible one: it is sent
as "not available", a raw value outside the range, and the receiver drops the frame.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite
from typing import Any, NamedTuple

import cantools

from vehicle_gateway.can import e2e
from vehicle_gateway.can.frame import Frame
from wire.configuration import shipped

PROTECTION = ("CRC", "COUNTER")


class Field(NamedTuple):
    name: str
    start: int  # bit, little-endian
    mask: int  # of the raw value
    sign: int  # its sign bit, 0 when unsigned
    scale: float
    offset: float
    low: float  # physical limits
    high: float
    raw_low: int
    raw_high: int
    not_available: int


@dataclass(frozen=True, slots=True)
class Layout:
    name: str
    arbitration_id: int
    size: int  # bytes
    data_id: int  # E2E
    fields: tuple[Field, ...]  # in the order of the DBC, without CRC and counter

    def pack(self, values: Sequence[float], counter: int) -> Frame:
        """The protected frame. `values` in the order of `fields`, physical units; `counter` is sent modulo 15."""
        bits = (counter % e2e.COUNTER_MODULUS) << 8
        for field, value in zip(self.fields, values, strict=True):
            bits |= _raw(field, value) << field.start
        return Frame(self.arbitration_id, e2e.protect(self.data_id, bits.to_bytes(self.size, "little")[1:]))

    def unpack(self, data: bytes) -> tuple[float, ...] | None:
        """Physical values in the order of `fields`; None when one is not available or outside its range."""
        bits = int.from_bytes(data, "little")
        values = []
        for field in self.fields:
            raw = (bits >> field.start) & field.mask
            raw -= (raw & field.sign) << 1
            if not field.raw_low <= raw <= field.raw_high:
                return None
            values.append(raw * field.scale + field.offset)
        return tuple(values)

    def receive(self, frame: Frame, previous: int | None) -> tuple[tuple[float, ...] | None, str]:
        """(values, "") of an acceptable frame, (None, reason) of any other. previous: the counter received before."""
        if len(frame.data) != self.size or not e2e.is_intact(self.data_id, frame):
            return None, "can crc"
        if not e2e.follows(previous, e2e.counter_of(frame)):
            return None, "can counter"
        values = self.unpack(frame.data)
        return (None, "can range") if values is None else (values, "")


def _raw(field: Field, value: float) -> int:
    if not isfinite(value):
        return field.not_available
    inside = min(max(value, field.low), field.high)
    return round((inside - field.offset) / field.scale) & field.mask


def _field(signal: Any) -> Field:  # a cantools signal
    sign = 1 << (signal.length - 1) if signal.is_signed else 0
    mask = (1 << signal.length) - 1
    low, high, scale, offset = (float(x) for x in (signal.minimum, signal.maximum, signal.scale, signal.offset))
    return Field(
        name=signal.name,
        start=signal.start,
        mask=mask,
        sign=sign,
        scale=scale,
        offset=offset,
        low=low,
        high=high,
        raw_low=round((low - offset) / scale),
        raw_high=round((high - offset) / scale),
        not_available=sign or mask,
    )


@cache
def layouts() -> dict[str, Layout]:
    """Every frame of our DBC by name. Read once per process (about 30 ms)."""
    database: Any = cantools.database.load_file(shipped("drive_by_wire.dbc"))
    return {
        message.name: Layout(
            name=message.name,
            arbitration_id=message.frame_id,
            size=message.length,
            data_id=int(message.dbc.attributes["E2EDataId"].value),
            fields=tuple(
                _field(signal) for signal in sorted(message.signals, key=lambda s: int(s.start)) if signal.name not in PROTECTION
            ),
        )
        for message in database.messages
    }
