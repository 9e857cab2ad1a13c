"""pygame's events as controls, without a screen and without a sound device."""

import os
from collections.abc import Iterator

import pygame
import pytest

from tower.window.keys import Control
from tower.window.screen import Screen
from tower.window.settings import WindowSettings
from tower.window.sounds import Player
from wire.messages.vehicle import Mode

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")  # before pygame opens anything
os.environ.setdefault("SDL_AUDIODRIVER", "dummy")


@pytest.fixture
def screen() -> Iterator[Screen]:
    with Screen(WindowSettings(width_px=640, height_px=360)) as opened:
        opened.presses()
        yield opened


def test_key_down_events_become_controls_in_order_and_other_keys_nothing(screen: Screen) -> None:
    for key in (pygame.K_SPACE, pygame.K_F5, pygame.K_RETURN, pygame.K_KP_ENTER, pygame.K_ESCAPE):
        pygame.event.post(pygame.event.Event(pygame.KEYDOWN, key=key))
    assert screen.presses() == (Control.STOP, Control.ACCEPT, Control.ACCEPT, Control.QUIT)
    assert screen.presses() == ()


def test_closing_the_window_asks_like_esc(screen: Screen) -> None:
    pygame.event.post(pygame.event.Event(pygame.QUIT))
    assert screen.presses() == (Control.QUIT,)


def test_without_a_screen_it_is_drawn_at_the_size_asked_for_and_nothing_is_held(screen: Screen) -> None:
    assert screen.surface.get_size() == (640, 360)
    assert screen.held() == frozenset()
    screen.flip()


def test_the_alarm_sounds_as_long_as_the_car_asks_and_stops_with_the_request(screen: Screen) -> None:
    player = Player(True, 0.0)
    player.hear(Mode.TAKEOVER_REQUESTED)
    assert pygame.mixer.get_busy()
    player.hear(Mode.AUTONOMOUS)  # withdrawn: the car drove all along, so there is nothing else to tell
    assert not pygame.mixer.get_busy()
    player.hear(Mode.SAFE_STOP)
    assert pygame.mixer.get_busy()


def test_a_player_that_may_not_sound_stays_silent(screen: Screen) -> None:
    player = Player(False, 1.0)
    for mode in Mode:
        player.hear(mode)
    assert pygame.mixer.get_init() is None
