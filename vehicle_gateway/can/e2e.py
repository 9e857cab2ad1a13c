"""End-to-end protection of our CAN frames after AUTOSAR E2E Profile 1: a CRC over data id and content, a counter.

Finds corruption, masquerade, loss, repetition. Never a defence against an attacker: who knows the data ids can forge.

A receiver keeps to the sequence it trusts. Of stray frames it uses the fourth in a row that follow one another, with none of
the trusted sequence between: from then on it trusts theirs. Profile 1 leaves the trusted sequence at the first stray frame,
and would use nothing of two senders that alternate: here the car's own frames go on to count.

Source: AUTOSAR PRS E2E Protocol, Profile 1 variant 1A (CRC in byte 0, counter in byte 1's low nibble, both bytes of
the data id in the CRC); CRC8 of SAE J1850: polynomial 0x1D, start and final XOR 0xFF, 0x4B over "123456789".
"""

from typing import NamedTuple

from vehicle_gateway.can.frame import Frame

POLYNOMIAL = 0x1D
COUNTER_MODULUS = 15  # Profile 1 counts 0..14; 15 is never sent
DELTA_MAX = 3  # frames: up to two lost in a row pass; more is a jump
SYNC_FRAMES = 2  # that must follow a jump before a frame is used again: Profile 1's SyncCounterInit


def _remainder(byte: int) -> int:
    for _ in range(8):
        byte = (byte << 1) ^ POLYNOMIAL if byte & 0x80 else byte << 1
    return byte & 0xFF


_TABLE = bytes(_remainder(byte) for byte in range(256))


def crc8(data: bytes, start: int = 0xFF) -> int:
    """CRC8 SAE J1850 of `data`."""
    crc = start
    for byte in data:
        crc = _TABLE[crc ^ byte]
    return crc ^ 0xFF


def protect(data_id: int, body: bytes) -> bytes:
    """The payload: CRC, then `body` (everything from byte 1 on, the counter already in its low nibble)."""
    return bytes((crc8(data_id.to_bytes(2, "little") + body),)) + body


def is_intact(data_id: int, frame: Frame) -> bool:
    """Whether the CRC in byte 0 fits data id and content."""
    return frame.data[0] == crc8(data_id.to_bytes(2, "little") + frame.data[1:])


def counter_of(frame: Frame) -> int:
    return frame.data[1] & 0x0F


class Trail(NamedTuple):
    """What a receiver knows of a sender's counter."""

    newest: int | None = None  # of the trusted sequence; None: nothing received yet
    stray: int | None = None  # of the newest frame that did not follow it
    strays: int = 0  # frames in a row that followed one another, but not the trusted sequence


START = Trail()
_TRUSTED = tuple(Trail(counter) for counter in range(COUNTER_MODULUS))


def judge(trail: Trail, counter: int) -> tuple[Trail, bool]:
    """What is known after one intact frame, and whether it may be used. The first frame may carry any counter."""
    if counter >= COUNTER_MODULUS or counter in (trail.newest, trail.stray):
        return trail, False
    if trail.newest is None or _follows(trail.newest, counter):
        return _TRUSTED[counter], True
    strays = trail.strays + 1 if trail.stray is not None and _follows(trail.stray, counter) else 1
    return (_TRUSTED[counter], True) if strays > SYNC_FRAMES + 1 else (Trail(trail.newest, counter, strays), False)


def _follows(previous: int, counter: int) -> bool:
    return 1 <= (counter - previous) % COUNTER_MODULUS <= DELTA_MAX
