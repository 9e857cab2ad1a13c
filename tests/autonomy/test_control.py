"""The controllers by themselves: bounds, smoothness, and no memory while somebody else drives."""

from itertools import pairwise
from math import atan, tan

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.car_shape import car_shape
from autonomy.control.speed import SpeedSettings, SpeedState, wanted_acceleration
from autonomy.control.steering import SteeringSettings, rate_max_rad_s, toward, wanted_angle_rad
from autonomy.planning.route import Shift, own_lane
from autonomy.planning.speed_limits import Ceiling, StopPoint, ceiling
from autonomy.uncertainty.matching import match_note
from wire.configuration import read_sections, shipped
from wire.messages.vehicle import VehicleDescription
from wire.road import Road, RoadPoint
from wire.scenario import read_map

SPEED = SpeedSettings()
ROAD = Road(read_map(shipped("maps", "bend.toml")))
LANE = own_lane(ROAD)
SHAPE = car_shape(read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"])


def roll(stop_m: float, seconds: float, speed: float = 0.0) -> list[tuple[float, float, float]]:
    """A point mass under the controller: (place, speed, command) every 10 ms."""
    place, state, rows = 0.0, SpeedState(), []
    for _ in range(round(seconds * 100)):
        bound = ceiling(place, 6.9, 1.2, [StopPoint(stop_m, 1.2, "goal")], [])
        state = wanted_acceleration(state, speed, bound, True, 0.01, SPEED)
        speed = max(speed + state.acceleration_m_s2 * 0.01, 0.0)
        place += speed * 0.01
        rows.append((place, speed, state.acceleration_m_s2))
    return rows


def test_from_standstill_to_standstill_in_comfort() -> None:
    rows = roll(120.0, 40.0)
    place, speed, command = rows[-1]
    assert speed == 0.0 and 119.0 < place <= 120.1
    assert command < -0.5  # held
    assert max(row[1] for row in rows) > 6.7
    steps = [abs(after[2] - before[2]) for before, after in pairwise(rows)]
    assert max(steps) <= 0.02 + 1e-9  # 2 m/s3
    last = next(i for i, row in enumerate(rows) if i > 500 and row[1] == 0.0)
    assert abs(rows[last][2]) < 0.6  # standstill is no jerk
    assert all(row[1] == 0.0 for row in rows[last:])  # and stays one


@given(speed=st.floats(0.0, 10.0), bound=st.floats(0.0, 10.0), slope=st.floats(-7.0, 0.0), before=st.floats(-8.0, 1.2))
def test_no_command_leaves_its_bounds_and_shadow_remembers_nothing(speed: float, bound: float, slope: float, before: float) -> None:
    start = SpeedState(acceleration_m_s2=before, integral_m_s2=0.3)
    made = wanted_acceleration(start, speed, Ceiling(bound, slope), True, 0.01, SPEED)
    assert -8.0 <= made.acceleration_m_s2 <= 1.2
    shadow = wanted_acceleration(start, speed, Ceiling(bound, slope), False, 0.01, SPEED)
    assert shadow.integral_m_s2 == 0.0
    assert abs(shadow.acceleration_m_s2) <= 1.0 + 1e-9


def test_on_the_lane_in_the_bend_the_wheels_take_the_bend_s_own_angle() -> None:
    at = RoadPoint(85.0, LANE.middle_m, 0.5)
    angle = wanted_angle_rad(at, 0.5, 5.0, ROAD, LANE, Shift(), SHAPE, SteeringSettings())
    assert angle == pytest.approx(atan(2.7 * 0.0222 / (1 + 0.0222 * 1.75)), abs=1e-3)


@given(offset=st.floats(-3.4, 3.4), turn=st.floats(-0.5, 0.5))
def test_left_of_the_path_it_steers_right_and_the_other_way_round(offset: float, turn: float) -> None:
    def angle(aside: float, heading: float) -> float:
        at = RoadPoint(20.0, LANE.middle_m + aside, 0.0)
        return wanted_angle_rad(at, heading, 5.0, ROAD, LANE, Shift(), SHAPE, SteeringSettings())

    assert angle(offset, turn) == pytest.approx(-angle(-offset, -turn), abs=1e-9)
    assert angle(abs(offset) + 0.01, abs(turn)) < 0.0
    assert abs(angle(offset, turn)) <= SHAPE.road_wheel_angle_max_rad


@pytest.mark.parametrize(
    ("offset", "heading", "speed", "says"),
    [
        (-1.75, 0.0, 5.0, ""),
        (-1.3, 0.1, 6.9, ""),
        (-1.2, 0.0, 5.0, "left of the middle"),
        (-2.4, 0.0, 5.0, "right of the middle"),
        (-1.75, 0.15, 5.0, "deg left"),
        (-1.75, -0.15, 5.0, "deg right"),
        (-1.75, 0.0, 7.5, "above the limit"),
        (-1.75, 0.0, -1.0, "backwards"),
    ],
)
def test_the_note_says_what_keeps_the_state_from_matching(offset: float, heading: float, speed: float, says: str) -> None:
    note = match_note(RoadPoint(20.0, offset, 0.0), heading, speed, ROAD)
    assert says in note and bool(note) == bool(says)


@given(speed=st.floats(-1.0, 8.4), previous=st.floats(-0.2, 0.2), wanted=st.floats(-0.6, 0.6))
def test_a_step_of_the_wheels_passes_the_gate_even_when_it_comes_in_one_of_its_cycles(
    speed: float, previous: float, wanted: float
) -> None:
    """The gate's limits, once more by hand: 0.6 rad/s and, ISO 11270, 5 m/s3, in 4 ms."""
    settings = SteeringSettings()
    angle = toward(previous, wanted, rate_max_rad_s(speed, SHAPE, settings) * 0.01)
    assert abs(angle - previous) <= 0.6 * 0.004 + 1e-12
    jerk = max(speed, 0.0) ** 2 / SHAPE.wheelbase_m * abs(tan(angle) - tan(previous)) / 0.004
    assert jerk <= 5.0 * 1.05  # tan is a little steeper than its angle


def test_slow_wheels_turn_faster_than_quick_ones() -> None:
    assert [rate_max_rad_s(speed, SHAPE, SteeringSettings()) for speed in (0.0, 4.0, 7.0)] == pytest.approx(
        [0.24, 0.24, 0.110], abs=1e-3
    )
