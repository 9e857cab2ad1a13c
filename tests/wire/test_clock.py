"""The clocks of a drive, in real time and in slow motion."""

import threading
import time

import pytest

from wire.clock import Clock, car_clock, tower_clock
from wire.pace import Pace
from wire.settings import ClockSettings

HOUR_NS = 3_600_000_000_000


@pytest.fixture
def system(monkeypatch):
    """The system's clock, moved by hand."""
    now = [5_000_000_000]
    monkeypatch.setattr(time, "monotonic_ns", lambda: now[0])
    return now


def test_in_real_time_a_clock_is_the_systems_shifted_by_a_constant(system):
    settings = ClockSettings(tower_offset_ns=HOUR_NS, slowed_since_ns=3)
    assert car_clock(settings).now_ns() == Clock().now_ns() == 5_000_000_000
    assert tower_clock(settings).now_ns() == 5_000_000_000 + HOUR_NS


def test_in_slow_motion_all_clocks_of_a_drive_go_on_from_where_they_agreed_and_keep_their_distance(system):
    settings = ClockSettings(tower_offset_ns=HOUR_NS, real_time_factor=0.5, slowed_since_ns=4_000_000_000)
    car, tower = car_clock(settings), tower_clock(settings)
    assert car.now_ns() == 4_500_000_000
    system[0] += 2_000_000_000
    assert car.now_ns() == 5_500_000_000
    assert tower.now_ns() - car.now_ns() == HOUR_NS
    assert car.real_s(1_000_000_000) == 2.0


@pytest.mark.parametrize("clock", [Clock(), Clock(HOUR_NS), Clock(HOUR_NS, 0.5, 4_000_000_000)])
def test_an_instant_of_the_systems_clock_is_found_on_ours_and_back(system, clock: Clock):
    assert clock.at_system_ns(system[0]) == clock.now_ns()
    assert clock.system_ns(clock.at_system_ns(7_000_000_000)) == 7_000_000_000


def test_a_paced_loop_in_slow_motion_takes_as_much_longer():
    stop, clock, ticks, waited = threading.Event(), Clock(0, 0.25, time.monotonic_ns()), [], []
    real_wait = stop.wait

    def wait(timeout_s):
        waited.append(timeout_s)
        return real_wait(timeout_s)

    stop.wait = wait
    with Pace(0.01, clock, stop) as pace:
        for now_ns in pace:
            ticks.append(now_ns)
            if len(ticks) == 5:
                stop.set()
    assert ticks[-1] - ticks[0] >= 40_000_000  # on its own clock
    assert all(0.03 < each <= 0.04 for each in waited[1:3]), waited  # in real time
