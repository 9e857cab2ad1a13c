"""The moment of a dossier, as a person says it."""

from datetime import UTC, datetime

import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.errors import RecordingError
from recordings.incident.moment import moment_ns

S = 10**9
START = round(datetime(2026, 3, 1, 23, 59, 50, tzinfo=UTC).timestamp()) * S
END = START + 60 * S  # over midnight
AUDIT = {17: START + 5 * S, 18: START + 6 * S}


@pytest.mark.parametrize(
    ("said", "seconds"),
    [("0", 0), ("12.5", 12.5), ("60", 60), ("23:59:52", 2), ("0:00:07.25", 17.25), ("00:00:50", 60), ("#17", 5), ("#18", 6)],
)
def test_each_way_to_say_it(said: str, seconds: float):
    assert moment_ns(said, START, END, AUDIT) == START + round(seconds * S)


@pytest.mark.parametrize(
    "said", ["", "noon", "12:00", "25:00:00", "12:00:60", "#", "#16", "#x", "nan", "1e400", "-1", "60.5", "12:00:00"]
)
def test_what_is_no_moment_of_the_recording_is_told_with_what_is_possible(said: str):
    with pytest.raises(RecordingError, match="--at takes seconds from the start") as told:
        moment_ns(said, START, END, AUDIT)
    assert f"--at {said}" in str(told.value)


@given(st.integers(0, 60_000))
def test_a_time_of_day_and_seconds_from_the_start_mean_the_same(milliseconds: int):
    at_ns = START + milliseconds * 1_000_000
    clock = datetime.fromtimestamp(at_ns // S, UTC).strftime("%H:%M:%S") + f".{at_ns % S // 1_000_000:03d}"
    assert moment_ns(clock, START, END, {}) == at_ns == moment_ns(f"{milliseconds / 1e3}", START, END, {})
