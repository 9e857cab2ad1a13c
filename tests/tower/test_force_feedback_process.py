import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.force_feedback import Effects, ForceFeedbackSettings
from tower.devices.force_feedback import PACKET, ForceFeedback, Forces, command, pack
from tower.devices.force_feedback_process import newest_packet

NUMBERS = st.floats(-1.0, 1.0)
EFFECTS = st.builds(Effects, spring=NUMBERS, spring_max=NUMBERS, centre=NUMBERS, damper=NUMBERS, constant=NUMBERS)


@given(st.lists(EFFECTS, max_size=5), st.integers(0, PACKET.size - 1))
def test_of_many_packets_the_newest_whole_one_counts_and_a_piece_waits(sent: list[Effects], piece: int):
    data = b"".join(map(pack, sent)) + pack(Effects(constant=0.5))[:piece]
    newest, rest = newest_packet(data)
    assert newest == (sent[-1] if sent else None)
    assert rest == pack(Effects(constant=0.5))[:piece]


def test_a_wheel_that_cannot_be_opened_is_one_line_with_a_fix_and_no_traceback():
    pytest.importorskip("evdev")
    ended = subprocess.run(
        [sys.executable, "-m", "tower.program", "force-feedback", "/dev/input/event-none"],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )
    assert ended.returncode == 1
    assert ended.stderr.strip().splitlines() == [
        "force feedback: /dev/input/event-none: No such file or directory; is the udev rule installed?"
    ]


def test_a_process_that_is_gone_never_holds_up_the_loop():
    forces = ForceFeedback(command("/dev/input/event-none", 1, ForceFeedbackSettings()))
    until, now_ns, longest = time.monotonic() + 30, 0, 0.0
    while not forces.ended and time.monotonic() < until:
        now_ns += 50_000_000
        begun = time.monotonic()
        forces.feel(Effects(constant=0.1), now_ns)
        longest = max(longest, time.monotonic() - begun)
    assert forces.ended
    forces.feel(Effects(), now_ns)
    forces.close()
    assert longest < 1.0


# The process as it is, but for the wheel: what would be uploaded stands in a file, a line each: when, what, numbers.
RIM = """
import json, os, sys, threading
from haptics.force_feedback import Abilities
from tower.devices.force_feedback_process import _serve
from wire.clock import Clock

class Rim:
    can = Abilities(constant=True, spring=True)
    def upload(self, name, words):
        print(json.dumps([Clock().now_ns(), name, *words]), file=told, flush=True)

with open(sys.argv[1], "a") as told:
    print(json.dumps([Clock().now_ns(), "began", os.getpid()]), file=told, flush=True)
    _serve(Rim(), 1, 100.0, threading.Event(), Clock().now_ns)
"""
WANTED = Effects(spring=0.5, spring_max=0.4, constant=0.3)
CONSTANT, SPRING_MAX = 9830, 26214  # of it, in the kernel's words
NEARLY = CONSTANT - 160  # the last step of a force that comes in may be too small to be worth an upload
SECOND_NS = 1_000_000_000


def test_a_killed_process_is_started_again_and_its_forces_come_in_slowly(tmp_path: Path):
    told = tmp_path / "told"
    forces = Forces(lambda: ForceFeedback([sys.executable, "-c", RIM, str(told)]), 0)

    def lines() -> list[Any]:
        text = told.read_text() if told.exists() else ""
        return [json.loads(line) for line in text[: text.rfind("\n") + 1].splitlines()]

    def levels(name: str, place: int, begin: int) -> list[tuple[int, int]]:
        """(when, level) of what was uploaded since that line."""
        return [(each[0], each[place]) for each in lines()[begin:] if each[1] == name]

    def felt_until(done: Callable[[], bool]) -> None:
        for _ in range(3000):
            forces.feel(WANTED, time.monotonic_ns())
            if done():
                return
            time.sleep(0.01)
        raise AssertionError(f"it did not come: {lines()[-5:]}")

    felt_until(lambda: max(dict(levels("constant", 2, 0)).values(), default=0) > NEARLY)
    first = lines()
    os.kill(first[0][2], signal.SIGKILL)
    felt_until(lambda: "started again in 1 s" in forces.look(SECOND_NS))
    assert forces.look(SECOND_NS * 3 // 2) != "", "not before its time"
    assert len(levels("began", 2, 0)) == 1
    assert forces.look(2 * SECOND_NS) == ""
    felt_until(lambda: max(dict(levels("constant", 2, len(first))).values(), default=0) > NEARLY)
    forces.close()
    ((began_ns, pid),) = levels("began", 2, len(first))
    assert pid != first[0][2]
    for name, place, full in (("constant", 2, CONSTANT), ("spring", 3, SPRING_MAX)):
        for (before_ns, before), (after_ns, after) in pairwise([(began_ns, 0), *levels(name, place, len(first))]):
            assert after - before <= full * ((after_ns - before_ns) / 1e9 + 0.1), "never a jolt: all of it takes a second"
    forces.feel(WANTED, 0)
    assert forces.look(99 * SECOND_NS) == "", "closed, it stays closed"


def test_cockpit_window_and_tower_devices_start_where_there_is_no_evdev():
    """Nothing of it is loaded before a wheel is opened."""
    modules = "tower.program, tower.cockpit.cockpit, tower.window.joysticks, tower.devices.force_feedback_process"
    code = f"import sys, {modules}; print('evdev' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert told.stdout.strip().splitlines()[-1] == "False"
