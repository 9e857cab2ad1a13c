"""One classic CAN frame with an 11-bit identifier."""

from typing import NamedTuple


class Frame(NamedTuple):
    arbitration_id: int
    data: bytes  # at most 8
