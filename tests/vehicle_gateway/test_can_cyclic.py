"""Frames are due once per period in the mean, never much sooner, with counters without a gap; no cycle, no frame."""

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from vehicle_gateway.can.cyclic import Sent, take_due
from vehicle_gateway.can.layout import layouts

MS = 1_000_000
FAST = replace(layouts()["ACTUATION_COMMAND"], name="fast", least_period_ms=10)
SLOW = replace(layouts()["BODY_COMMAND"], name="slow", least_period_ms=30)
STEPS = st.lists(st.integers(4 * MS, 10 * MS), min_size=1, max_size=120)


def run(steps, pair=(FAST, SLOW)):
    """Times and counters at which each frame was sent, by name."""
    sent, now_ns, told = Sent(), 0, {layout.name: [] for layout in pair}
    for step in steps:
        sent, counters = take_due(sent, pair, now_ns)
        for name, counter in counters.items():
            told[name].append((now_ns, counter))
        now_ns += step
    return told


@settings(deadline=None)  # a busy machine is no error
@given(STEPS)
def test_every_frame_counts_for_itself_without_a_gap(steps):
    for told in run(steps).values():
        assert [counter for _, counter in told] == list(range(len(told)))


@settings(deadline=None)  # a busy machine is no error
@given(STEPS)
def test_frames_are_never_closer_than_half_a_period_and_keep_their_rate_in_the_mean(steps):
    for layout in (FAST, SLOW):
        period_ns = layout.least_period_ms * MS
        times = [at_ns for at_ns, _ in run(steps)[layout.name]]
        gaps = [later - at for at, later in zip(times, times[1:], strict=False)]
        assert all(gap <= period_ns + 10 * MS for gap in gaps), "a slot was missed"
        for first in range(len(times)):
            for last in range(first, len(times)):
                assert times[last] - times[first] >= (last - first) * period_ns - 1.25 * period_ns


def test_a_fast_gateway_sends_a_slow_frame_at_its_own_rate():
    told = run([4 * MS] * 2500)
    assert (len(told["fast"]), len(told["slow"])) == (1000, 334)


def test_a_cycle_a_quarter_of_a_period_early_sends_and_one_earlier_than_that_waits():
    sent, _ = take_due(Sent(), (FAST,), 0)
    assert take_due(sent, (FAST,), round(7.5 * MS))[1] == {"fast": 1}
    assert take_due(sent, (FAST,), round(7.5 * MS) - 1)[1] == {}


def test_one_frame_that_is_not_due_keeps_no_other_from_being_sent():
    told = run([10 * MS] * 30, (SLOW, FAST))
    assert (len(told["fast"]), len(told["slow"])) == (30, 10)


def test_a_whole_period_late_is_a_slot_of_its_own_and_less_keeps_the_phase():
    sent, _ = take_due(Sent(), (FAST,), 0)
    whole, _ = take_due(sent, (FAST,), 20 * MS)
    nearly, _ = take_due(sent, (FAST,), 20 * MS - 1)
    assert (whole.due_ns, nearly.due_ns) == ({"fast": 30 * MS}, {"fast": 20 * MS})


def test_after_a_pause_nothing_is_made_up_for():
    sent, _ = take_due(Sent(), (FAST,), 0)
    sent, counters = take_due(sent, (FAST,), 1000 * MS)
    assert counters == {"fast": 1}
    assert take_due(sent, (FAST,), 1001 * MS)[1] == {}
