"""Two monitors: which part of the window is which, and where the side pictures stand on the second."""

from math import isclose

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.window.picture_layout import Box
from tower.window.screen import parted
from tower.window.settings import WindowSettings
from tower.window.side_monitor import side_places

SHAPES = {"front": (1280, 720), "left": (416, 360), "right": (416, 360)}
WIDE, SMALL = (1920, 1080), (1280, 1024)


@given(st.integers(100, 6000), st.integers(80, 3000))
def test_both_sides_are_whole_inside_and_of_one_height_on_either_side_of_the_middle(width: int, height: int) -> None:
    boxes = side_places(width, height, SHAPES)
    left, right = boxes["left"], boxes["right"]
    assert left.x >= 0 and right.x + right.w <= width and left.y >= 0 and left.y + left.h <= height
    assert left.x + left.w < width / 2 < right.x + 1 and (left.y, left.h) == (right.y, right.h)
    assert isclose(left.w / left.h, 416 / 360, rel_tol=3 / left.h)


def test_a_car_without_sides_leaves_the_second_monitor_bare() -> None:
    assert side_places(1920, 1080, {"front": (1280, 720)}) == {}


@pytest.mark.parametrize(
    ("settings", "full_screen", "monitors", "parts"),
    [
        (WindowSettings(span_displays=True), True, [WIDE, WIDE], (Box(0, 0, 1920, 1080), Box(1920, 0, 1920, 1080))),
        (WindowSettings(span_displays=True, display=1), True, [WIDE, SMALL], (Box(1920, 0, 1280, 1024), Box(0, 0, 1920, 1024))),
        (WindowSettings(span_displays=True), True, [WIDE, WIDE, WIDE], ()),
        (WindowSettings(span_displays=True), True, [WIDE], ()),
        (WindowSettings(span_displays=True), False, [WIDE, WIDE], ()),
        (WindowSettings(), True, [WIDE, WIDE], ()),
    ],
)
def test_only_a_window_over_two_monitors_has_two_parts_the_front_one_first(
    settings: WindowSettings, full_screen: bool, monitors: list[tuple[int, int]], parts: tuple[Box, ...]
) -> None:
    assert parted(settings, full_screen, monitors) == parts
