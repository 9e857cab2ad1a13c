"""The clock of a process: monotonic, integer nanoseconds, shifted by a constant and slowed down where the configuration says so.

Read once per cycle, in the shell, and passed down. The demo shifts the tower's clock by a random hour: nothing may change. On a
machine that cannot simulate a drive in real time it slows the clocks of all programs: their loops then have as much more time for
a cycle. What is not ours goes on in real time: the network, WebRTC, the link's library, and a person.
"""

import time
from dataclasses import dataclass

from wire.settings import ClockSettings


@dataclass(frozen=True, slots=True)
class Clock:
    """real_time_factor: of a second how much passes on this clock; slowed_since_ns: where on the system's it began to be slower."""

    offset_ns: int = 0
    real_time_factor: float = 1.0
    slowed_since_ns: int = 0

    def now_ns(self) -> int:
        return self.at_system_ns(time.monotonic_ns())

    def at_system_ns(self, system_ns: int) -> int:
        """What it shows when the system's monotonic clock shows this."""
        if self.real_time_factor == 1.0:
            return system_ns + self.offset_ns
        return self.slowed_since_ns + int((system_ns - self.slowed_since_ns) * self.real_time_factor) + self.offset_ns

    def system_ns(self, now_ns: int) -> int:
        """What the system's monotonic clock shows when this one shows `now_ns`."""
        since_ns = now_ns - self.offset_ns - self.slowed_since_ns
        return self.slowed_since_ns + (since_ns if self.real_time_factor == 1.0 else int(since_ns / self.real_time_factor))

    def real_s(self, duration_ns: int) -> float:
        """How long that takes, for whoever has to wait for it."""
        return duration_ns / 1e9 / self.real_time_factor


def car_clock(settings: ClockSettings) -> Clock:
    return Clock(0, settings.real_time_factor, settings.slowed_since_ns)


def tower_clock(settings: ClockSettings) -> Clock:
    return Clock(settings.tower_offset_ns, settings.real_time_factor, settings.slowed_since_ns)


def utc_minus_monotonic_ns() -> int:
    """Offset from the unshifted monotonic clock to Unix time, read once at start: for file names and recordings only."""
    return time.time_ns() - time.monotonic_ns()
