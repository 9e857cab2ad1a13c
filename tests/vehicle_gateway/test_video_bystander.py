"""A process without a priority that tells how long it waits for the processor.

The stories run as programs of their own (this file, as a script): it is forked, which pytest with its threads must not be.
"""

import multiprocessing
import os
import signal
import subprocess
import sys
import time

from vehicle_gateway.video.bystander import PERIOD_NS, bystander

STOPPED_S = 0.4


def wait_for_lateness_between(least_s: float, most_s: float, late) -> None:
    until_s = time.monotonic() + 20.0
    while not least_s <= late() / 1e9 <= most_s:
        assert time.monotonic() < until_s, late()
        time.sleep(0.01)


def be_stopped_for_a_while() -> None:
    with bystander() as others:
        (process,) = multiprocessing.active_children()
        wait_for_lateness_between(-1.0, PERIOD_NS / 2e9, others.late_ns)
        os.kill(process.pid, signal.SIGSTOP)
        wait_for_lateness_between(STOPPED_S, 20.0, others.late_ns)  # told while it waits, not only afterwards
        woken_ns = others._told[0]
        os.kill(process.pid, signal.SIGCONT)
        wait_for_lateness_between(0.0, 20.0, lambda: int(others._told[0] - woken_ns) - PERIOD_NS)  # it has woken again
        assert others.late_ns() / 1e9 >= STOPPED_S - PERIOD_NS / 1e9, "the worst of the last second"
        wait_for_lateness_between(-1.0, PERIOD_NS / 2e9, others.late_ns)  # forgotten after it
    assert process.exitcode == 0
    print("ended")


def wait_to_be_killed() -> None:
    with bystander():
        print("runs", flush=True)
        sys.stdin.read()


def test_it_tells_how_late_it_is_and_was_in_the_last_second() -> None:
    command = [sys.executable, __file__, "be_stopped_for_a_while"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=False)
    assert done.stdout == "ended\n", done.stderr


def test_it_ends_when_the_program_is_killed() -> None:
    command = [sys.executable, __file__, "wait_to_be_killed"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout.readline() == "runs\n"
        program.kill()
        assert program.stdout.read() == ""  # it ends when nobody holds its other end any more


if __name__ == "__main__":
    globals()[sys.argv[1]]()
