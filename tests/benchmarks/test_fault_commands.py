"""What the car got of its operator's commands, against a plain search; and what its cycles used of them."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.fault_commands import FAR, TOLERANCE_MS, Arrival, Arrivals, Gaps, Used, gaps
from vehicle_gateway.failsafe import FailsafeLimits
from vehicle_gateway.lease import ECHO_AGE_MAX_NS

MS = 1_000_000
AHEAD_NS = -3600 * 10**9  # the tower's clock
LIMITS = FailsafeLimits()
NONE = Gaps(command_ms=8.0, picture_ms=40.0, slow_ms=8.0, oldest_ms=120.0)


def every(period_ms, from_ms, to_ms, picture_age_ms=60):
    """Commands in step, each with a picture of its own."""
    return [arrival(at, at - picture_age_ms) for at in range(from_ms, to_ms, period_ms)]


def arrival(at_ms, capture_ms, late_ms=0):
    """late_ms: longer on its way than the others."""
    return Arrival(at_ms * MS, capture_ms * MS, (at_ms - late_ms) * MS + AHEAD_NS)


def longest_ms(instants_ms, from_ms, to_ms):
    """The plain rule: look at every millisecond how long ago the last one before it was; without any, the beginning."""
    return max(at - max((each for each in instants_ms if each < at), default=from_ms) for at in range(from_ms + 1, to_ms + 1))


@given(st.sets(st.integers(1, 400), max_size=12), st.integers(50, 200), st.integers(201, 400))
def test_the_longest_silence_is_that_of_looking_every_millisecond(instants, from_ms, to_ms):
    arrivals = [arrival(at, at) for at in sorted(instants)]
    begin_ms = max((each for each in instants if each <= from_ms), default=from_ms)
    seen = gaps(arrivals, from_ms * MS, to_ms * MS)
    inside = {each for each in instants if each < to_ms} | {begin_ms}
    assert seen.command_ms == pytest.approx(longest_ms(inside, begin_ms, to_ms))
    assert seen.picture_ms == seen.command_ms == seen.slow_ms


def test_commands_that_show_no_newer_picture_leave_the_picture_old():
    still = [arrival(at, 940) for at in range(1008, 1300, 8)]
    seen = gaps(every(8, 0, 1001) + still, 1000 * MS, 1300 * MS)
    assert seen.command_ms == pytest.approx(8.0, abs=8.0)
    assert seen.picture_ms == 300.0
    assert seen.must_stop is False
    assert seen.may_stop is True


def test_a_picture_stands_as_long_as_the_sender_s_clock_says_however_late_the_command_that_tells_of_the_next():
    seen = gaps([*every(8, 0, 1001), arrival(1280, 1100, late_ms=120), arrival(1288, 1200)], 1000 * MS, 1290 * MS)
    assert (seen.command_ms, seen.picture_ms) == (280.0, 160.0)


def test_pictures_that_are_all_too_old_are_a_slow_loop():
    slow = every(40, 1000, 4000, picture_age_ms=700)
    seen = gaps(every(40, 0, 1000) + slow, 1000 * MS, 4000 * MS)
    assert (seen.oldest_ms, seen.slow_ms) == (700.0, 3040.0)
    assert seen.must_stop


@pytest.mark.parametrize(("name", "limit_ms"), [("command_ms", LIMITS.command_lost_ms), ("picture_ms", LIMITS.picture_lost_ms)])
def test_beyond_a_limit_it_must_stop_short_of_it_it_may_not_and_between_it_may(name, limit_ms):
    for ms, must, may in (
        (limit_ms + TOLERANCE_MS + 1, True, True),
        (limit_ms, False, True),
        (limit_ms - TOLERANCE_MS, False, False),
    ):
        seen = NONE._replace(**{name: ms})
        assert (seen.must_stop, seen.may_stop) == (must, may)


def test_nothing_unusual_is_no_reason_to_stop():
    assert not NONE.may_stop
    assert not NONE.must_stop


def test_only_the_operators_own_commands_with_the_dead_man_held_count():
    arrivals = Arrivals()
    own = {"sequence": 1, "dead_man": True, "displayed_capture_ns": {"front": 5 * MS}, "sent_ns": 7}
    for at_ms, message in ((10, own), (20, own | {"sequence": FAR + 1}), (30, own | {"dead_man": False}), (40, {"sequence": 2})):
        arrivals.take("drive_command", message, at_ms * MS)
    arrivals.take("gateway_status", {}, 40 * MS)
    assert arrivals.gaps(10 * MS, 100 * MS).command_ms == 90.0


def cycle(sequence, echoed_ms, received_ms, now_ms):
    command = {"sequence": sequence, "echoed_vehicle_ns": echoed_ms * MS}
    return json.loads(json.dumps({"now_ns": now_ms * MS, "inputs": {"command": command, "command_ns": received_ms * MS}}))


def test_of_what_the_cycles_used_the_oldest_when_it_came_and_the_forged_are_known():
    used = Used()
    limit_ms = ECHO_AGE_MAX_NS // MS
    for each in (
        cycle(7, 100, 130, 134),
        cycle(8, 100, 100 + limit_ms, 700),
        cycle(9, 100, 101 + limit_ms, 700),
        cycle(FAR, 690, 699, 700),
    ):
        used.take("gateway_cycle", each, 0)
    used.take("gateway_cycle", {"now_ns": 1, "inputs": {"command": None, "command_ns": 0}}, 0)
    assert (used.cycles, len(used.uses), used.oldest_ms) == (5, 4, 501.0)
    assert (used.too_old, used.forged) == (1, 1)
