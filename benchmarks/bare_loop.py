"""The floor of every loop: sleeps until a deadline each 10 ms and does nothing. `python -m benchmarks.bare_loop FIFO_PRIORITY`.

Told to end (SIGTERM), it prints how many cycles were later than one period, and the worst lateness, as JSON.
"""

import json
import signal
import sys
import threading

from wire.clock import Clock
from wire.pace import Pace

PERIOD_S = 0.01  # of the gateway, the automation and the ECU


def main() -> None:
    stop, clock = threading.Event(), Clock()
    signal.signal(signal.SIGTERM, lambda *_: stop.set())
    worst_ns, last_ns = 0, 0
    with Pace(PERIOD_S, clock, stop, fifo_priority=int(sys.argv[1])) as pace:
        for now_ns in pace:
            worst_ns = max(worst_ns, now_ns - last_ns - round(PERIOD_S * 1e9)) if last_ns else 0
            last_ns = now_ns
        lateness = pace.lateness
    print(json.dumps({"cycles": lateness.cycles, "late_cycles": lateness.late_cycles, "worst_ms": worst_ns / 1e6}))


if __name__ == "__main__":
    main()
