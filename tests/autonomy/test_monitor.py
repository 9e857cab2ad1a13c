"""Hysteresis and the one request, against a plainer account of when a level was high."""

from hypothesis import given
from hypothesis import strategies as st

from autonomy.uncertainty.channels import Level
from autonomy.uncertainty.monitor import MonitorSettings, MonitorState, Trouble, clear_s, judge
from wire.messages.automation import Doubt

SETTINGS = MonitorSettings()
TROUBLE = Trouble(budget_s=12.0, place=(1.0, 2.0))
STEP_NS = 100_000_000


def run(rows: list[dict[str, float]], state: MonitorState | None = None, start: int = 0) -> list[MonitorState]:
    """One look every 0.1 s."""
    made, states = state or MonitorState(), []
    for i, row in enumerate(rows):
        levels = [Level(name, level, f"{name} speaks") for name, level in row.items()]
        made = judge(made, levels, TROUBLE, (start + i) * STEP_NS, SETTINGS)
        states.append(made)
    return states


def test_a_third_of_a_second_is_needed_to_ask_and_three_seconds_to_let_go() -> None:
    states = run([{"planner": 1.0}] * 10 + [{"planner": 0.0}] * 40)
    assert [state.doubt for state in states[:4]] == [Doubt.CAUTION, Doubt.CAUTION, Doubt.CAUTION, Doubt.REQUEST]
    open_until = max(i for i, state in enumerate(states) if state.request is not None)
    assert open_until == 10 + 29  # low since the tenth look, let go 3.0 s later
    assert states[-1].doubt is Doubt.NOMINAL


def test_when_the_request_closes_the_way_has_been_clear_for_three_seconds() -> None:
    states = run([{"planner": 1.0}] * 10 + [{"planner": 0.0}] * 40)
    closed = next(i for i, state in enumerate(states) if i > 10 and state.request is None)
    assert clear_s(states[closed], closed * STEP_NS) == 3.0


def test_a_short_doubt_is_caution_only() -> None:
    states = run([{"map": 1.0}] * 3 + [{"map": 0.0}] * 10)
    assert all(state.request is None for state in states)
    assert states[0].doubt is Doubt.CAUTION and states[-1].doubt is Doubt.NOMINAL


def test_a_second_reason_joins_the_request_under_the_same_number() -> None:
    states = run([{"planner": 1.0, "map": 0.0}] * 6 + [{"planner": 1.0, "map": 1.0}] * 6)
    first, last = states[4].request, states[-1].request
    assert first is not None and last is not None
    assert (first.number, first.raised_ns, first.budget_s) == (last.number, last.raised_ns, last.budget_s)
    assert [reason.channel for reason in first.reasons] == ["planner"]
    assert [reason.channel for reason in last.reasons] == ["planner", "map"]


def test_the_next_trouble_gets_the_next_number() -> None:
    states = run([{"a": 1.0}] * 5 + [{"a": 0.0}] * 35 + [{"a": 1.0}] * 5)
    numbers = [state.request.number for state in states if state.request is not None]
    assert sorted(set(numbers)) == [1, 2]


def test_a_wavering_level_keeps_the_request_open() -> None:
    states = run([{"a": 1.0}] * 5 + [{"a": 0.0}, {"a": 0.6}] * 100)
    assert states[-1].request is not None
    assert clear_s(states[-1], len(states) * STEP_NS) == 0.0


@given(st.lists(st.sampled_from([0.0, 0.3, 0.6, 0.9]), min_size=1, max_size=120))
def test_a_request_is_raised_exactly_by_four_looks_in_a_row_at_the_threshold(levels: list[float]) -> None:
    states = run([{"a": level} for level in levels])
    for i, state in enumerate(states):
        before = states[i - 1].request if i else None
        four = i >= 3 and all(level >= 0.8 for level in levels[i - 3 : i + 1])
        if before is None:
            assert (state.request is not None) == four
        elif state.request is None:
            assert i >= 30 and all(level < 0.5 for level in levels[i - 30 : i + 1])
