"""Which picture of the window is kept, and that it is whole."""

from collections.abc import Sequence
from pathlib import Path

import cv2
import numpy as np
import pygame
from hypothesis import given
from hypothesis import strategies as st

from tower.window.snapshot import Choice, SnapshotWriter, choose
from wire.messages.vehicle import Mode

S = 1_000_000_000


def saves(offsets_m: Sequence[float | None], mode: Mode = Mode.REMOTE, step_ns: int = S // 10, live: bool = True) -> list[int]:
    """Indices of the steps at which a picture is saved."""
    choice, taken = Choice(), []
    for index, offset in enumerate(offsets_m):
        choice, save = choose(choice, mode, offset, live, index * step_ns)
        if save:
            taken.append(index)
    return taken


def test_more_than_a_second_of_driving_gives_a_picture_even_with_no_scene() -> None:
    assert saves([None] * 12) == [10]
    assert saves([None] * 9) == []


def test_a_farther_offset_gives_a_better_picture_but_no_sooner_than_after_two_seconds() -> None:
    offsets = [0.1] * 15 + [1.9] * 40
    assert saves(offsets) == [10, 30]


def test_nothing_is_saved_while_the_operator_does_not_drive_or_the_picture_is_not_live() -> None:
    assert all(saves([1.0] * 40, mode) == [] for mode in Mode if mode is not Mode.REMOTE)
    assert saves([1.0] * 40, live=False) == []


@given(st.lists(st.none() | st.floats(0, 5), max_size=120))
def test_saves_are_two_seconds_apart_and_each_shows_a_farther_offset(offsets: list[float | None]) -> None:
    taken = saves(offsets)
    for one, other in zip(taken, taken[1:], strict=False):
        assert (other - one) * (S // 10) >= 2 * S
        farther, before = offsets[other], offsets[one]
        assert farther is not None
        assert farther > (before if before is not None else -1.0)


def test_the_file_is_the_picture_that_was_kept_last_and_nothing_is_left_beside_it(tmp_path: Path) -> None:
    surface = pygame.Surface((64, 36))
    with SnapshotWriter(tmp_path / "window.png") as writer:
        writer.keep(surface)
        surface.fill((200, 40, 10))
        writer.keep(surface)
        surface.fill((0, 0, 0))
        assert not list(tmp_path.iterdir())  # nothing is encoded while somebody drives
    assert [path.name for path in tmp_path.iterdir()] == ["window.png"]
    image = cv2.imread(str(tmp_path / "window.png"))
    assert image is not None
    assert np.array_equal(image, np.full((36, 64, 3), (10, 40, 200), np.uint8))


def test_a_folder_that_is_not_there_is_counted_not_raised(tmp_path: Path) -> None:
    with SnapshotWriter(tmp_path / "gone" / "window.png") as writer:
        writer.keep(pygame.Surface((8, 8)))
    assert writer.failed == 1


def test_where_no_picture_is_wanted_nothing_is_kept() -> None:
    with SnapshotWriter(None) as writer:
        writer.keep(pygame.Surface((8, 8)))
    assert writer.failed == 0
