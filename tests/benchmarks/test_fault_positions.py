"""How far the automation was from where it believed to be, against a car whose place is a formula; and when it doubted that."""

from math import inf

import pytest

from benchmarks.fault_positions import NOTICE_S, OFF_MAX_M, Believed, finding, off_m, truth
from wire.messages.sensing import Referee

MS, SPEED_M_S = 1_000_000, 4.0


def x_m(stamp_ns):
    return SPEED_M_S * stamp_ns / 1e9


def entry(stamp_ns):
    return Referee(
        stamp_ns=stamp_ns,
        elapsed_s=stamp_ns / 1e9,
        station_m=x_m(stamp_ns),
        offset_m=0.0,
        x_m=x_m(stamp_ns),
        y_m=-1.75,
        speed_m_s=SPEED_M_S,
        distance_m=x_m(stamp_ns),
        collisions=0,
        collided_with="",
        goal_reached=False,
        closest_m=9.0,
    )


LOG = [entry(at * MS) for at in range(0, 5001, 100)]


def status(stamp_ms, high, channel="localization"):
    return {"stamp_ns": stamp_ms * MS, "evidence": [{"channel": channel, "high": high}]}


@pytest.mark.parametrize("stamp_ms", [1, 99, 100, 1234, 4999])
def test_between_two_entries_the_car_is_between_them(stamp_ms):
    assert truth(LOG, stamp_ms * MS) == pytest.approx((x_m(stamp_ms * MS), -1.75))


def test_outside_of_the_log_nothing_is_known():
    assert truth(LOG, 5001 * MS) is None
    assert truth([], MS) is None


def test_the_farthest_since_then_counts():
    places = [(500 * MS, x_m(500 * MS) + 3.0, -1.75), (1500 * MS, x_m(1500 * MS) + 0.3, -1.35), (2500 * MS, x_m(2500 * MS), -1.75)]
    assert off_m(places, LOG, 1000 * MS) == pytest.approx(0.5)
    assert off_m(places, LOG, 3000 * MS) == inf


@pytest.mark.parametrize(
    ("doubts_ms", "channel", "off", "holds"),
    [
        (1500, "localization", 0.1, True),
        (1500, "planner", 0.1, False),
        (1000 + round(NOTICE_S * 1000) + 1, "localization", 0.1, False),
        (900, "localization", 0.1, False),
        (1500, "localization", OFF_MAX_M + 0.01, False),
    ],
)
def test_it_holds_when_the_automation_doubts_its_place_in_time_and_was_not_far_off(doubts_ms, channel, off, holds):
    believed = Believed()
    believed.take("autonomy_status", status(doubts_ms, True, channel), 0)
    believed.take("autonomy_status", status(1200, False), 0)
    believed.take("scene", {"stamp_ns": 2000 * MS, "x_m": x_m(2000 * MS) + off, "y_m": -1.75}, 0)
    assert finding(believed, LOG, 1000 * MS).holds is holds
