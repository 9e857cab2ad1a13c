"""A person drives the demo past the site, by real keys and by a real gamepad: by what the window shows, never by a timetable."""

import json
import os
import threading
import time

import pytest

from benchmarks import person_at_gamepad, person_at_keyboard
from benchmarks.rig import driving, driving_with, read_referee
from recordings.read import open_recording
from wire.configuration import read_sections
from wire.messages.vehicle import Mode
from wire.settings import WireSettings

DRIVE_S = 150.0
MISSING = person_at_keyboard.missing_programs()
pytestmark = pytest.mark.long


def wire_of(folder):
    return read_sections(folder / "session.toml", {"wire": WireSettings})["wire"]


def who_drove(folder):
    """Devices whose wheel was the operator's, and the modes until the goal was reached."""
    goal_ns = next(said.stamp_ns for said in read_referee(folder) if said.goal_reached)
    with open_recording(folder / "drive.mcap") as recording:
        devices = {told.device for _, told in recording.messages("operator_status") if told.wheel_phase == "active"}
        return devices, {status.mode for _, status in recording.messages("gateway_status") if status.stamp_ns <= goal_ns}


@pytest.mark.skipif(bool(MISSING), reason=f"needs {MISSING}: apt-get install xvfb xdotool")
@pytest.mark.parametrize("scenario", ["closed_road", "reseeded"])
def test_a_person_with_a_keyboard_brings_the_car_past_the_site_and_to_its_goal(tmp_path, scenario):
    done = threading.Event()
    with person_at_keyboard.virtual_display() as display:
        environment = {name: value for name, value in os.environ.items() if name != "SDL_VIDEODRIVER"} | {"DISPLAY": display}
        with driving(tmp_path, "--scenario", scenario, environment=environment) as running:
            person = threading.Thread(target=person_at_keyboard.drive, args=(wire_of(running.folder), display, done))
            person.start()
            code = running.wait(DRIVE_S)
            done.set()
            person.join()
    summary = json.loads((running.folder / "summary.json").read_text())
    assert (code, summary["goal_reached"], summary["collisions"], len(summary["takeovers"])) == (0, True, 0, 1), running.said()
    assert who_drove(running.folder)[0] == {"keyboard"}


@pytest.mark.skipif(bool(MISSING), reason=f"needs {MISSING}: apt-get install xvfb xdotool")
def test_a_person_with_a_gamepad_brings_the_car_past_the_site_and_to_its_goal(tmp_path):
    done = threading.Event()
    with driving_with(tmp_path, "closed_road", person_at_gamepad.__file__) as (folder, observer):
        person = threading.Thread(target=person_at_gamepad.drive, args=(wire_of(folder), folder, done))
        person.start()
        until = time.monotonic() + DRIVE_S
        while time.monotonic() < until and not (observer.referee and observer.referee.goal_reached):
            observer.news.wait(0.5)
            observer.news.clear()
        done.set()
        person.join()
    (last,) = read_referee(folder)[-1:]
    devices, modes = who_drove(folder)
    assert (last.goal_reached, last.collisions) == (True, 0)
    assert devices == {"gamepad (Virtual pad)"}
    assert Mode.REMOTE in modes and Mode.SAFE_STOP not in modes
