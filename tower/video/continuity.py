"""Which decoded pictures are whole. Pure.

A decoder that misses a picture goes on and conceals: what it shows is wrong until the next IDR, under a fresh stamp.
An old picture with its true age is better: after a hole in the sequence nothing is shown until the next key picture.
"""

from dataclasses import dataclass

_SEQUENCE = 2**32


@dataclass(frozen=True, slots=True)
class Continuity:
    sequence: int | None = None  # of the last decoded picture
    whole: bool = False  # nothing is missing since the last key picture


def follow(state: Continuity, sequence: int, is_key: bool, is_corrupt: bool) -> Continuity:
    """The state after one more decoded picture; it may be shown when `whole` is true."""
    unbroken = state.whole and state.sequence is not None and sequence == (state.sequence + 1) % _SEQUENCE
    return Continuity(sequence, not is_corrupt and (is_key or unbroken))
