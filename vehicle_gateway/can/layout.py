"""Frames of a DBC file as bit fields: physical values to payload and back, protected and range-checked.

The DBC is read with cantools once, at start; packing is integer shifting: it stands between a command and the bus.
A number is saturated at the limits of the DBC. One that is not finite is never turned into a plausible one: it is sent
as "not available", a raw value outside the range, and the receiver drops the frame.

The shipped config/drive_by_wire.dbc says which messages and signals there are, by name. Another car's DBC has the same
names; identifiers, places, scales, ranges and E2E data ids are its own (vehicle_gateway.can.dbc).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import cantools

from vehicle_gateway.can import e2e
from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from wire.configuration import ConfigurationError, shipped

PROTECTION = ("CRC", "COUNTER")
DATA_ID = "E2EDataId"
DELAY_TIME = "GenMsgDelayTime"  # Vector's name for the least time between two frames [ms]
LEAST_PERIOD_MS = 4  # where a DBC does not say: the gateway's shortest cycle, 250 Hz


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
    fields: tuple[Field, ...]  # in the order of the shipped DBC, without CRC and counter
    cycle_ms: int = 0  # how often it comes; 0: the DBC does not say
    least_period_ms: int = LEAST_PERIOD_MS  # from one to the next

    @property
    def protection(self) -> str:
        return "E2E Profile 1"

    def pack(self, values: Sequence[float], counter: int) -> Frame:
        """The protected frame. `values` in the order of `fields`, physical units; `counter` is sent modulo 15."""
        bits = (counter % e2e.COUNTER_MODULUS) << 8
        for field, value in zip(self.fields, values, strict=True):
            bits |= raw_of(field, value) << field.start
        return Frame(self.arbitration_id, e2e.protect(self.data_id, bits.to_bytes(self.size, "little")[1:]))

    def unpack(self, data: bytes) -> tuple[float, ...] | None:
        """Physical values in the order of `fields`; None when one is not available or outside its range."""
        return values_in(int.from_bytes(data, "little"), self.fields)

    def is_intact(self, frame: Frame) -> bool:
        """Whether the frame has our length and our CRC."""
        return len(frame.data) == self.size and e2e.is_intact(self.data_id, frame)

    def receive(self, frame: Frame, trail: Trail = START) -> tuple[Trail, tuple[float, ...] | None, str]:
        """What is now known of the counter, and (values, "") of an acceptable frame, (None, reason) of any other."""
        if not self.is_intact(frame):
            return trail, None, "can crc"
        trail, is_next = e2e.judge(trail, e2e.counter_of(frame))
        if not is_next:
            return trail, None, "can counter"
        values = self.unpack(frame.data)
        return trail, values, "can range" if values is None else ""


def values_in(bits: int, fields: Sequence[Field]) -> tuple[float, ...] | None:
    """Physical values in the order of `fields`; None when one is not available or outside its range."""
    values = []
    for _, start, mask, sign, scale, offset, _, _, raw_low, raw_high, _ in fields:
        raw = (bits >> start) & mask
        raw -= (raw & sign) << 1
        if not raw_low <= raw <= raw_high:
            return None
        values.append(raw * scale + offset)
    return tuple(values)


def raw_of(field: Field, value: float) -> int:
    """The bits of a value, saturated at the field's limits; of one that is not finite: not available."""
    if not isfinite(value):
        return field.not_available
    inside = min(max(value, field.low), field.high)
    return round((inside - field.offset) / field.scale) & field.mask


def field_of(signal: Any, start: int) -> Field:  # a cantools signal; start: its lowest bit in the payload as one number
    sign = 1 << (signal.length - 1) if signal.is_signed else 0
    mask = (1 << signal.length) - 1
    low, high, scale, offset = (float(x) for x in (signal.minimum, signal.maximum, signal.scale, signal.offset))
    return Field(
        name=signal.name,
        start=start,
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


def layout_of(message: Any, order: Sequence[str]) -> Layout:  # a cantools message; order: names of its signals
    return Layout(
        name=message.name,
        arbitration_id=message.frame_id,
        size=message.length,
        data_id=data_id_of(message),
        fields=tuple(field_of(signal, signal.start) for signal in map(message.get_signal_by_name, order)),
        cycle_ms=message.cycle_time or 0,
        least_period_ms=attribute_of(message, DELAY_TIME) or LEAST_PERIOD_MS,
    )


def data_id_of(message: Any) -> int:
    return attribute_of(message, DATA_ID)


def attribute_of(message: Any, name: str) -> int:
    """The number that a DBC gives a message (BA_); 0 when it gives none."""
    attribute = message.dbc.attributes.get(name)
    return int(attribute.value) if attribute is not None else 0


def _names(message: Any) -> tuple[str, ...]:
    """The signals of a message by their place, without the protection."""
    return tuple(signal.name for signal in sorted(message.signals, key=lambda s: int(s.start)) if signal.name not in PROTECTION)


@cache
def layouts() -> dict[str, Layout]:
    """Every frame of our own DBC by name. Read once per process (about 30 ms)."""
    return {message.name: layout_of(message, _names(message)) for message in shipped_database().messages}


@cache
def shipped_database(name: str = "drive_by_wire.dbc") -> Any:
    return database_in(shipped(name))


def database_in(file: Path) -> Any:
    try:
        return cantools.database.load_file(file)
    except OSError as error:
        raise ConfigurationError(f"[vehicle_gateway.can] dbc: {file}: cannot be read: {error.strerror}") from None
    except (cantools.Error, ValueError) as error:
        raise ConfigurationError(f"[vehicle_gateway.can] dbc: {file}: not a valid DBC: {error}") from None
