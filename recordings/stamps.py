"""From the clocks of the senders to Unix time, for log_time and publish_time. Pure.

log_time      when the recorder received the message: vehicle clock + utc_minus_vehicle_ns
publish_time  the sender's own stamp on the same scale; a tower's stamp goes through the offset that the tower measured
              (OperatorStatus.clock_offset_ns). Where no stamp or no offset is known it is the log_time, as MCAP asks.
The raw stamps stay in the payload. Nothing here is ever used to decide anything.
"""

from dataclasses import dataclass

from wire.messages.base import Message

_FIELDS = ("stamp_ns", "sent_ns", "now_ns")  # how messages call the time they were made


@dataclass(frozen=True, slots=True, kw_only=True)
class Clocks:
    utc_minus_vehicle_ns: int  # Unix time = vehicle clock + this, read once at start
    tower_offset_ns: int | None = None  # vehicle clock = tower clock + this; None before the tower measured it


def stamp_field(message_type: type[Message]) -> str | None:
    """The field that says when a message was made, on its sender's clock; None when it has none (as a map)."""
    return next((name for name in _FIELDS if name in message_type.__struct_fields__), None)


def publish_time_ns(stamp_ns: int | None, log_ns: int, from_car: bool, clocks: Clocks) -> int:
    """Unix time at which a message was made.

    stamp_ns  on the sender's clock: the vehicle's when `from_car`, else the tower's
    log_ns    Unix time of its arrival: the answer where the stamp cannot be mapped
    """
    offset_ns = 0 if from_car else clocks.tower_offset_ns
    if stamp_ns is None or offset_ns is None:
        return log_ns
    return max(stamp_ns + offset_ns + clocks.utc_minus_vehicle_ns, 0)
