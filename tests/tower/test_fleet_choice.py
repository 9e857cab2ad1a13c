"""The page of the cars with two real gateways: each is shown as it is, the marked one is joined, and nothing is held afterwards."""

import os
import threading

import pygame

from benchmarks.two_cars import two_cars
from tower.settings import TowerSettings
from tower.window.choosing import choose
from wire.clock import Clock
from wire.configuration import read_sections
from wire.settings import WireSettings

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("SDL_AUDIODRIVER", "dummy")


def test_of_two_real_cars_the_marked_one_is_joined_as_soon_as_it_is_there(tmp_path):
    """Fingers press down and Enter again and again: until the car is heard of, Enter is refused."""
    with two_cars(tmp_path) as config:
        sections = read_sections(config, {"wire": WireSettings, "tower": TowerSettings})
        stop, done = threading.Event(), threading.Event()

        def press() -> None:
            for _ in range(100):
                if done.wait(0.3):
                    return
                for key in (pygame.K_DOWN, pygame.K_RETURN) if pygame.display.get_init() else ():
                    pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
            stop.set()

        fingers = threading.Thread(target=press)
        fingers.start()
        joined = choose(sections["wire"].link, sections["tower"].window, Clock(), stop, "car-1")
        done.set()
        fingers.join()
        assert joined == "car-2"
        assert not pygame.display.get_init()
