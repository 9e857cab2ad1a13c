"""Who follows the street is predicted along it, everybody else as told. The second rule: circles, and a simulated rider."""

from dataclasses import replace
from math import cos, inf, nan, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.along_street import BESIDE_M, along_street
from autonomy.planning.crossings.drive import predictions
from autonomy.planning.crossings.driver import path_of
from autonomy.planning.crossings.people import STEP_S as PEOPLE_S
from autonomy.planning.crossings.people import Outline, at_start
from autonomy.planning.crossings.people import step as people_step
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.horizon import STEP_S, STEPS, CarState, Floats, Predictions
from autonomy.planning.reference_path import ReferencePath, lane_path
from wire.messages.automation import RoadMap, RoadSegment
from wire.road import Road

RADIUS_M = 25.0
TIMES = STEP_S * np.arange(STEPS + 1)
Numbers = tuple[float, float]


def street(curvature_1_m: float = 1.0 / RADIUS_M, length_m: float = 60.0) -> ReferencePath:
    """From the origin along x, left in a circle around (0, RADIUS_M)."""
    road = Road(
        RoadMap(
            name="one",
            start=(0.0, 0.0),
            start_heading_rad=0.0,
            segments=(RoadSegment(length_m=length_m, curvature_1_m=curvature_1_m),),
            lane_width_m=3.5,
            sidewalk_width_m=2.0,
            speed_limit_m_s=5.0,
            drives_on="right",
            goal_station_m=length_m,
        )
    )
    return lane_path(road, lambda _: 0.0, 0.0, length_m, -3.5, 3.5)


BEND, STRAIGHT = street(), street(0.0)


def told(*people: tuple[Numbers, Numbers], covariance: Floats | None = None) -> Predictions:
    """At constant velocity: place, velocity."""
    places, velocities = np.array([place for place, _ in people]), np.array([velocity for _, velocity in people])
    return Predictions(
        numbers=tuple(range(len(people))),
        positions_m=places + TIMES[:, None, None] * velocities,
        covariances_m2=np.tile(np.diag((0.1, 0.1)) if covariance is None else covariance, (STEPS + 1, len(people), 1, 1)),
        radii_m=np.full(len(people), 0.6),
    )


def on_circle(angle_rad: float, offset_m: float = 0.0) -> Numbers:
    out = RADIUS_M - offset_m
    return out * sin(angle_rad), RADIUS_M - out * cos(angle_rad)


def along(angle_rad: float, speed_m_s: float, aside_m_s: float = 0.0) -> Numbers:
    c, s = cos(angle_rad), sin(angle_rad)
    return speed_m_s * c - aside_m_s * s, speed_m_s * s + aside_m_s * c


@pytest.mark.parametrize("offset_m", [-2.2, 0.0, 2.2])
@pytest.mark.parametrize(("angle_rad", "speed_m_s"), [(0.2, 4.0), (1.7, -4.0), (0.8, 1.4)])
def test_a_rider_on_a_bend_keeps_to_it_towards_the_car_and_away_from_it(
    angle_rad: float, speed_m_s: float, offset_m: float
) -> None:
    found = along_street(told((on_circle(angle_rad, offset_m), along(angle_rad, speed_m_s))), BEND)
    angles = angle_rad + speed_m_s * TIMES / (RADIUS_M - offset_m)
    assert found.positions_m[:, 0] == pytest.approx(np.array([on_circle(angle, offset_m) for angle in angles]), abs=0.02)


@pytest.mark.parametrize("aside_m_s", [-0.5, 0.4])
def test_who_comes_nearer_to_the_line_or_leaves_it_goes_on_to_do_so(aside_m_s: float) -> None:
    """The second rule: the same in a thousand small steps, by angle and offset."""
    found = along_street(told((on_circle(0.3, 1.0), along(0.3, 3.0, aside_m_s))), BEND)
    angle, offset, small_s, expected = 0.3, 1.0, 0.001, [on_circle(0.3, 1.0)]
    for number in range(1, round(TIMES[-1] / small_s) + 1):
        angle += 3.0 * small_s / (RADIUS_M - offset)
        offset += aside_m_s * small_s
        if number % round(STEP_S / small_s) == 0:
            expected.append(on_circle(angle, offset))
    assert found.positions_m[:, 0] == pytest.approx(np.array(expected), abs=0.02)


@given(
    st.tuples(st.floats(-20.0, 80.0), st.floats(-9.0, 9.0)),
    st.tuples(st.floats(-8.0, 8.0), st.floats(-8.0, 8.0)),
)
def test_on_a_straight_street_everybody_goes_on_as_told(place: Numbers, velocity: Numbers) -> None:
    before = told((place, velocity))
    after = along_street(before, STRAIGHT)
    assert after.positions_m == pytest.approx(before.positions_m, abs=1e-6)
    assert after.covariances_m2 == pytest.approx(before.covariances_m2, abs=1e-9)


@given(st.floats(0.1, 2.0), st.floats(-3.4, 3.4), st.floats(0.6, 2.5), st.floats(-0.9, 0.9), st.sampled_from((-1.0, 1.0)))
def test_whoever_crosses_a_bend_goes_straight_on(angle: float, offset: float, speed: float, slant: float, side: float) -> None:
    """Within 50 degrees of straight across."""
    velocity = along(angle, speed * sin(slant), side * speed * cos(slant))
    before = told((on_circle(angle, offset), velocity))
    assert np.array_equal(along_street(before, BEND).positions_m, before.positions_m)


@pytest.mark.parametrize("speed_m_s", [0.0, 0.2])
def test_who_stands_or_sways_is_where_told(speed_m_s: float) -> None:
    before = told((on_circle(0.5), along(0.5, speed_m_s)))
    assert np.array_equal(along_street(before, BEND).positions_m, before.positions_m)


def test_who_is_on_no_part_of_the_street_goes_straight_on() -> None:
    """Beyond the sidewalk on the far side, and in the middle of the circle, where every part of it is as near."""
    far = 3.5 + BESIDE_M + 0.1
    before = told((on_circle(0.5, -far), along(0.5, 3.0)), ((0.0, RADIUS_M), (3.0, 0.0)))
    assert np.array_equal(along_street(before, BEND).positions_m, before.positions_m)
    near = told((on_circle(0.5, -far + 0.2), along(0.5, 3.0)))
    assert not np.array_equal(along_street(near, BEND).positions_m, near.positions_m)


def test_beyond_either_end_of_the_path_it_is_straight_and_so_is_who_rides_there() -> None:
    end, heading = 60.0 / RADIUS_M, 60.0 / RADIUS_M
    beyond = told((on_circle(end), along(heading, 4.0)), ((-30.0, 1.0), (-3.0, 0.0)))
    assert along_street(beyond, BEND).positions_m == pytest.approx(beyond.positions_m, abs=1e-6)
    onto = along_street(told(((-7.0, 1.0), (3.5, 0.0))), BEND).positions_m[:, 0]  # two seconds, then the circle
    assert onto[:10] == pytest.approx(np.stack((-7.0 + 3.5 * TIMES[:10], np.ones(10)), axis=1), abs=1e-6)
    assert onto[-1] == pytest.approx(np.array(on_circle(5.0 * 3.5 / (RADIUS_M - 1.0), 1.0)), abs=0.02)


def test_the_covariance_turns_with_the_street() -> None:
    """As sure along the street as across it as ever, read off by its tangents."""
    before = told((on_circle(0.3, 1.5), along(0.3, 3.0)), covariance=np.array([[0.5, 0.1], [0.1, 0.2]]))
    after = along_street(before, BEND)
    assert after.covariances_m2[0] == pytest.approx(before.covariances_m2[0])
    for k in range(STEPS + 1):
        for once, now in zip(axes(0.3), axes(0.3 + 3.0 * TIMES[k] / (RADIUS_M - 1.5)), strict=True):
            was, there = before.covariances_m2[k, 0], after.covariances_m2[k, 0]
            assert now @ there @ now == pytest.approx(once @ was @ once, abs=1e-3)
            assert there[0, 1] == there[1, 0]


def axes(angle_rad: float) -> list[Floats]:
    """Along, across, and between: three directions tell a covariance."""
    return [np.array((cos(angle_rad + turn), sin(angle_rad + turn))) for turn in (0.0, pi / 2, pi / 4)]


@pytest.mark.parametrize("value", [nan, inf, -inf, 1e9])
@pytest.mark.parametrize("field", ["positions_m", "covariances_m2", "radii_m"])
def test_what_is_no_prediction_comes_back_as_it_is_for_the_planners_to_refuse(field: str, value: float) -> None:
    before = told((on_circle(0.5), along(0.5, 3.0)), (on_circle(0.7), along(0.7, 3.0)))
    broken = getattr(before, field).copy()
    broken[0] = value
    bad = replace(before, **{field: broken})
    assert along_street(bad, BEND) is bad


def test_another_shape_nobody_and_no_path_come_back_as_they_are() -> None:
    someone = told((on_circle(0.5), along(0.5, 3.0)))
    short = replace(someone, positions_m=someone.positions_m[:-1])
    nobody = Predictions(numbers=(), positions_m=np.empty((36, 0, 2)), covariances_m2=np.empty((36, 0, 2, 2)), radii_m=np.empty(0))
    assert along_street(short, BEND) is short and along_street(nobody, BEND) is nobody
    for path in (replace(BEND, knots_m=BEND.knots_m * nan), replace(BEND, x_coefficients=BEND.x_coefficients[:-1])):
        assert along_street(someone, path) is someone


def test_what_is_given_is_not_written_to_and_the_same_gives_the_same_bits() -> None:
    given_, again = (told((on_circle(0.5), along(0.5, 3.0))) for _ in range(2))
    first, second = along_street(given_, BEND), along_street(given_, BEND)
    assert np.array_equal(given_.positions_m, again.positions_m)
    assert np.array_equal(first.positions_m, second.positions_m) and np.array_equal(first.covariances_m2, second.covariances_m2)


def test_the_riders_of_the_benchmark_do_what_is_predicted_of_them() -> None:
    """For four seconds. Straight on the one who comes, in a bend by then, would be nearly three metres away."""
    world = world_of(read_crossing(find_crossing("cyclist"))[0], 0)
    people, far_off = at_start(world), Outline(-500.0, 0.0, 0.0, 3.8, 1.0, 1.1)
    car = CarState(x_m=20.0, y_m=0.0, heading_rad=0.0, speed_m_s=0.0, road_wheel_angle_rad=0.0, station_m=20.0)
    for _ in range(round(5.0 / PEOPLE_S)):  # they have settled on their lines
        people = people_step(people, world, far_off)
    straight = predictions(world, people, car, 0.0)
    led = along_street(straight, path_of(world))
    later = people
    for _ in range(round(4.0 / PEOPLE_S)):
        later = people_step(later, world, far_off)
    stage = round(4.0 / STEP_S)
    for k, number in ((k, number) for k, number in enumerate(straight.numbers) if number >= len(world.positions_m) - 2):
        missed, by_straight = (
            float(np.hypot(*(told_.positions_m[stage, k] - later.places_m[number]))) for told_ in (led, straight)
        )
        assert missed < 0.4
        assert missed < 0.5 * by_straight
