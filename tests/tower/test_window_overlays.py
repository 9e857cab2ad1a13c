"""Where the tag of a side picture stands, and the words beneath the tab that says who drives."""

import pygame
import pytest

from tower.window.banner import draw_subtitle
from tower.window.fonts import Type
from tower.window.ink import Ink
from tower.window.looks import WAITING
from tower.window.overlays import tag_box
from tower.window.picture_layout import Box
from tower.window.views import BannerView, Tone

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


@pytest.mark.parametrize(
    ("hint", "lines"),
    [
        ("", 1),
        ("Hold Shift, Enter: you drive", 1),
        ("3 stops in ten minutes: a supervisor has to release the car", 2),
    ],
)
def test_what_to_do_has_a_line_of_its_own_where_it_does_not_fit_beside_why(hint: str, lines: int) -> None:
    surface = pygame.Surface((660, 62), pygame.SRCALPHA)
    view = BannerView(look=WAITING, cause="The operator has no new picture", hint=hint, tone=Tone.BAD)
    draw_subtitle(Ink(surface, 1.0, Type()), view)
    assert (surface.get_bounding_rect().height > 45) is (lines == 2)
