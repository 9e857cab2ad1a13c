"""The bounds of the fault campaign against a plain sum over milliseconds, and its table of kinds."""

from math import isclose

import pytest

from benchmarks.fault_bounds import ACTUATION_S, STILL_PICTURE, Braking, NoticedByMetres, after
from benchmarks.fault_kinds import KINDS

MS_S = 0.001


def rolled_m(speed_m_s: float, noticed_after_m: float, noticed_after_s: float, then: Braking) -> float:
    """Full traction until it is noticed and acted on, then braking that builds up; in steps of a millisecond."""
    speed, way, time_s, braking = speed_m_s, 0.0, 0.0, 0.0
    left_s = then.notice_s + ACTUATION_S
    while speed > 0.0:
        noticed = way >= noticed_after_m and time_s >= noticed_after_s
        left_s -= MS_S if noticed else 0.0
        if left_s > 0.0:
            speed += 2.0 * MS_S
        else:
            braking = min(braking + then.jerk_m_s3 * MS_S, then.braking_m_s2)
            speed -= braking * MS_S
        way += speed * MS_S
        time_s += MS_S
    return way


@pytest.mark.parametrize("speed_m_s", [2.5, 4.0, 8.3])
def test_a_bound_holds_a_car_that_accelerates_until_it_brakes_and_is_not_twice_as_long(speed_m_s):
    for bound, metres, seconds in ((after(500.0), 0.0, 0.0), (STILL_PICTURE, 5.0, 1.0)):
        then = bound.then if isinstance(bound, NoticedByMetres) else bound
        rolled = rolled_m(speed_m_s, metres, seconds, then)
        assert rolled <= bound.bound_m(speed_m_s) <= 1.5 * rolled


def test_what_is_noticed_by_metres_counts_them_and_the_speed_gained_on_them():
    then = Braking(0.0, 2.5, 5.0)
    assert isclose(NoticedByMetres(6.0, 0.5, then).bound_m(5.0), 6.0 + then.bound_m(7.0))  # 7^2 = 5^2 + 2 * 2 * 6
    assert isclose(NoticedByMetres(6.0, 2.0, then).bound_m(5.0), 18.0 + then.bound_m(9.0))  # 2 s at 2 m/s2


def test_every_kind_has_a_name_of_its_own():
    names = [kind.name for kind in KINDS]
    assert len(names) == len(set(names)) >= 55
