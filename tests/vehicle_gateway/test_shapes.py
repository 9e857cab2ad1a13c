from math import cos, hypot, pi, sin

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.simulation.shapes import Outline, corners, point_gap_m, polygon_gap_m, sees_through, to_car

CAR = Outline(0.0, 0.0, 0.0, 3.6, 0.9, 0.88)
PLACE, HEADING = st.floats(-20, 20), st.floats(-pi, pi)
BOX = ((10.0, -2.0), (14.0, -2.0), (14.0, 2.0), (10.0, 2.0))


def along(polygon, n=25):
    """Points on the outline, for the plain rule: try them all."""
    return [
        (ax + (bx - ax) * i / n, ay + (by - ay) * i / n)
        for (ax, ay), (bx, by) in zip(polygon, polygon[1:] + polygon[:1], strict=True)
        for i in range(n)
    ]


@pytest.mark.parametrize(
    ("x", "y", "gap"), [(0, 0, 0), (4.6, 0, 1), (-1.9, 0, 1), (1, 1.88, 1), (1, -2.88, 2), (3.6 + 3, 0.88 + 4, 5)]
)
def test_the_gap_of_a_point_is_measured_to_the_nearest_bumper_side_or_corner(x, y, gap):
    assert point_gap_m(CAR, x, y) == pytest.approx(gap)


@given(x=PLACE, y=PLACE, heading=HEADING, ahead=st.floats(-10, 10), left=st.floats(-10, 10))
def test_car_coordinates_are_ahead_and_left(x, y, heading, ahead, left):
    car = CAR._replace(x_m=x, y_m=y, heading_rad=heading)
    point = (x + ahead * cos(heading) - left * sin(heading), y + ahead * sin(heading) + left * cos(heading))
    assert to_car(car, *point) == pytest.approx((ahead, left), abs=1e-9)


@given(x=PLACE, y=PLACE, heading=HEADING)
def test_the_gap_of_two_polygons_is_that_of_their_nearest_points(x, y, heading):
    shape = corners(CAR._replace(x_m=x, y_m=y, heading_rad=heading))
    nearest = min(hypot(ax - bx, ay - by) for ax, ay in along(shape) for bx, by in along(BOX))
    gap = polygon_gap_m(shape, BOX)
    assert gap <= nearest + 1e-9
    if gap > 0.0:
        assert nearest - gap < 0.15  # half a step along the outlines


@given(x=st.floats(11, 13), y=st.floats(-1, 1), heading=HEADING)
def test_a_car_inside_a_polygon_has_no_gap(x, y, heading):
    assert polygon_gap_m(corners(CAR._replace(x_m=x, y_m=y, heading_rad=heading)), BOX) == 0.0


@given(st.tuples(PLACE, PLACE), st.tuples(PLACE, PLACE))
def test_sight_is_blocked_when_a_point_of_the_line_is_inside(start, end):
    points = [(start[0] + (end[0] - start[0]) * i / 500, start[1] + (end[1] - start[1]) * i / 500) for i in range(501)]
    inside = any(10.0 + 1e-6 < x < 14.0 - 1e-6 and -2.0 + 1e-6 < y < 2.0 - 1e-6 for x, y in points)
    clear = all(not (9.9 < x < 14.1 and -2.1 < y < 2.1) for x, y in points)
    if inside:
        assert not sees_through(start, end, BOX)
    if clear:
        assert sees_through(start, end, BOX)
