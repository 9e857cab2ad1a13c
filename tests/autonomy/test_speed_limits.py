"""The ceiling against the school formula v^2 = 2 a d, and against a car that is rolled along it step by step."""

from math import sqrt

import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.speed_limits import SpeedCap, StopPoint, ceiling, driving_time_s
from autonomy.uncertainty.budget import BudgetSettings, slowing

COMFORT, LIMIT = 1.2, 6.9


def test_far_from_everything_the_limit_holds() -> None:
    assert ceiling(0.0, LIMIT, COMFORT, [StopPoint(100.0, COMFORT, "goal")], []) == (LIMIT, 0.0)


@given(distance=st.floats(0.05, 200.0), deceleration=st.floats(2.01, 8.0))
def test_a_firm_stop_follows_the_school_formula(distance: float, deceleration: float) -> None:
    allowed = ceiling(0.0, 100.0, COMFORT, [StopPoint(distance, deceleration, "person")], []).speed_m_s
    assert allowed == pytest.approx(sqrt(2 * deceleration * distance))


@given(distance=st.floats(0.1, 100.0), deceleration=st.floats(0.4, 2.0))
def test_a_soft_stop_is_never_faster_than_the_school_formula(distance: float, deceleration: float) -> None:
    allowed = ceiling(0.0, 100.0, COMFORT, [StopPoint(distance, deceleration, "goal")], []).speed_m_s
    assert allowed <= sqrt(2 * deceleration * distance) + 1e-9


@given(st.floats(-50.0, 20.0))
def test_beyond_a_stop_nothing_is_allowed(station: float) -> None:
    assert ceiling(20.0, LIMIT, COMFORT, [StopPoint(station, COMFORT, "goal")], []).speed_m_s == 0.0


def test_a_cap_is_kept_inside_and_reached_with_comfort_before_it() -> None:
    cap = SpeedCap(50.0, 60.0, 3.0)
    assert ceiling(55.0, LIMIT, COMFORT, [], [cap]).speed_m_s == 3.0
    assert ceiling(61.0, LIMIT, COMFORT, [], [cap]).speed_m_s == LIMIT
    assert ceiling(45.0, LIMIT, COMFORT, [], [cap]).speed_m_s == pytest.approx(sqrt(9 + 2 * COMFORT * 5))


def test_driving_time_over_100_m_from_the_limit_is_distance_by_speed_plus_the_braking() -> None:
    time = driving_time_s(0.0, LIMIT, COMFORT, LIMIT, COMFORT, [StopPoint(100.0, COMFORT, "goal")], [], 60.0)
    braking = LIMIT**2 / (2 * COMFORT)
    assert time == pytest.approx((100.0 - braking) / LIMIT + LIMIT / COMFORT, abs=1.5)  # the soft end takes a second


@given(speed=st.floats(0.3, 15.0), distance=st.floats(0.0, 200.0))
def test_the_slowing_ends_with_the_budget_and_never_brakes_above_its_bound(speed: float, distance: float) -> None:
    made = slowing(speed, distance, BudgetSettings())
    assert made.budget_s <= 15.0
    assert made.deceleration_m_s2 <= 2.0 + 1e-9
    assert speed - made.deceleration_m_s2 * made.budget_s == pytest.approx(0.0, abs=1e-9)
    assert made.distance_m == pytest.approx(speed * made.budget_s - made.deceleration_m_s2 * made.budget_s**2 / 2)


def test_45_m_at_25_km_h_give_13_seconds() -> None:
    assert slowing(6.9, 45.0, BudgetSettings()).budget_s == pytest.approx(2 * 45.0 / 6.9)
