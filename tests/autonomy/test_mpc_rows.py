"""Every row's derivatives are its differences, and its sign is that of plain geometry."""

from dataclasses import replace
from math import cos, sin

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.horizon import Floats, Predictions
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.problem import STAGES, Arrays, arrays
from autonomy.planning.mpc.rows import ROAD_ROWS, people_rows, road_rows
from autonomy.planning.mpc.settings import MpcSettings
from benchmarks.planner_crowd import CAR, Drive

K = 20
STATES = st.tuples(st.floats(5, 9), st.floats(-1, 3), st.floats(-0.5, 0.7), st.just(1.0), st.just(0.0), st.floats(5, 9)).map(
    np.array
)


def problem() -> Arrays:
    """Three people with slanted ellipses, and a side of each."""
    drive = Drive(3, 3)
    people = drive.problem().predictions
    assert people is not None
    slanted = np.array([[0.2, 0.1], [0.1, 0.4]]) * np.linspace(0.0, 1.0, STAGES)[:, None, None, None]
    near = np.array(((10.0, 1.0), (6.0, 6.0), (12.0, -3.0)))
    people = Predictions(
        numbers=people.numbers,
        positions_m=np.tile(near, (STAGES, 1, 1)),
        covariances_m2=np.tile(slanted, (1, 3, 1, 1)),
        radii_m=np.array((0.3, 0.4, 0.5)),
    )
    asked = drive.problem(half_spaces(np.tile((6.0, 2.0), (STAGES, 1)), people))
    return arrays(replace(asked, predictions=people), MpcSettings())


PROBLEM = problem()


def all_rows(state: Floats) -> tuple[Floats, Floats]:
    values, slopes, owners = np.full(40, np.nan), np.zeros((4, 40)), np.zeros(40, np.int64)
    c, s = cos(state[2]), sin(state[2])
    road_rows(PROBLEM, K, 0, state, c, s, 0, values, slopes, owners)
    end, least = people_rows(PROBLEM, K, state, c, s, ROAD_ROWS, values, slopes, owners)
    assert least == min(values[ROAD_ROWS:end], default=least)
    return values[:end], slopes[:, :end]


@given(STATES)
def test_derivatives_are_differences(state: Floats) -> None:
    values, slopes = all_rows(state)
    for row, at in enumerate((0, 1, 2, 5)):
        less, more = state.copy(), state.copy()
        less[at] -= 1e-6
        more[at] += 1e-6
        below, above = all_rows(less)[0], all_rows(more)[0]
        if len(below) == len(above) == len(values):
            assert np.allclose(slopes[row], (above - below) / 2e-6, atol=2e-4)


@given(STATES)
def test_a_person_who_keeps_its_row_touches_no_part_of_the_car(state: Floats) -> None:
    """The plainer rule: distance to the rectangle."""
    values = all_rows(state)[0][ROAD_ROWS : ROAD_ROWS + 3]
    for j, value in enumerate(values):
        x, y = PROBLEM.people[K, j, :2] - state[:2]
        along, beside = x * cos(state[2]) + y * sin(state[2]), y * cos(state[2]) - x * sin(state[2])
        outside = np.hypot(max(-CAR.rear_m - along, along - CAR.front_m, 0.0), max(abs(beside) - CAR.half_width_m, 0.0))
        if value >= 0.0:
            assert outside > (0.3, 0.4, 0.5)[j]


@given(STATES)
def test_a_car_whose_road_rows_hold_has_its_corners_on_the_road(state: Floats) -> None:
    """The plainer rule: each corner to the nearest of many points of the line. The row's station is a little off it: 3 cm."""
    path = Drive(3, 0).path
    stations = np.arange(0.0, 20.0, 0.01)
    line = np.array([path.at(float(s)) for s in stations[::50]])
    fine = np.stack([np.interp(stations, stations[::50], line[:, i]) for i in (0, 1)], axis=1)
    if min(all_rows(state)[0][:ROAD_ROWS]) >= 0.0 and abs(state[5] - stations[nearest(fine, state[:2])]) < 0.3:
        for along in (CAR.front_m, -CAR.rear_m):
            for beside in (CAR.half_width_m, -CAR.half_width_m):
                c, s = cos(state[2]), sin(state[2])
                corner = state[:2] + (along * c - beside * s, along * s + beside * c)
                assert np.hypot(*(fine[nearest(fine, corner)] - corner)) <= 3.5 + 0.03


def nearest(points: Floats, place: Floats) -> int:
    return int(np.argmin(np.hypot(points[:, 0] - place[0], points[:, 1] - place[1])))
