"""Three pictures as one continuous view."""

from math import atan, cos, pi, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.window.picture_layout import Box, bare, part, places
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import CameraCalibration, VehicleDescription

SIZES = st.tuples(st.integers(320, 6000), st.integers(180, 3000))
SHAPES = {"front": (1280, 720), "left": (416, 360), "right": (416, 360)}
CAR = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
CAMERAS: dict[str, CameraCalibration] = {camera.name: camera for camera in CAR.cameras}


@given(SIZES, st.tuples(st.integers(64, 4000), st.integers(64, 4000)))
def test_the_front_picture_alone_keeps_its_shape_and_fits(size: tuple[int, int], shape: tuple[int, int]) -> None:
    picture = places(*size, {"front": shape}, 1.0)["front"]
    assert picture.w <= size[0] + 1 and picture.h <= size[1] + 1
    assert picture.w >= size[0] - 1 or picture.h >= size[1] - 1
    assert abs(picture.w / picture.h - shape[0] / shape[1]) <= (shape[0] / shape[1] + 1) / min(picture.w, picture.h) + 0.01


@given(SIZES)
def test_the_three_stand_side_by_side_inside_the_window_and_what_is_left_is_bare(size: tuple[int, int]) -> None:
    boxes = places(*size, SHAPES, 1.0)
    front = boxes["front"]
    assert abs(front.w / front.h - 16 / 9) <= 3 / front.h
    assert all(box.x >= 0 and box.y >= 0 and box.x + box.w <= size[0] and box.y + box.h <= size[1] + 1 for box in boxes.values())
    if "left" in boxes:
        assert boxes["left"].x + boxes["left"].w == front.x
        assert boxes["right"].x == front.x + front.w
        assert {box.y for box in boxes.values()} == {front.y}
    covered = sum(box.w * min(box.h, size[1]) for box in (*boxes.values(), *bare(*size, boxes)))
    assert abs(covered - size[0] * size[1]) <= size[0]


@pytest.mark.parametrize(
    ("size", "front_wide", "side_wide"), [((1280, 720), 800, 240), ((1920, 1080), 1200, 360), ((3840, 1080), 1920, 960)]
)
def test_the_sizes_people_have(size: tuple[int, int], front_wide: int, side_wide: int) -> None:
    boxes = places(*size, SHAPES, 1.5)
    assert (boxes["front"].w, boxes["left"].w, boxes["right"].w) == (front_wide, side_wide, side_wide)


def test_on_three_monitors_the_front_picture_is_the_middle_one() -> None:
    assert places(5760, 1080, SHAPES, 1.5)["front"] == Box(1920, 0, 1920, 1080)


@pytest.mark.parametrize("name", ["left", "right"])
def test_what_is_cut_off_a_side_picture_is_its_outer_part(name: str) -> None:
    seen = part(name, (416, 360), Box(0, 0, 240, 450))
    assert (seen.w, seen.h) == (192, 360)  # 240 * 360 / 450
    assert seen.x + seen.w == 416 if name == "left" else seen.x == 0


@pytest.mark.parametrize("size", [(1280, 720), (1920, 1080), (3840, 1080), (1000, 1000)])
def test_the_mirror_stands_above_the_horizon(size: tuple[int, int]) -> None:
    front, scale = CAMERAS["front"], min(size[0] / 1280, size[1] / 720)
    boxes = places(*size, SHAPES | {"rear": (640, 360)}, scale)
    horizon = boxes["front"].y + (0.5 - front.focal_length_px * tan(front.pitch_rad) / front.height_px) * boxes["front"].h
    assert boxes["rear"].y + boxes["rear"].h <= horizon
    assert boxes["rear"].h >= 0.25 * boxes["front"].h


@pytest.mark.parametrize("name", ["left", "right"])
def test_the_shipped_side_cameras_go_on_where_the_front_one_ends(name: str) -> None:
    """By the pinhole's own rule, written out: direction, height of the horizon and scale agree at the seam."""
    front, side = CAMERAS["front"], CAMERAS[name]
    front_half = atan(front.width_px / 2 / front.focal_length_px)
    side_half = atan(side.width_px / 2 / side.focal_length_px)
    assert abs(abs(side.yaw_rad) - side_half - front_half) < 0.01
    front_scale = front.focal_length_px / cos(front_half) / front.height_px
    side_scale = side.focal_length_px / cos(side_half) / side.height_px
    assert abs(side_scale / front_scale - 1) < 0.01
    rows = [0.5 - camera.focal_length_px * tan(camera.pitch_rad) / camera.height_px for camera in (front, side)]
    assert abs(rows[0] - rows[1]) < 0.003
    assert (side.yaw_rad > 0) == (name == "left")
    assert abs(abs(CAMERAS["rear"].yaw_rad) - pi) < 0.01
