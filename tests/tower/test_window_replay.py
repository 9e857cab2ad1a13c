"""The window on a recording: it says so all the time, and nothing that is pressed leaves it."""

from collections import Counter
from typing import Any

import pygame
import pytest

from tower.window.display_loop import DisplayLoop
from tower.window.keys import Control
from tower.window.marks import replay_mark, slow_motion_mark
from tower.window.snapshot import SnapshotWriter
from tower.window.sounds import Player
from tower.window.sticks import Hands
from wire.latest import Latest
from wire.messages.base import Message

MS = 1_000_000
WHITE = (255, 255, 255)


class Line:
    def __init__(self) -> None:
        self.said: Counter[str] = Counter()

    def level(self, name: str) -> Latest[Any]:
        return Latest()

    def publish(self, name: str, message: Message) -> None:
        self.said[name] += 1


class NoVideo:
    refused = ""
    replaced: Counter[str] = Counter()

    def newest(self, camera: str) -> None:
        return None

    def watch(self, cameras: tuple[str, ...]) -> None: ...


class Pressing:
    """A screen on which STOP, accept and full throttle are pressed all the time."""

    has_display = focus = True

    def __init__(self) -> None:
        self.surface = self.front_surface = pygame.Surface((640, 360))
        self.side_surface = None

    def presses(self) -> tuple[Control, ...]:
        return (Control.STOP, Control.ACCEPT)

    def held(self) -> frozenset[Control]:
        return frozenset({Control.THROTTLE, Control.DEAD_MAN})

    def sticks(self) -> tuple[Hands, ...]:
        return ()

    def show_full(self, full_screen: bool) -> None: ...

    def flip(self) -> None: ...


class HandMoved:
    """A clock that stands between two steps, however long the machine takes to draw."""

    def __init__(self) -> None:
        self.shown_ns = 1_000 * MS

    def now_ns(self) -> int:
        return self.shown_ns


def watched(replay: str) -> tuple[Line, pygame.Surface]:
    """A window after 20 steps of 10 ms: what it said, and what stands on it."""
    line, screen, clock = Line(), Pressing(), HandMoved()
    loop = DisplayLoop(
        recording="",
        full_screen=False,
        link=line,
        video=NoVideo(),
        screen=screen,
        writer=SnapshotWriter(None),
        player=Player(False, 0.0),
        clock=clock,
        replay=replay,
    )
    for _ in range(20):
        loop.step(clock.now_ns())
        clock.shown_ns += 10 * MS
    return line, screen.surface


def test_nothing_that_is_pressed_in_a_replay_reaches_a_cockpit_though_the_window_tells_what_it_shows():
    live, _ = watched("")
    played, _ = watched("a/drive.mcap")
    assert live.said["operator_input"] > 0
    assert played.said["operator_input"] == 0
    assert played.said["window_status"] == live.said["window_status"] == 5  # no picture: drawn every 40 ms


def share_of(colour: tuple[int, int, int], surface: pygame.Surface, box: pygame.Rect) -> float:
    places = [(x, y) for x in range(box.left, box.right, 3) for y in range(box.top, box.bottom, 2)]
    return sum(surface.get_at(place)[:3] == colour for place in places) / len(places)


def test_a_replay_is_framed_in_white_bands_with_words_and_a_live_drive_never_is():
    _, played = watched("a/drive.mcap")
    _, live = watched("")
    for band in (pygame.Rect(0, 350, 640, 10), pygame.Rect(0, 0, 200, 10), pygame.Rect(440, 0, 200, 10)):
        assert 0.5 < share_of(WHITE, played, band) < 1.0  # the rest are the words
        assert share_of(WHITE, live, band) == 0.0


def test_slow_motion_is_told_in_one_band_and_not_above():
    surface = pygame.Surface((640, 360))
    slow_motion_mark(0.5).draw(surface)
    assert 0.5 < share_of(WHITE, surface, pygame.Rect(0, 350, 640, 10)) < 1.0
    assert share_of(WHITE, surface, pygame.Rect(0, 0, 640, 300)) == 0.0


@pytest.mark.parametrize("size", [(320, 180), (1280, 720), (2560, 1080), (3840, 2160), (1, 1)])
def test_the_bands_are_drawn_on_a_window_of_any_size(size):
    surface = pygame.Surface(size)
    replay_mark("a/drive.mcap, recorded 2026-11-22").draw(surface)
    assert share_of(WHITE, surface, pygame.Rect(0, size[1] - 1, size[0], 1)) > 0.5
