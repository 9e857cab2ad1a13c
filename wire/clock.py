"""The clock of a process: monotonic, integer nanoseconds, shifted by a constant where the configuration says so.

Read once per cycle, in the shell, and passed down. The demo shifts the tower's clock by a random hour: nothing may change.
"""

import time
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Clock:
    offset_ns: int = 0

    def now_ns(self) -> int:
        return time.monotonic_ns() + self.offset_ns


def utc_minus_monotonic_ns() -> int:
    """Offset from the unshifted monotonic clock to Unix time, read once at start: for file names and recordings only."""
    return time.time_ns() - time.monotonic_ns()
