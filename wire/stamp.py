"""The capture stamp inside a picture: what the car writes and the tower reads. Pure.

It travels as H.264 SEI "user data unregistered" (ITU-T H.264 D.1.7) with our UUID; FFmpeg hands the
payload on, free of emulation prevention. x264 puts a message of its own into the first picture: only ours counts.
"""

import struct
from collections.abc import Iterable
from dataclasses import dataclass
from uuid import UUID

STAMP_UUID = UUID("a3c1f6e2-5d0b-4c8e-9b47-70d2e81c64fa").bytes
_BODY = struct.Struct(">QI")  # capture_ns (vehicle clock), sequence


@dataclass(frozen=True, slots=True)
class Stamp:
    capture_ns: int
    sequence: int


def stamp_payload(stamp: Stamp) -> bytes:
    """The SEI payload: UUID, capture time, sequence modulo 2**32."""
    return STAMP_UUID + _BODY.pack(stamp.capture_ns, stamp.sequence & 0xFFFFFFFF)


def read_stamp(messages: Iterable[bytes]) -> Stamp | None:
    """The stamp among the SEI payloads (UUID first) of one picture; None when there is none of ours."""
    for message in messages:
        if message.startswith(STAMP_UUID) and len(message) >= len(STAMP_UUID) + _BODY.size:
            return Stamp(*_BODY.unpack_from(message, len(STAMP_UUID)))
    return None
