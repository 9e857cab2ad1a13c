"""A fixed-rate loop on a clock that moves only when somebody waits: deadlines, skipped ticks, lateness, and the end."""

import threading
import time
from typing import cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wire.clock import Clock, utc_minus_monotonic_ns
from wire.pace import Lateness, Pace, raise_priority

MS = 1_000_000
PERIOD = 10 * MS


class Time:
    """Clock and stop event in one: waiting moves the time, by a little more than asked for when `late_ns` says so."""

    def __init__(self, late_ns: int = 0) -> None:
        self.now, self.late_ns, self.stopped = 7 * 10**12, late_ns, False

    def now_ns(self) -> int:
        return self.now

    def real_s(self, duration_ns: int) -> float:
        return duration_ns / 1e9

    def wait(self, timeout: float) -> bool:
        if not self.stopped:
            self.now += round(timeout * 1e9) + (self.late_ns if timeout > 0 else 0)
        return self.stopped


def pace_of(world: Time) -> Pace:
    return Pace(PERIOD / 1e9, cast(Clock, world), cast(threading.Event, world))


def ticks(world: Time, pace: Pace, bodies_ns: list[int]) -> list[int]:
    """When the loop's body ran, from the start; it takes this long each time."""
    start, seen = world.now, []
    bodies = iter(bodies_ns)
    for now_ns in pace:
        seen.append(now_ns - start)
        body_ns = next(bodies, None)
        if body_ns is None:
            world.stopped = True
        else:
            world.now += body_ns
    return seen


def test_cycles_come_on_their_deadlines_whatever_the_body_takes_below_a_period():
    world = Time()
    assert ticks(world, pace_of(world), [0, 3 * MS, 9 * MS, 1 * MS]) == [0, PERIOD, 2 * PERIOD, 3 * PERIOD, 4 * PERIOD]


def test_a_late_wake_up_does_not_drift():
    world = Time(late_ns=2 * MS)
    seen = ticks(world, pace_of(world), [0] * 50)
    assert seen[-1] == 50 * PERIOD + 2 * MS


@given(st.lists(st.integers(0, 100 * MS), max_size=30), st.integers(0, 3 * MS))
def test_missed_ticks_are_skipped_and_never_made_up_in_a_burst(bodies, late):
    world = Time(late)
    seen = ticks(world, pace_of(world), bodies)
    for before, after, body in zip(seen, seen[1:], bodies, strict=False):
        assert after - before >= body
    for first, third in zip(seen, seen[2:], strict=False):
        assert third - first >= PERIOD - late, "two cycles within one period"
    assert len(seen) <= seen[-1] // PERIOD + 2


def test_a_body_that_took_three_periods_too_long_is_told_as_late():
    world = Time()
    pace = pace_of(world)
    ticks(world, pace, [0, 35 * MS, 0, 0])
    health = pace.health("p", "l")
    assert health.late_cycles >= 1
    assert health.lateness_max_ms >= 20.0


def test_a_wake_up_later_than_a_period_is_counted():
    world = Time(late_ns=25 * MS)
    pace = pace_of(world)
    ticks(world, pace, [0, 0, 0])
    health = pace.health("gateway", "cycle", {"x": 3})
    assert health.cycles == 4
    assert health.late_cycles >= 2  # the wake-up that comes 5 ms after its own deadline may count for the one skipped before it
    assert health.lateness_max_ms == pytest.approx(25.0)
    assert (health.process, health.loop, health.period_ms, health.dropped) == ("gateway", "cycle", 10.0, {"x": 3})


def test_lateness_is_told_of_the_last_second_only_and_counts_since_the_start():
    lateness = Lateness(PERIOD)
    lateness.add(0, 900 * MS)
    for cycle in range(100, 200):
        lateness.add(cycle * PERIOD, cycle * PERIOD + cycle % 3 * MS)
    health = lateness.health("p", "l", 200 * PERIOD, "other", {})
    assert (health.cycles, health.late_cycles) == (101, 1)
    assert (health.lateness_p50_ms, health.lateness_max_ms) == (1.0, 2.0)


def test_the_latest_of_the_last_second_forgets_what_is_older():
    lateness = Lateness(PERIOD)
    assert lateness.latest_ns(5) == 0
    for at_ns, late_ns in ((0, 900), (500_000_000, 30), (900_000_000, 20)):
        lateness.add(at_ns - late_ns, at_ns)
    assert [lateness.latest_ns(now_ns) for now_ns in (900_000_000, 1_000_000_000, 1_000_000_001, 1_500_000_001)] == [
        900,
        900,
        30,
        20,
    ]


def test_a_loop_that_has_not_run_is_not_late():
    health = Lateness(PERIOD).health("p", "l", 5, "other", {})
    assert (health.cycles, health.lateness_max_ms) == (0, 0.0)


def test_a_real_loop_keeps_its_rate_and_ends_when_it_is_asked_to():
    stop, cycles = threading.Event(), 0
    begun = time.monotonic()
    with Pace(0.005, Clock(), stop) as pace:
        for _ in pace:
            cycles += 1
            if cycles == 40:
                stop.set()
    assert cycles == 40
    assert time.monotonic() - begun >= 39 * 0.005


def test_stopping_wakes_a_loop_that_sleeps_long():
    stop = threading.Event()
    with Pace(60.0, Clock(), stop) as pace:
        for _ in pace:
            threading.Timer(0.02, stop.set).start()
    assert stop.is_set()


def test_priority_zero_leaves_the_thread_alone_and_a_refused_one_says_why():
    assert raise_priority(0) == "other"


def test_the_tower_s_clock_is_the_car_s_clock_shifted():
    car, tower = Clock(), Clock(3600 * 10**9)
    before = car.now_ns()
    difference = tower.now_ns() - before
    assert 3600 * 10**9 <= difference < 3600 * 10**9 + 10**9


def test_unix_time_is_the_monotonic_clock_plus_its_offset():
    assert abs(time.time_ns() - (Clock().now_ns() + utc_minus_monotonic_ns())) < 10**9
