"""The threads beside a control loop, above all those of the link's library: how they are scheduled, how many receive, what Python
keeps of them.

They carry the commands of a control loop and take the interpreter's lock, so a loop with SCHED_FIFO waits for a thread that
the system has put aside unless they have it, too. They get one priority less than the loop. Bounded by what the link carries;
should they ever run without end, the loops still go first and the kernel leaves 5 % of the time to all others
(sched_rt_runtime_us, sched(7)). Decides nothing else.
Source of the parts: zenoh-runtime 1.10 (rx, tx, acc, app, net; ZENOH_RUNTIME), measurements in benchmarks/results/reaches.md.
"""

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_ONE_RECEIVER = "(rx:(worker_threads:1))"  # Zenoh's default is two that wake each other for every message


def beneath(fifo_priority: int) -> int:
    """The priority of what serves a loop of that SCHED_FIFO priority; 0, no SCHED_FIFO, stays 0."""
    return max(fifo_priority - 1, min(fifo_priority, 1))


def for_pictures(fifo_priority: int) -> int:
    """The priority of what brings pictures to a driver, of control loops with that one: a person closes that loop.

    Below whatever serves the control loops. To be given only to what the rate of a camera bounds that itself gives way.
    """
    return max(fifo_priority // 2, min(fifo_priority, 1))


@contextmanager
def threads_with(fifo_priority: int) -> Iterator[None]:
    """Threads started inside have SCHED_FIFO for good, and so have those that they start: Linux lets them inherit it.

    The calling thread is afterwards as it was before. 0, or a system that does not allow it: nothing is changed.
    """
    if fifo_priority == 0 or not hasattr(os, "sched_setscheduler"):
        yield
        return
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(fifo_priority))
    except OSError:
        yield
        return
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


def raise_plain_threads(fifo_priority: int) -> None:
    """Give SCHED_FIFO to every thread that Python knows of in this process and that is scheduled as everybody else.

    Each takes the interpreter's lock now and then. On a machine full of pictures, which have SCHED_FIFO as well, it may then wait
    for most of a second to go on, and the loop with it. Threads that start later are not meant. 0, or not allowed: nothing changes.
    """
    if fifo_priority == 0 or not hasattr(os, "sched_setscheduler"):
        return
    own = threading.get_native_id()
    for thread in threading.enumerate():
        if thread.native_id is not None and thread.native_id != own:
            with suppress(OSError):  # ended meanwhile
                if os.sched_getscheduler(thread.native_id) == os.SCHED_OTHER:
                    os.sched_setscheduler(thread.native_id, os.SCHED_FIFO, os.sched_param(fifo_priority))


def receive_on_one_thread() -> None:
    """For a client, before its first session. A hub keeps two: one may wait for a reader that is slow to take events."""
    os.environ.setdefault("ZENOH_RUNTIME", _ONE_RECEIVER)


class Known(threading.local):
    """Touch `here` in a callback: from then on Python keeps what it knows of that thread.

    Otherwise it makes and throws away a thread state, with a stack of its own, for every single message (PEP 311:
    PyGILState_Ensure counts; one that is never released keeps the state).
    """

    def __init__(self) -> None:
        self.here = ctypes.pythonapi.PyGILState_Ensure()
