"""Somebody who does not belong (benchmarks.intruder), in a site's namespace: got ready beforehand, let loose at the instant."""

import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from benchmarks.fault_arms import Arm, Armed, End, nothing
from benchmarks.intruder import READY
from benchmarks.warm_rig import WarmRig, run_in, wait_for_line

READY_S = 30.0  # his program on a busy machine


def intruder(what: str, at_tower: bool) -> Arm:
    @contextmanager
    def arm(rig: WarmRig) -> Iterator[Armed]:
        with intruding(rig, what, at_tower) as begin:

            def hurt(rig: WarmRig) -> End:
                begin()
                return nothing

            yield Armed(hurt)

    return arm


@contextmanager
def intruding(rig: WarmRig, what: str, at_tower: bool) -> Iterator[Callable[[], None]]:
    """Ready; the call lets him loose."""
    site = rig.sites.tower if at_tower else rig.sites.car
    elsewhere = 19 if at_tower else 0  # from a computer of its own he would take no time from the car's
    process = run_in(site, "benchmarks.intruder", what, str(site.config), niceness=elsewhere)
    try:
        wait_for_line(process, READY, READY_S)
        yield lambda: process.send_signal(signal.SIGUSR1)
    finally:
        process.terminate()
        try:
            process.wait(10.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
