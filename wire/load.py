"""What a process and its machine have spent: CPU seconds, and the time that was taken away from the machine.

Source: proc(5), /proc/stat, the line "cpu", eighth figure ("steal": time in other operating systems under a hypervisor).
Reading it takes some 5 us here, so a control loop may do it once a second.
"""

import os
import time

_STEAL = 8  # column of the line "cpu  user nice system idle iowait irq softirq steal ..."
_LINE_BYTES = 512  # the first line is far shorter


def process_cpu_s() -> float:
    """CPU seconds of this process since it started, all its threads, user and kernel."""
    return time.process_time()


def stolen_s() -> float | None:
    """CPU seconds the machine wanted and did not get since it booted, all cores; None where the system does not tell."""
    try:
        descriptor = os.open("/proc/stat", os.O_RDONLY)
    except OSError:
        return None
    try:
        return stolen_in(os.read(descriptor, _LINE_BYTES), os.sysconf("SC_CLK_TCK"))
    finally:
        os.close(descriptor)


def stolen_in(stat: bytes, ticks_per_s: int) -> float | None:
    """The stolen seconds in the content of /proc/stat; None when it does not say."""
    columns = stat.partition(b"\n")[0].split()
    if len(columns) <= _STEAL or columns[0] != b"cpu" or not columns[_STEAL].isdigit():
        return None
    return int(columns[_STEAL]) / ticks_per_s
