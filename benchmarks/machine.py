"""The machine under a measurement: scheduling of this thread, CPU time of processes."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from wire.pace import raise_priority

TICKS_PER_S = os.sysconf("SC_CLK_TCK")


@contextmanager
def priority(fifo_priority: int) -> Iterator[str]:
    """This thread with SCHED_FIFO inside the context where the system allows it; what came of it, in words. 0: plain."""
    scheduling = raise_priority(fifo_priority)
    try:
        yield "plain" if fifo_priority == 0 else scheduling
    finally:
        if scheduling.startswith("fifo"):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))


def cpu_s(pid: int) -> float:
    """User and system time of a process so far (proc(5): fields 14 and 15)."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / TICKS_PER_S
