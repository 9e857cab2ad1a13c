"""What a process and its machine have spent: CPU seconds, and the time that was taken away from the machine.

Source: proc(5), /proc/stat, the line "cpu", eighth figure ("steal": time in other operating systems under a hypervisor).
Reading it takes some 5 us here, so a control loop may do it once a second.
"""

import os
import time

_helpers: list[int] = []  # processes that do this one's work, by their number
_STEAL = 8  # column of the line "cpu  user nice system idle iowait irq softirq steal ..."
_LINE_BYTES = 512  # the first line is far shorter


def count_helper(pid: int) -> None:
    """A process of our own whose CPU time counts as this one's from now on."""
    _helpers.append(pid)


def process_cpu_s() -> float:
    """CPU seconds of this process since it started, all its threads, user and kernel, and of its helpers (in steps of 10 ms)."""
    return time.process_time() + sum(map(_cpu_s_of, _helpers))


def _cpu_s_of(pid: int) -> float:
    """Of another process, user and kernel; 0 when it is gone. Source: proc(5), /proc/pid/stat, fields 14 and 15."""
    try:
        with open(f"/proc/{pid}/stat", "rb") as file:
            after_name = file.read().rpartition(b")")[2].split()
    except OSError:
        return 0.0
    return (int(after_name[11]) + int(after_name[12])) / os.sysconf("SC_CLK_TCK")


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
