"""Tests of benchmarks/endurance.py: the first seconds of the first two hours."""

from benchmarks.endurance import day
from wire.messages.vehicle import Mode


def test_the_operator_of_the_story_takes_over_in_the_third_second_and_drives_on_into_the_next_hour():
    first, second = day(2, hour_cycles=400)
    assert [mode for _, mode in first.changes] == [Mode.AUTONOMOUS, Mode.HANDING_OVER, Mode.REMOTE]
    assert first.changes[1][0] == 200
    assert second.changes == ()
    assert first.state_bytes > 1000
    assert first.cycle_us > 0.0
