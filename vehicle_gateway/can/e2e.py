"""End-to-end protection of our CAN frames after AUTOSAR E2E Profile 1: a CRC over data id and content, a counter.

Finds corruption, masquerade, loss, repetition. Never a defence against an attacker: who knows the data ids can forge.
Source: AUTOSAR PRS E2E Protocol, Profile 1 variant 1A (CRC in byte 0, counter in byte 1's low nibble, both bytes of
the data id in the CRC); CRC8 of SAE J1850: polynomial 0x1D, start and final XOR 0xFF, 0x4B over "123456789".
"""

from vehicle_gateway.can.frame import Frame

POLYNOMIAL = 0x1D
COUNTER_MODULUS = 15  # Profile 1 counts 0..14; 15 is never sent
DELTA_MAX = 3  # frames: up to two lost in a row pass; more is a jump, and the next frame may follow on from it


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


def follows(previous: int | None, counter: int) -> bool:
    """Whether `counter` may come after `previous` (None: nothing received yet): 1 to DELTA_MAX on, never the same."""
    if counter >= COUNTER_MODULUS:
        return False
    return previous is None or 1 <= (counter - previous) % COUNTER_MODULUS <= DELTA_MAX
