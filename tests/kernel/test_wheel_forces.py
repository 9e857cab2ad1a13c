"""A wheel's reader and its force-feedback process alone, on a G920 that is a real input device (g920.py): what they read, upload,
play, and let go of when the cockpit falls silent or is gone. Pulling it out: test_wheel.py."""

import json
import os
import signal
import subprocess
import threading
from collections.abc import Iterator

import pytest

from haptics.force_feedback import Effects, ForceFeedbackSettings
from tower.cockpit.devices import View
from tower.cockpit.wheel import WheelDevice
from tower.devices.finder import Finder, opened
from wire.clock import Clock

STEERING, THROTTLE, BRAKE, DEAD_MAN = 0, 1, 2, 293  # evdev codes
TICK_S = 0.004
FELT = Effects(spring=0.5, spring_max=0.25, centre=0.1, damper=0.2, constant=-0.3)
# s16 and u16 of linux/input.h; left is positive for us, the wheel's own position grows to the right
CONSTANT, SPRING, DAMPER = [-9830], [16384, 16384, -3277], [6553, 65535, 0]
WORTH = 320  # forces come in slowly, and their last step may be too small to be worth an upload (haptics.effect_words)


class G920:
    def __init__(self, start) -> None:
        self.said: list[dict] = []
        self._process = start("g920.py", piped=True)
        self._reader = threading.Thread(target=self._listen)
        self._reader.start()

    def _listen(self) -> None:
        for line in self._process.stdout:
            self.said.append(json.loads(line))

    def do(self, *words: object) -> None:
        print(*words, file=self._process.stdin, flush=True)

    def end(self) -> None:
        self._process.kill()
        self._process.wait()
        self._reader.join()

    def renders(self, effect: str) -> list[int] | None:
        return next((each["words"] for each in reversed(self.said) if each.get("effect") == effect), None)

    def first(self, effect: str) -> list[int]:
        return next(each["words"] for each in self.said if each.get("effect") == effect)

    def plays(self) -> list[tuple[int, int]]:
        return sorted((each["id"], each["value"]) for each in self.said if each["what"] == "play")

    def settings(self) -> list[tuple[str, int]]:
        return [(each["what"], each["value"]) for each in self.said if each["what"] in ("gain", "autocentre")]


def forces_process() -> int:
    """The process that renders the wheel's forces."""
    found = subprocess.run(["pgrep", "-f", "tower.program force-feedback"], capture_output=True, text=True, check=True)
    return int(found.stdout.split()[0])


@pytest.fixture
def wheel(start) -> Iterator[G920]:
    it = G920(start)
    it.do("plug")
    yield it
    it.end()


@pytest.fixture
def finder() -> Finder:
    return Finder({}, lambda node: opened(node, {}, ForceFeedbackSettings()))


def felt(device: WheelDevice, wheel: G920) -> bool:
    """Feel once; whether the wheel renders all of it."""
    device.feel(FELT, Clock().now_ns())
    rendered = [wheel.renders(each) or [] for each in ("constant", "spring", "damper")]
    return rendered == [pytest.approx(words, abs=WORTH) for words in (CONSTANT, SPRING, DAMPER)]


def test_it_is_read_and_rendered_and_let_go(wheel: G920, finder: Finder, until) -> None:
    until(lambda: finder.look() or finder.arrived, "the wheel is found")
    device = finder.arrived.popleft()
    assert (device.can.constant, device.can.spring, device.can.damper) == (True, True, True)

    def has_spoken() -> bool:
        device.read(View(), TICK_S, Clock().now_ns())
        return not device.missing and device.readings.touched

    wheel.do("button", DEAD_MAN, 1)  # first: once the axes have spoken it has been read as well
    for axis, value in ((STEERING, 16384), (THROTTLE, 255), (BRAKE, 128)):
        wheel.do("axis", axis, value)
    until(has_spoken, "rim, pedals and paddle are read")
    now = device.step(View(), 0.0, TICK_S, Clock().now_ns())
    assert (now.dead_man, now.throttle, now.brake) == (True, 0.0, pytest.approx(127 / 255))
    assert now.wheel.angle_rad == pytest.approx(3.927, abs=0.01)  # a quarter of 900 degrees to the left
    assert now.event_ns <= Clock().now_ns()

    until(lambda: felt(device, wheel), "the wheel renders what is wanted")
    until(lambda: len(wheel.plays()) == 3, "each effect is played")
    assert wheel.plays() == [(0, 1), (1, 1), (2, 1)]  # once each, however often they were changed
    assert wheel.settings() == [("gain", 0xFFFF), ("autocentre", 0)]

    os.kill(forces_process(), signal.SIGKILL)
    wheel.said.clear()
    until(lambda: "started again" in (finder.look() or finder.note), "its process is killed: said, with the time it comes back")
    until(lambda: finder.look() or felt(device, wheel), "and the wheel renders all of it again")
    assert abs(wheel.first("constant")[0]) < abs(CONSTANT[0]) / 2, "it comes in slowly"

    until(lambda: wheel.renders("constant") == [0], "a cockpit that hangs: the forces go")
    until(lambda: wheel.renders("spring")[1] == 0, "the spring as well")
    wheel.said.clear()
    device.close()
    until(lambda: sum(each["what"] == "erase" for each in wheel.said) == 3, "a cockpit that is gone: the effects are erased")
    until(lambda: wheel.settings() == [("gain", 0xFFFF), ("autocentre", 0)], "and what outlives them is reset")
