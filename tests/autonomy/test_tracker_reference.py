"""What is followed: the nearest place on it, the speeds wanted along it, and what is no reference at all."""

from math import inf, isnan, nan, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.control.mpcc.reference import along, foot, of_trajectory, wanted_speeds
from autonomy.control.mpcc.stages import STAGE_S, STAGES
from autonomy.planning.horizon import STEP_S, STEPS, Floats, Trajectory
from autonomy.planning.reference_path import ReferencePath, through
from benchmarks.tracker_drive import reference_of
from benchmarks.tracker_tracks import TUNING, path_of

PATH, REFERENCE = path_of(TUNING), reference_of(TUNING)
DENSE = np.array([PATH.at(station) for station in np.arange(0.0, PATH.last_m, 0.05)])


def speeds_from(station: float, speed: float, acceleration_max: float = 2.0) -> Floats:
    out = np.empty(STAGES + 1)
    wanted_speeds(REFERENCE.stations_m, REFERENCE.squares_m2_s2, station, speed, acceleration_max, out)
    return out


@given(station=st.floats(1.0, 320.0), aside=st.floats(-2.0, 2.0), turned=st.floats(-1.0, 1.0))
def test_the_foot_is_the_nearest_place_of_all(station: float, aside: float, turned: float) -> None:
    x, y, heading = PATH.at(station)
    x, y = x - aside * np.sin(heading), y + aside * np.cos(heading)
    found = foot(REFERENCE.line, x, y, heading + turned, 0.0, inf)
    nearest = np.hypot(DENSE[:, 0] - x, DENSE[:, 1] - y).min()
    assert np.hypot(*(np.array(PATH.at(found)[:2]) - (x, y))) <= nearest + 1e-3


def test_where_the_path_runs_another_way_or_too_far_off_there_is_no_foot() -> None:
    x, y, heading = PATH.at(20.0)
    assert isnan(foot(REFERENCE.line, x, y, heading + np.pi, 20.0, 10.0))
    assert isnan(foot(REFERENCE.line, x, y, heading, 900.0, 10.0))
    assert foot(REFERENCE.line, -3.0, 0.5, 0.0, 0.0, inf) == pytest.approx(-3.0)  # before its begin it goes straight on


def test_from_standstill_the_speeds_wanted_grow_by_the_reference_s_own_acceleration() -> None:
    assert speeds_from(0.0, 0.0) == pytest.approx(TUNING.acceleration_m_s2 * STAGE_S * np.arange(STAGES + 1), abs=0.05)


def test_a_slower_car_is_led_up_to_the_reference_a_faster_one_is_told_at_once() -> None:
    square = np.interp(60.0, REFERENCE.stations_m, REFERENCE.squares_m2_s2)
    slow, fast = speeds_from(60.0, 2.0), speeds_from(60.0, 14.9)
    assert slow[:5] == pytest.approx(2.0 + 2.0 * STAGE_S * np.arange(5)) and fast[0] == pytest.approx(min(sqrt(square), 14.9))


def test_before_a_stop_they_fall_with_its_deceleration_and_end_at_nothing() -> None:
    last = REFERENCE.last_m
    speeds = speeds_from(last - 0.25, 1.0)  # 2 m/s2 over 0.25 m
    assert speeds[0] == pytest.approx(1.0) and speeds[6] == pytest.approx(1.0 - 2.0 * 6 * STAGE_S, abs=0.1) and speeds[-1] < 0.05
    assert (np.diff(speeds) <= 1e-9).all()


def planned(speeds: Floats, feasible: bool = True) -> Trajectory:
    states = np.zeros((STEPS + 1, 6))
    states[:, 3] = speeds
    states[1:, 0] = np.cumsum((speeds[1:] + speeds[:-1]) / 2 * STEP_S)
    return Trajectory(states=states, inputs=np.zeros((STEPS, 2)), cost=1.0, feasible=feasible, violation=0.0)


def test_a_planned_start_and_a_planned_stop_become_lines_with_their_own_speeds() -> None:
    going = of_trajectory(planned(np.minimum(0.3 * np.arange(STEPS + 1), 4.0)))
    stopping = of_trajectory(planned(np.maximum(4.0 - 0.3 * np.arange(STEPS + 1), 0.0)))
    assert going is not None and stopping is not None
    out = np.empty(STAGES + 1)
    wanted_speeds(going.stations_m, going.squares_m2_s2, 0.0, 0.0, 2.0, out)
    assert out == pytest.approx(1.5 * STAGE_S * np.arange(STAGES + 1), abs=0.2)
    assert stopping.squares_m2_s2[0] == pytest.approx(16.0) and stopping.squares_m2_s2[-1] == 0.0
    assert stopping.last_m == pytest.approx(4.0**2 / 3.0, abs=0.15)


def test_a_planned_standstill_is_a_line_to_stand_on() -> None:
    reference = of_trajectory(planned(np.zeros(STEPS + 1)))
    assert reference is not None and not reference.squares_m2_s2.any()


def broken(at: int, value: float) -> Trajectory:
    states = planned(np.full(STEPS + 1, 3.0)).states
    states[7, at] = value
    return with_states(states)


def with_states(states: Floats) -> Trajectory:
    return Trajectory(states=states, inputs=np.zeros((STEPS, 2)), cost=1.0, feasible=True, violation=0.0)


@pytest.mark.parametrize("value", [nan, inf])
@pytest.mark.parametrize("at", range(6))
def test_a_trajectory_that_is_no_numbers_is_no_reference(at: int, value: float) -> None:
    assert of_trajectory(broken(at, value)) is None


def test_neither_is_one_that_turns_back_is_not_feasible_or_has_another_shape() -> None:
    back = planned(np.full(STEPS + 1, 3.0)).states
    back[20:, 0] = back[20, 0] - 0.6 * np.arange(len(back) - 20)
    assert of_trajectory(with_states(back)) is None
    assert of_trajectory(planned(np.full(STEPS + 1, 3.0), feasible=False)) is None
    assert of_trajectory(with_states(np.zeros((0, 6)))) is None
    assert of_trajectory(with_states(np.zeros((5, 2)))) is None


def test_a_path_that_is_none_or_has_no_speeds_is_no_reference() -> None:
    good = through(np.array(((0.0, 0.0), (30.0, 0.0))), np.zeros(2), np.ones(2), np.ones(2))
    stations, speeds = np.array((0.0, 30.0)), np.array((2.0, 2.0))
    assert along(good, stations, speeds) is not None
    nothing = np.zeros(0)
    empty = ReferencePath(nothing, np.zeros((0, 4)), np.zeros((0, 4)), nothing, nothing)
    crooked = ReferencePath(good.knots_m, good.x_coefficients[:0], good.y_coefficients, good.room_left_m, good.room_right_m)
    for path, at, of in (
        (empty, stations, speeds),
        (crooked, stations, speeds),
        (good, nothing, nothing),
        (good, stations, speeds[:1]),
        (good, stations[::-1], speeds),
        (good, stations, -speeds),
        (good, stations, np.array((2.0, nan))),
        (good, np.array((0.0, inf)), speeds),
    ):
        assert along(path, at, of) is None
