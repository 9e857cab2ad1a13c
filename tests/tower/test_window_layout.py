"""Nothing of the window stands on the road ahead."""

import itertools
from math import tan

from hypothesis import given
from hypothesis import strategies as st

from tower.window.card_view import card_height
from tower.window.layout import Box, Layout, layout
from tower.window.views import CardView, Step, Tone
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription

PARTS = ("tab", "subtitle", "card", "operator", "link", "dial", "controls", "map", "briefing")
SIZES = st.tuples(st.integers(320, 4000), st.integers(180, 3000))


def boxes(at: Layout) -> dict[str, Box]:
    return {name: getattr(at, name) for name in PARTS}


@given(SIZES)
def test_no_part_covers_the_clear_zone_and_all_stay_inside_the_window(size: tuple[int, int]) -> None:
    at = layout(*size)
    for name, box in boxes(at).items():
        assert not box.overlaps(at.clear_zone), name
        assert box.x >= -1 and box.y >= -1, name
        assert box.x + box.w <= size[0] + 1 and box.y + box.h <= size[1] + 1, name


@given(SIZES)
def test_parts_do_not_cover_one_another(size: tuple[int, int]) -> None:
    parts = boxes(layout(*size))
    for (one, a), (other, b) in itertools.combinations(parts.items(), 2):
        if {one, other} == {"subtitle", "card"}:  # one stands for the other
            continue
        smaller = b._replace(x=b.x + 2, y=b.y + 2, w=b.w - 4, h=b.h - 4)  # rounding to pixels
        assert not a.overlaps(smaller), (one, other)


def test_the_own_lane_is_free_from_five_metres_before_the_camera_to_the_horizon() -> None:
    """A second rule: the shipped camera's projection of the lane, written out."""
    car = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
    camera = car.cameras[0]
    at = layout(camera.width_px, camera.height_px)
    horizon = camera.height_px / 2 - camera.focal_length_px * tan(camera.pitch_rad)
    for ahead_m in (5.0, 8.0, 15.0, 40.0):
        row = horizon + camera.focal_length_px * camera.z_m / ahead_m
        for left_m in (-1.75, 0.0, 1.75):
            column = camera.width_px / 2 - camera.focal_length_px * left_m / ahead_m
            point = Box(round(column), round(row), 1, 1)
            assert not any(box.overlaps(point) for box in boxes(at).values()), (ahead_m, left_m)
    assert at.card.y + at.card.h < horizon
    tallest = CardView(
        title="T", tone=Tone.WARN, reasons=(("a", "b"),) * 5, remaining_share=1.0, steps=(Step("s", False),), note="n"
    )
    assert card_height(tallest) * at.scale <= at.card.h


@given(SIZES, st.tuples(st.integers(64, 4000), st.integers(64, 4000)))
def test_the_picture_keeps_its_shape_and_fits(size: tuple[int, int], shape: tuple[int, int]) -> None:
    picture = layout(*size, shape).picture
    assert picture.w <= size[0] + 1 and picture.h <= size[1] + 1
    assert abs(picture.w / picture.h - shape[0] / shape[1]) <= (shape[0] / shape[1] + 1) / min(picture.w, picture.h) + 0.01
