import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.force_feedback import Effects, ForceFeedbackSettings
from tower.devices.force_feedback import PACKET, ForceFeedback, pack
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
    forces = ForceFeedback("/dev/input/event-none", 1, ForceFeedbackSettings())
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


def test_cockpit_window_and_tower_devices_start_where_there_is_no_evdev():
    """Nothing of it is loaded before a wheel is opened."""
    modules = "tower.program, tower.cockpit.cockpit, tower.window.joysticks, tower.devices.force_feedback_process"
    code = f"import sys, {modules}; print('evdev' in sys.modules)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert told.stdout.strip().splitlines()[-1] == "False"
