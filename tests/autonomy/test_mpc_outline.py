"""The discs that stand for the car cover all of it, whatever its size; and not much more."""

from math import hypot

from hypothesis import given
from hypothesis import strategies as st

from autonomy.car_shape import CarShape
from autonomy.planning.mpc.outline import outline

LENGTHS = st.floats(0.1, 10.0)


def car(front_m: float, rear_m: float, half_width_m: float) -> CarShape:
    return CarShape(
        front_m=front_m,
        rear_m=rear_m,
        half_width_m=half_width_m,
        wheelbase_m=2.8,
        road_wheel_angle_max_rad=0.5,
        braking_max_m_s2=8.0,
    )


def beyond(shape: CarShape, along_m: float, beside_m: float) -> float:
    """How far a point of the car's frame lies outside the discs."""
    discs = outline(shape)
    nearest = min(max(along_m, discs.rear_m), discs.front_m)
    return hypot(along_m - nearest, beside_m) - discs.radius_m


@given(LENGTHS, LENGTHS, LENGTHS, st.floats(0, 1), st.floats(-1, 1))
def test_every_point_of_the_car_lies_inside(front: float, rear: float, half_width: float, along: float, beside: float) -> None:
    shape = car(front, rear, half_width)
    assert beyond(shape, along * (front + rear) - rear, beside * half_width) <= 1e-9


@given(LENGTHS, LENGTHS, LENGTHS)
def test_every_corner_lies_on_the_edge(front: float, rear: float, half_width: float) -> None:
    shape = car(front, rear, half_width)
    for along in (front, -rear):
        assert abs(beyond(shape, along, half_width)) < 1e-9


def test_beside_a_usual_car_it_adds_a_hand_and_no_more() -> None:
    assert 0.08 < outline(car(3.8, 1.0, 1.125)).radius_m - 1.125 < 0.09
