"""The unrolled road: arrays of points against the road's own answers, one at a time, and the sheet's columns there and back."""

import numpy as np
import pytest

from vehicle_gateway.video.render.road_frame import RoadFrame
from vehicle_gateway.video.render.sheet import BEYOND_M, Reduced, Sheet
from wire.messages.automation import RoadMap, RoadSegment
from wire.road import Road

ROAD = Road(
    RoadMap(
        name="s",
        start=(12.0, -7.0),
        start_heading_rad=0.7,
        lane_width_m=3.5,
        sidewalk_width_m=2.5,
        drives_on="right",
        speed_limit_m_s=7.0,
        goal_station_m=100.0,
        segments=(
            RoadSegment(length_m=40.0),
            RoadSegment(length_m=35.0, curvature_1_m=0.03),
            RoadSegment(length_m=20.0),
            RoadSegment(length_m=30.0, curvature_1_m=-0.02),
        ),
    )
)
SHEET = Sheet(-40.0, 200.0, 6.5)


def test_many_points_get_the_station_and_offset_they_were_made_from() -> None:
    stations, offsets = (grid.ravel() for grid in np.meshgrid(np.linspace(-20, 145, 60), np.linspace(-15, 15, 13)))
    places = np.array([ROAD.to_world(float(s), float(o))[:2] for s, o in zip(stations, offsets, strict=True)])
    station, offset = RoadFrame(ROAD).to_road(places[:, 0], places[:, 1])
    assert station == pytest.approx(stations, abs=1e-3)
    assert offset == pytest.approx(offsets, abs=1e-3)


def test_coordinates_relative_to_an_origin_give_the_same_answer_in_single_precision() -> None:
    x, y, _ = ROAD.to_world(60.0, -1.75)
    base = (float(x) - 3.0, float(y) + 4.0)
    station, offset = RoadFrame(ROAD).to_road(np.array([3.0], np.float32), np.array([-4.0], np.float32), base, 60.0)
    assert station[0] == pytest.approx(60.0, abs=1e-4) and offset[0] == pytest.approx(-1.75, abs=1e-4)


def test_the_middle_of_every_column_is_found_in_that_column() -> None:
    columns = SHEET.column(SHEET.offsets_m())
    assert columns == pytest.approx(np.arange(SHEET.columns) + 0.5, abs=0.02)


def test_what_lies_beyond_the_sheet_gets_its_outermost_column() -> None:
    columns = SHEET.column(np.array([-6.5 - BEYOND_M - 50.0, 6.5 + BEYOND_M + 50.0], np.float32))
    assert columns == pytest.approx([0.0, SHEET.columns])


def test_a_very_long_road_gets_longer_rows_not_more_memory() -> None:
    short, long = Sheet(0.0, 400.0, 6.5), Sheet(0.0, 5000.0, 6.5)
    assert long.rows <= 9000 and long.row_m > short.row_m
    assert long.row(np.array([5000.0]))[0] == pytest.approx(long.rows, abs=1.0)


def test_the_copy_that_is_read_has_texels_about_as_large_as_the_samples_footprint() -> None:
    reduced = Reduced(np.zeros((512, 256, 4), np.uint8))
    for along, across in ((1.0, 0.3), (7.0, 2.0), (60.0, 9.0), (4.0, 4.0)):
        i, j, copy = reduced.pick(along, across)
        assert copy.shape[:2] == (512 >> i, 256 >> j)
        assert 0.5 <= max(along, 1.0) / 2**i <= 2.0 and 0.5 <= max(across, 1.0) / 2**j <= 2.0


def test_a_reduced_copy_holds_the_mean_of_what_it_stands_for() -> None:
    texture = np.zeros((64, 64, 4), np.uint8)
    texture[::2] = 200  # every other row: the finest pattern there is
    _, _, copy = Reduced(texture).pick(8.0, 1.0)
    assert copy.min() == copy.max() == 100


def test_a_place_in_the_picture_of_all_copies_holds_the_texel_of_the_copy() -> None:
    texture = np.random.default_rng(4).integers(0, 255, (96, 64, 4), dtype=np.uint8)
    reduced = Reduced(texture)
    for along, across in ((1.0, 1.0), (2.0, 1.0), (4.0, 4.0), (8.0, 2.0)):
        i, j, copy = reduced.pick(along, across)
        rows, columns = (np.arange(copy.shape[0]) + 0.5) * 2**i, (np.arange(copy.shape[1]) + 0.5) * 2**j
        grid = np.meshgrid(rows, columns, indexing="ij")
        x, y = reduced.places(grid[0], grid[1], np.array([(i, j)] * len(rows)))
        assert np.array_equal(reduced.all_copies[y.astype(int), x.astype(int)], copy)


def test_a_place_beyond_the_texture_is_its_edge_never_the_copy_beside_it() -> None:
    reduced = Reduced(np.zeros((96, 64, 4), np.uint8))
    ends = np.array([[-50.0, 500.0]])
    x, y = reduced.places(ends, ends, np.array([(1, 1)]))
    assert x.tolist() == [[64.0, 95.0]] and y.tolist() == [[96.0, 143.0]]  # beside the full columns, below the full rows
