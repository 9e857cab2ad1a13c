"""Samples to spans, and curves to few points: nothing that happened may get lost on the way."""

from hypothesis import given
from hypothesis import strategies as st

from recordings.incident.axis import step_of
from recordings.incident.film import moments
from recordings.incident.spans import Span, acted, held, newest
from recordings.incident.svg import text, thinned

TIMES = st.lists(st.integers(0, 10_000), max_size=60).map(lambda times: [time / 1e3 for time in sorted(times)])


def test_a_value_holds_from_its_change_to_the_next():
    samples = [(0.0, "a"), (1.0, "a"), (2.0, "b"), (3.0, "a")]
    assert held(samples, 5.0) == [Span("a", 0.0, 2.0, 2), Span("b", 2.0, 3.0, 1), Span("a", 3.0, 5.0, 1)]
    assert held([], 5.0) == []


@given(TIMES)
def test_spans_of_what_comes_and_goes_hold_every_sample_and_no_long_gap(times: list[float]):
    spans = acted((time, ("rule",)) for time in times)
    assert sum(span.samples for span in spans) == len(times)
    assert len(spans) == (sum(b - a > 0.5 for a, b in zip(times, times[1:], strict=False)) + 1 if times else 0)
    assert all(any(span.from_s <= time <= span.until_s for span in spans) for time in times)


def test_what_was_known_at_a_moment_is_the_last_not_after_it():
    samples = [(0.0, "a"), (1.0, "b")]
    assert [newest(samples, at) for at in (-0.1, 0.0, 0.9, 1.0, 9.0)] == [None, "a", "a", "b", "b"]


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=3000), st.integers(1, 50))
def test_a_thinned_curve_keeps_its_ends_and_its_extremes(values: list[float], columns: int):
    points = [(float(number), value) for number, value in enumerate(values)]
    kept = thinned(points, columns)
    assert set(kept) <= set(points) and kept == sorted(kept)
    assert len(kept) <= max(4 * (columns + 1), 4)
    assert (kept[0], kept[-1]) == (points[0], points[-1])
    assert {min(y for _, y in kept), max(y for _, y in kept)} == {min(values), max(values)}


@given(st.floats(0.01, 1e4), st.integers(2, 20))
def test_a_scale_has_round_steps_and_not_too_many(span: float, most: int):
    step = step_of(span, most)
    assert span / step <= most * (1 + 1e-6)
    assert f"{step:e}"[0] in "125" and abs(float(f"{step:.0e}") - step) < 1e-9 * step


@given(st.floats(0.5, 120), st.floats(0.5, 120))
def test_the_strip_shows_t_and_both_ends_of_the_window(before_s: float, after_s: float):
    times = moments(before_s, after_s)
    assert 0.0 in times and list(times) == sorted(times)
    assert abs(times[0] + before_s) < 1e-9 or times[0] == 0.0
    assert abs(times[-1] - after_s) < 1e-9 or times[-1] == 0.0


def test_words_from_a_recording_are_words_on_the_page_whatever_they_hold():
    assert "<script>" not in text(0.0, 0.0, "<script>alert(1)</script>")
