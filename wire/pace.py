"""A fixed-rate loop: absolute deadlines, missed ticks skipped and never made up in a burst, its own lateness kept.

Source of the method: reference measurements of Linux timers under load; priority matters about forty times more than method.
"""

import gc
import os
import secrets
import sys
import threading
from collections import deque
from collections.abc import Iterator, Mapping
from types import TracebackType

from wire.clock import Clock
from wire.link_threads import beneath, raise_plain_threads
from wire.load import process_cpu_s
from wire.messages.health import LoopHealth

_SWITCH_S = 0.0005  # ours: a tenth of Python's own
_INSTANCE = secrets.token_hex(4)  # of this start of this program


def raise_priority(fifo_priority: int) -> str:
    """Give the calling thread SCHED_FIFO where the system allows it; says in words what came of it."""
    if fifo_priority == 0 or not hasattr(os, "sched_setscheduler"):
        return scheduling()
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | getattr(os, "SCHED_RESET_ON_FORK", 0), os.sched_param(fifo_priority))
    except OSError as error:
        return f"other (fifo {fifo_priority} refused: {error.strerror})"
    return f"fifo {fifo_priority}"


def ready_for_a_loop(fifo_priority: int) -> str:
    """Rank the calling thread, and beneath it the others of the process; leave the collector nothing of the start.

    Says in words how the calling thread is scheduled.
    """
    words = raise_priority(fifo_priority)
    raise_plain_threads(beneath(fifo_priority))
    gc.collect()
    gc.freeze()  # a full collection of what start-up left behind costs tens of milliseconds
    return words


def scheduling() -> str:
    """How the calling thread is scheduled, in words."""
    if hasattr(os, "sched_getscheduler") and os.sched_getscheduler(0) & ~getattr(os, "SCHED_RESET_ON_FORK", 0) == os.SCHED_FIFO:
        return f"fifo {os.sched_getparam(0).sched_priority}"
    return "other"


class Lateness:
    """How late the cycles of a loop were, against their own deadline."""

    def __init__(self, period_ns: int) -> None:
        self.period_ns = period_ns
        self.cycles = 0
        self.late_cycles = 0
        self._recent: deque[tuple[int, int]] = deque(maxlen=1000)  # (now_ns, lateness_ns)

    def add(self, deadline_ns: int, now_ns: int) -> None:
        late = max(now_ns - deadline_ns, 0)
        self.cycles += 1
        self.late_cycles += late > self.period_ns
        self._recent.append((now_ns, late))

    def latest_ns(self, now_ns: int) -> int:
        """The most that a cycle of the last second was late; 0 when there was none."""
        return max((lateness for at, lateness in tuple(self._recent) if now_ns - at <= 1_000_000_000), default=0)

    def health(
        self,
        process: str,
        loop: str,
        now_ns: int,
        scheduling: str,
        dropped: Mapping[str, int],
        machine_stolen_s: float | None = None,
    ) -> LoopHealth:
        """What this loop says of itself, and what its process has used so far."""
        late = sorted(lateness for at, lateness in tuple(self._recent) if now_ns - at <= 1_000_000_000) or [0]
        return LoopHealth(
            stamp_ns=now_ns,
            process=process,
            loop=loop,
            period_ms=self.period_ns / 1e6,
            cycles=self.cycles,
            late_cycles=self.late_cycles,
            lateness_p50_ms=late[len(late) // 2] / 1e6,
            lateness_max_ms=late[-1] / 1e6,
            scheduling=scheduling,
            dropped=dict(dropped),
            process_cpu_s=process_cpu_s(),
            instance=_INSTANCE,
            machine_stolen_s=machine_stolen_s,
        )


class Pace:
    """`with Pace(0.01, clock, stop) as pace: for now_ns in pace: ...` - until `stop` is set."""

    def __init__(self, period_s: float, clock: Clock, stop: threading.Event, *, fifo_priority: int = 0) -> None:
        self._period_ns = round(period_s * 1e9)
        self._clock = clock
        self._stop = stop
        self._fifo_priority = fifo_priority
        self.lateness = Lateness(self._period_ns)
        self.scheduling = "other"

    def __enter__(self) -> "Pace":
        self.scheduling = ready_for_a_loop(self._fifo_priority)
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        if self._fifo_priority and self.scheduling.startswith("fifo"):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))

    def __iter__(self) -> Iterator[int]:
        deadline_ns = self._clock.now_ns()
        while True:
            remaining_ns = deadline_ns - self._clock.now_ns()
            if self._stop.wait(self._clock.real_s(max(remaining_ns, 0))):
                return
            now_ns = self._clock.now_ns()
            self.lateness.add(deadline_ns, now_ns)
            yield now_ns
            missed = max(now_ns - deadline_ns, 0) // self._period_ns  # their ticks are skipped, not made up in a burst
            deadline_ns += (missed + 1) * self._period_ns

    def health(
        self, process: str, loop: str, dropped: Mapping[str, int] | None = None, machine_stolen_s: float | None = None
    ) -> LoopHealth:
        """Lateness of the last second and counts since the start, for the topic car_health or tower_health."""
        return self.lateness.health(process, loop, self._clock.now_ns(), self.scheduling, dropped or {}, machine_stolen_s)


def share_interpreter() -> None:
    """For a process whose threads encode, decode and draw beside each other: none keeps Python's lock for long while another waits.

    Python's own 5 ms add up over four cameras. Seen in one demo each on a busy machine, so a hint and no figure: the slowest
    hundredth of the pictures on screen after 173 instead of 270 ms (2026-11-28).
    """
    sys.setswitchinterval(_SWITCH_S)
