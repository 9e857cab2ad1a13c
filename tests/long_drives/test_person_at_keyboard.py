"""A person drives the demo past the site by pressing real keys: by what the window shows, never by a timetable."""

import json
import os
import threading

import pytest

from benchmarks.person_at_keyboard import drive, missing_programs, virtual_display
from benchmarks.rig import driving
from recordings.read import open_recording
from wire.configuration import read_sections
from wire.settings import WireSettings

DRIVE_S = 150.0


@pytest.mark.skipif(bool(missing_programs()), reason=f"needs {missing_programs()}: apt-get install xvfb xdotool")
@pytest.mark.parametrize("scenario", ["closed_road", "reseeded"])
def test_a_person_with_a_keyboard_brings_the_car_past_the_site_and_to_its_goal(tmp_path, scenario):
    done, been = threading.Event(), []
    with virtual_display() as display:
        environment = {name: value for name, value in os.environ.items() if name != "SDL_VIDEODRIVER"} | {"DISPLAY": display}
        with driving(tmp_path, "--scenario", scenario, environment=environment) as running:
            wire = read_sections(running.folder / "session.toml", {"wire": WireSettings})["wire"]
            person = threading.Thread(target=lambda: been.append(drive(wire, display, done)))
            person.start()
            code = running.process.wait(DRIVE_S)
            done.set()
            person.join()
    summary = json.loads((running.folder / "summary.json").read_text())
    assert (code, summary["goal_reached"], summary["collisions"], len(summary["takeovers"])) == (0, True, 0, 1), running.said()
    assert been[0].drove
    with open_recording(running.folder / "drive.mcap") as recording:
        assert {told.device for _, told in recording.messages("operator_status") if told.wheel_phase == "active"} == {"keyboard"}
