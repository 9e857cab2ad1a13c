"""What is drawn before what, against brute force: a way from eye to point that is walked in small steps."""

from math import cos, pi, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.render.order import CELL_PX, far_to_near, hidden_by, seen, slots

EYE = np.array([0.0, 0.0])


def box(x: float, y: float, length: float, width: float, turn: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Counter-clockwise corners."""
    corners = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)]) * (length / 2, width / 2)
    c, s = cos(turn), sin(turn)
    return np.asarray(corners @ np.array([[c, s], [-s, c]]) + (x, y))


def is_inside(x: float, y: float, length: float, width: float, turn: float, px: float, py: float) -> bool:
    ahead, left = (px - x) * cos(turn) + (py - y) * sin(turn), (py - y) * cos(turn) - (px - x) * sin(turn)
    return abs(ahead) < length / 2 - 1e-6 and abs(left) < width / 2 - 1e-6


place, size = st.floats(-30, 30), st.floats(1, 20)


@given(place, place, size, size, st.floats(0, pi), place, place)
def test_a_point_whose_way_to_the_eye_crosses_a_block_is_always_drawn_before_it(
    x: float, y: float, length: float, width: float, turn: float, px: float, py: float
) -> None:
    crossed = any(is_inside(x, y, length, width, turn, px * k / 400, py * k / 400) for k in range(401))
    if crossed:
        assert hidden_by(box(x, y, length, width, turn)[None], np.array([[px, py]]), EYE)[0, 0]


def test_a_person_before_a_long_wall_is_drawn_after_it_though_the_walls_middle_is_nearer() -> None:
    wall = box(20.0, 9.0, 36.0, 2.0, 0.0)  # from 2 to 38 m ahead, to the left
    person, behind = np.array([[30.0, 5.0]]), np.array([[30.0, 12.0]])
    assert not hidden_by(wall[None], person, EYE)[0, 0]
    assert hidden_by(wall[None], behind, EYE)[0, 0]


def test_blocks_go_from_far_to_near_by_their_nearest_side_not_by_their_middle() -> None:
    blocks = np.stack((box(30.0, 10.0, 50.0, 4.0, 0.0), box(20.0, -10.0, 4.0, 4.0, 0.0)))
    assert far_to_near(blocks, [0, 1], EYE) == [1, 0]


def test_a_thing_between_two_blocks_is_drawn_between_them() -> None:
    blocks = np.stack((box(40.0, 0.0, 4.0, 20.0, 0.0), box(10.0, 0.0, 4.0, 20.0, 0.0)))
    order = far_to_near(blocks, [1, 0], EYE)
    assert order == [0, 1]
    assert slots(order, blocks, np.array([[60.0, 0.0], [25.0, 0.0], [5.0, 0.0]]), EYE).tolist() == [0, 1, 2]


def test_without_blocks_everything_comes_at_the_end() -> None:
    assert slots([], np.zeros((0, 4, 2)), np.array([[1.0, 0.0]]), EYE).tolist() == [0]


WALL = (10.0, 100.0, 260.0, 310.0, 100.0, 260.0)


def test_what_a_wall_covers_wholly_is_left_out_and_what_rises_above_it_is_kept() -> None:
    shown, cover = seen(
        [(64, 120, 128, 200), (64, 90, 128, 200), (0, 120, 128, 200), (0, 100, 320, 300)], [None, None, None, WALL], 320, 320
    )
    assert shown == [False, True, True, True]  # the third reaches into the cell at the edge, which the wall covers in part
    assert cover.sky_to[0] == 320 and 100 <= cover.sky_to[64 // CELL_PX] <= 103
    assert cover.ground_gap[0] == (0, 0) and cover.ground_gap[64 // CELL_PX][1] in (257, 258, 259, 260)


def test_a_wall_does_not_cover_what_is_drawn_after_it() -> None:
    shown, _ = seen([(0, 100, 320, 300), (64, 120, 128, 200)], [WALL, None], 320, 320)
    assert shown == [True, True]


def test_ground_between_a_hedge_and_the_house_behind_it_stays_to_be_seen() -> None:
    house, hedge = (0.0, 20.0, 150.0, 320.0, 20.0, 150.0), (0.0, 170.0, 260.0, 320.0, 170.0, 260.0)
    _, apart = seen([None, None], [house, hedge], 320, 320)
    first, last = apart.ground_gap[5]
    assert apart.sky_to[5] <= 23 and first >= 170 and last <= 260
    _, joined = seen([None, None], [(0.0, 20.0, 190.0, 320.0, 20.0, 190.0), hedge], 320, 320)
    first, last = joined.ground_gap[5]
    assert first <= 23 and 250 <= last <= 260


@given(st.floats(-50, 300), st.floats(5, 200), st.floats(0, 100), st.floats(0, 100), st.floats(120, 300), st.floats(120, 300))
def test_every_pixel_that_counts_as_covered_lies_inside_the_wall(
    left: float, width: float, top: float, top_end: float, foot: float, foot_end: float
) -> None:
    _, cover = seen([None], [(left, top, foot, left + width, top_end, foot_end)], 320, 320)
    for cell, ((first, last), sky_to) in enumerate(zip(cover.ground_gap, cover.sky_to, strict=True)):
        for u in (cell * CELL_PX, (cell + 1) * CELL_PX):
            share = (u - left) / width
            if last > 0:
                assert 0 <= share <= 1 and first >= top + (top_end - top) * share
                assert last <= max(first, foot + (foot_end - foot) * share)
            if sky_to < 320:
                assert 0 <= share <= 1 and sky_to >= top + (top_end - top) * share
