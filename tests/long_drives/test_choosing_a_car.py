"""A real `tower drive` with two cars to choose from, on a screen, with real keys: join one, leave it, join the other, leave."""

import os
import subprocess
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from benchmarks import person_at_keyboard
from benchmarks.rig import tower_drive
from benchmarks.two_cars import two_cars
from wire.clock import Clock
from wire.configuration import read_sections
from wire.link import open_link
from wire.settings import WireSettings
from wire.topics import Role

MISSING = person_at_keyboard.missing_programs()
pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(bool(MISSING), reason=f"needs {MISSING}: apt-get install xvfb xdotool"),
]
AGAIN_S, PATIENCE_S = 1.0, 60.0


def test_a_car_is_joined_left_and_another_joined_from_the_page(tmp_path: Path):
    log = tmp_path / "drive.log"

    def said(words: str) -> int:
        return log.read_text().count(words) if log.exists() else 0

    with person_at_keyboard.virtual_display() as display, two_cars(tmp_path) as config:
        environment = {name: value for name, value in os.environ.items() if name != "SDL_VIDEODRIVER"} | {"DISPLAY": display}

        def press_until(done: Callable[[], object], *keys: str) -> None:
            """Again and again: what is not open yet does not hear."""
            until = time.monotonic() + PATIENCE_S
            while not done():
                assert time.monotonic() < until, log.read_text()
                subprocess.run(["xdotool", "key", *keys], env=environment, check=False)
                time.sleep(AGAIN_S)

        with tower_drive(config, tmp_path, environment) as drive:
            press_until(lambda: said("driving car-2"), "Down", "Return")
            wait_for_its_window(config, log, "car-2")
            press_until(lambda: said("choose a car") == 2, "Escape", "Escape")
            press_until(lambda: said("driving car-1"), "Up", "Return")
            wait_for_its_window(config, log, "car-1")
            press_until(lambda: drive.poll() is not None, "Escape", "Escape")
            assert drive.returncode == 0
    assert said("ended") == said("window ended (exit 0)") == 2, log.read_text()


def wait_for_its_window(config: Path, log: Path, vehicle_id: str) -> None:
    """Until the window shows that car: a lease is held there by ann."""
    folder = Path(log.read_text().rpartition("logs in ")[2].strip()).parent
    wire: WireSettings = read_sections(folder / "drive.toml", {"wire": WireSettings})["wire"]
    assert wire.link.vehicle_id == vehicle_id
    stop = threading.Event()
    late = threading.Timer(PATIENCE_S, stop.set)
    late.start()
    with open_link(wire.link, Role.TOWER_OBSERVER, Clock(), stop) as link:
        status, window = link.level("gateway_status"), link.level("window_status")
        while window.get() is None or (heard := status.get()) is None or heard.message.lease_holder != "ann":
            assert not stop.wait(0.1), f"{vehicle_id} was never shown"
    late.cancel()
