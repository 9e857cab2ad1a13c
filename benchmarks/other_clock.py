"""`python -m benchmarks.other_clock SECONDS PROGRAM ARGUMENT...`: the program with its monotonic clock so far on, in this process.

A time namespace (time_namespaces(7)) of its own, entered before the program takes this process's place. Needs root, Linux 5.6.
"""

import ctypes
import os
import sys
from pathlib import Path

CLONE_NEWTIME = 0x80  # linux/sched.h


def enter(seconds: int) -> None:
    """Raises OSError where the kernel has no time namespaces or does not permit it."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.unshare(CLONE_NEWTIME):
        raise OSError(ctypes.get_errno(), "unshare: " + os.strerror(ctypes.get_errno()))
    Path("/proc/self/timens_offsets").write_text(f"monotonic {seconds} 0\n")
    inside = os.open("/proc/self/ns/time_for_children", os.O_RDONLY)
    if libc.setns(inside, CLONE_NEWTIME):
        raise OSError(ctypes.get_errno(), "setns: " + os.strerror(ctypes.get_errno()))


if __name__ == "__main__":
    enter(int(sys.argv[1]))
    os.execvp(sys.argv[2], sys.argv[2:])
