"""A real `tower drive` on a screen: the checklist worked with real keys until every item is measured, then the car is driven."""

import os
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from benchmarks import person_at_keyboard
from benchmarks.person import Person
from benchmarks.rig import read_referee, standing_car, tower_drive
from tower.window.sounds import Sound, waveform
from wire.configuration import read_sections
from wire.messages.vehicle import Mode
from wire.settings import WireSettings

MISSING = person_at_keyboard.missing_programs()
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {MISSING}: apt-get install xvfb xdotool"),
]
CHECK_S, DRIVE_S, DRIVEN_M = 90.0, 60.0, 15.0
ITEMS = {"wheel", "brake", "STOP", "sound", "cameras", "latency"}


def test_every_item_is_passed_by_measurement_none_of_it_counts_and_the_car_is_taken_over(tmp_path):
    """No sound device: SDL writes the sound to a file, and there the alarm stands."""
    played = tmp_path / "sound.raw"
    done = threading.Event()
    with person_at_keyboard.virtual_display() as display, standing_car(tmp_path, "short") as (folder, observer):
        environment = {name: value for name, value in os.environ.items() if name != "SDL_VIDEODRIVER"}
        environment |= {"DISPLAY": display, "SDL_AUDIODRIVER": "disk", "SDL_DISKAUDIOFILE": str(played)}
        config = folder / "session.toml"
        wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
        with tower_drive(config, tmp_path, environment):
            late = threading.Timer(CHECK_S, done.set)
            late.start()
            checks = person_at_keyboard.check(wire, display, done)
            late.cancel()
            assert checks == dict.fromkeys(ITEMS, "passed"), (tmp_path / "drive.log").read_text()
            status = observer.status
            assert status is not None
            assert (status.mode, status.stop_number, status.stops_in_ten_minutes) == (Mode.STOPPED, 1, 0)
            driver = threading.Thread(target=person_at_keyboard.drive, args=(wire, display, done, Person(sets_off=True)))
            driver.start()
            until = time.monotonic() + DRIVE_S
            while time.monotonic() < until and not (observer.referee and observer.referee.distance_m > DRIVEN_M):
                observer.news.wait(0.5)
                observer.news.clear()
            done.set()
            driver.join()
    last = read_referee(folder)[-1]
    assert last.distance_m > DRIVEN_M and last.collisions == 0
    assert alarm_share(played) > 0.99


def alarm_share(file: Path) -> float:
    """How much of what was played at its loudest place is the alarm: the largest correlation of the two, 1 when equal in shape."""
    sound = np.fromfile(file, dtype=np.int16)[::2].astype(float)
    alarm = waveform(Sound.REQUEST)[:, 0].astype(float)
    size = len(sound) + len(alarm)
    match = np.fft.irfft(np.fft.rfft(sound, size) * np.conj(np.fft.rfft(alarm, size)), size)
    begin = int(np.argmax(match[: len(sound)]))
    part = sound[begin : begin + len(alarm)]
    alarm = alarm[: len(part)]
    return float(np.dot(part, alarm) / np.sqrt(np.dot(part, part) * np.dot(alarm, alarm)))
