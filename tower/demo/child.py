"""Start a program that ends with its parent: `python -m tower.demo.child PARENT CORE PROGRAM ARGUMENT...`.

PARENT: its process number. A supervisor that is killed must not leave a driving car behind. CORE: the number of the core that
the program keeps to, or "". Linux only (prctl, sched_setaffinity); elsewhere the program just starts.
"""

import ctypes
import os
import signal
import sys

PR_SET_PDEATHSIG = 1  # linux/prctl.h


def main() -> None:
    parent = int(sys.argv[1])
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGTERM)
        if os.getppid() != parent:  # it died before we asked to be told
            sys.exit(1)
        if sys.argv[2]:
            os.sched_setaffinity(0, [int(sys.argv[2])])
    os.execv(sys.argv[3], sys.argv[3:])


if __name__ == "__main__":
    main()
