"""Who inherits a priority, and that nobody else does. What needs SCHED_FIFO is skipped where the system does not allow it."""

import os
import subprocess
import sys
import threading

import pytest

from tests.scheduling import needs_fifo
from wire.link_threads import beneath, for_pictures, threads_with


def of_a_new_thread() -> tuple[int, int]:
    """Policy and priority that a thread started now has."""
    seen: list[tuple[int, int]] = []
    thread = threading.Thread(target=lambda: seen.append((os.sched_getscheduler(0), os.sched_getparam(0).sched_priority)))
    thread.start()
    thread.join()
    return seen[0]


@pytest.mark.parametrize(("loop", "served"), [(0, 0), (1, 1), (2, 1), (10, 9), (50, 49)])
def test_what_serves_a_loop_stands_one_below_it_and_never_becomes_plain(loop: int, served: int):
    assert beneath(loop) == served


@pytest.mark.parametrize("loop", range(51))
def test_pictures_have_a_priority_where_loops_have_one_and_never_one_above_what_serves_a_loop(loop: int):
    assert (for_pictures(loop) > 0) == (loop > 0)
    assert for_pictures(loop) <= beneath(loop)
    assert loop < 4 or for_pictures(loop) < beneath(loop)


@needs_fifo
def test_a_thread_started_inside_has_the_priority_and_so_have_those_that_it_starts():
    grandchild: list[tuple[int, int]] = []
    with threads_with(3):
        assert of_a_new_thread() == (os.SCHED_FIFO, 3)
        child = threading.Thread(target=lambda: grandchild.append(of_a_new_thread()))
        child.start()
    child.join()
    assert grandchild == [(os.SCHED_FIFO, 3)]


@pytest.mark.parametrize("priority", [0, 3, 1000])
def test_the_calling_thread_is_afterwards_as_it_was_before(priority: int):
    before = (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority)
    with threads_with(priority):
        pass
    assert (os.sched_getscheduler(0), os.sched_getparam(0).sched_priority) == before
    assert of_a_new_thread() == before


@pytest.mark.parametrize("priority", [0, 1000])
def test_without_a_priority_or_with_one_that_is_refused_threads_are_plain(priority: int):
    with threads_with(priority):
        assert of_a_new_thread()[0] == os.SCHED_OTHER


# In a process of its own: the threads of this one are the test runner's.
LOOP = """
import os, sys, threading
from wire.clock import Clock
from wire.link_threads import threads_with
from wire.pace import Pace

end = threading.Event()
plain, ranked = threading.Thread(target=end.wait), threading.Thread(target=end.wait)
plain.start()
with threads_with(2):
    ranked.start()
with Pace(0.01, Clock(), end, fifo_priority=int(sys.argv[1])):
    print(*(os.sched_getparam(thread.native_id).sched_priority for thread in (threading.main_thread(), plain, ranked)))
end.set()
"""


@needs_fifo
@pytest.mark.parametrize(("loop", "told"), [("10", "10 9 2"), ("0", "0 0 2")])
def test_no_thread_beside_a_loop_with_a_priority_can_be_put_aside_with_the_interpreter_s_lock(loop: str, told: str):
    done = subprocess.run([sys.executable, "-c", LOOP, loop], capture_output=True, text=True, timeout=20.0, check=False)
    assert done.stdout.strip() == told, done.stderr
