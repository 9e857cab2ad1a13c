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
CAMERAS = st.sampled_from(
    [
        {"front": (1280, 720)},
        {"front": (1280, 720), "left": (416, 360), "right": (416, 360)},
        {"front": (1280, 720), "left": (640, 480), "right": (416, 360), "rear": (640, 360)},
    ]
)


def boxes(at: Layout) -> dict[str, Box]:
    return {name: getattr(at, name) for name in PARTS}


@given(SIZES, CAMERAS)
def test_no_part_covers_the_clear_zone_and_all_stay_inside_the_window(
    size: tuple[int, int], cameras: dict[str, tuple[int, int]]
) -> None:
    at = layout(*size, cameras)
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
    camera = next(each for each in car.cameras if each.name == "front")
    at = layout(1280, 720, {each.name: (each.width_px, each.height_px) for each in car.cameras})
    front = at.pictures["front"]
    zoom = front.w / camera.width_px
    horizon = camera.height_px / 2 - camera.focal_length_px * tan(camera.pitch_rad)
    for ahead_m in (5.0, 8.0, 15.0, 40.0):
        row = horizon + camera.focal_length_px * camera.z_m / ahead_m
        for left_m in (-1.75, 0.0, 1.75):
            column = camera.width_px / 2 - camera.focal_length_px * left_m / ahead_m
            point = Box(round(front.x + column * zoom), round(front.y + row * zoom), 1, 1)
            assert not any(box.overlaps(point) for box in boxes(at).values()), (ahead_m, left_m)
    assert at.card.y + at.card.h < front.y + horizon * zoom
    tallest = CardView(
        title="T", tone=Tone.WARN, reasons=(("a", "b"),) * 5, remaining_share=1.0, steps=(Step("s", False),), note="n"
    )
    assert card_height(tallest) * at.scale <= at.card.h
