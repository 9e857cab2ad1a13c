"""Where the tag of a side picture stands."""

import pytest

from tower.window.overlays import tag_box
from tower.window.picture_layout import Box

LEFT = Box(0, 100, 240, 500)


@pytest.mark.parametrize(
    ("panels", "top"),
    [
        ([], 333),  # the middle
        ([Box(20, 200, 260, 220)], 426),  # below a checklist over the middle
        ([Box(20, 200, 260, 220), Box(20, 440, 250, 200)], 160),  # no room between it and the dial: above it
        ([Box(20, 100, 260, 500)], 333),  # no room at all
        ([Box(300, 200, 260, 220)], 333),  # not over this picture
    ],
)
def test_the_tag_of_a_side_picture_stands_where_no_panel_covers_it(panels: list[Box], top: int) -> None:
    assert tag_box(LEFT, 1.0, panels) == Box(25, top, 190, 34)
