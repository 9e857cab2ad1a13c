"""How those fare who have no priority: a process that does nothing but wake up, and how late it did.

A process and not a thread: a thread that has to wait for the processor may hold the interpreter meanwhile, and then everything
that shows pictures waits with it, whatever priority it has.
"""

import mmap
import multiprocessing
import signal
import time
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

from wire.load import count_helper

PERIOD_NS = 100_000_000
_KEPT = 10  # a second of them
END_S = 2.0
_WOKEN, _LATE = 0, 1  # places in the shared memory: when it woke last, and its worst lateness of the last second (ns)


Times = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


class Bystander:
    def __init__(self, told: Times) -> None:
        self._told = told

    def late_ns(self) -> int:
        """The most that it woke late in the last second, or is late now."""
        return max(int(self._told[_LATE]), time.monotonic_ns() - int(self._told[_WOKEN]) - PERIOD_NS)


@contextmanager
def bystander() -> Iterator[Bystander]:
    """A running one. To be entered while the process has one thread; leaving ends it, and so does the end of this process."""
    context = multiprocessing.get_context("fork")
    told = np.frombuffer(mmap.mmap(-1, mmap.PAGESIZE), np.int64)
    told[_WOKEN] = time.monotonic_ns()
    ours, theirs = context.Pipe()
    process = context.Process(target=_stand_by, args=(theirs, ours, told), name="bystander", daemon=True)
    process.start()
    count_helper(process.pid or 0)
    theirs.close()
    try:
        yield Bystander(told)
    finally:
        ours.close()
        process.join(END_S)


def _stand_by(pipe: Connection, other_end: Connection, told: Times) -> None:
    with suppress(OSError):
        Path("/proc/self/comm").write_text(multiprocessing.current_process().name)  # as `top` shows it
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # sent to the whole group: the pipe tells when to end
    other_end.close()
    late = deque([0], maxlen=_KEPT)
    due_ns = int(told[_WOKEN]) + PERIOD_NS
    while not pipe.poll(max(due_ns - time.monotonic_ns(), 0) / 1e9):
        now_ns = time.monotonic_ns()
        late.append(now_ns - due_ns)
        told[_WOKEN], told[_LATE] = now_ns, max(late)
        due_ns = max(due_ns + PERIOD_NS, now_ns)
