"""Take-over requests that end otherwise than well, and modes around a restart."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from recordings.drive import StatusRow
from recordings.summary_modes import seconds_by_mode, takeovers
from wire.messages.vehicle import Mode

S = 1_000_000_000


def told(build: Any, *rows: tuple[float, Mode, float, Any]) -> list[StatusRow]:
    """(second, mode, since second, request)"""
    return [StatusRow(int(at * S), build.status(int(at * S), mode, int(since * S), request)) for at, mode, since, request in rows]


def times(found: Any) -> list[tuple[float, float | None]]:
    return [(takeover.requested_s, takeover.takeover_time_s) for takeover in found]


def test_a_request_that_nobody_accepts_stays_open(build: Any) -> None:
    request = build.request(1, 2 * S)
    rows = told(
        build,
        (1, Mode.AUTONOMOUS, 0, None),
        (2, Mode.TAKEOVER_REQUESTED, 2, request),
        (10, Mode.SAFE_STOP, 10, request),
        (12, Mode.STOPPED, 12, request),
    )
    (takeover,) = takeovers(rows, 0) or ()
    assert (takeover.requested_s, takeover.accepted_s, takeover.takeover_time_s) == (2.0, None, None)


def test_a_withdrawn_request_is_not_accepted_by_a_later_take_over(build: Any) -> None:
    request = build.request(1, 2 * S)
    rows = told(build, (2, Mode.TAKEOVER_REQUESTED, 2, request), (4, Mode.AUTONOMOUS, 4, None), (60, Mode.REMOTE, 60, None))
    assert times(takeovers(rows, 0)) == [(2.0, None)]


def test_a_request_first_told_while_the_car_still_drives_itself_can_be_accepted(build: Any) -> None:
    request = build.request(1, 2 * S)
    rows = told(
        build,
        (1, Mode.AUTONOMOUS, 0, None),
        (2, Mode.AUTONOMOUS, 0, request),
        (3, Mode.TAKEOVER_REQUESTED, 3, request),
        (4, Mode.HANDING_OVER, 4, request),
        (5, Mode.REMOTE, 5, request),
    )
    assert times(takeovers(rows, 0)) == [(2.0, 3.0)]


def test_doubt_while_the_operator_drives_asks_nobody(build: Any) -> None:
    rows = told(
        build,
        (1, Mode.REMOTE, 1, None),
        (2, Mode.REMOTE, 1, build.request(1, 2 * S)),
        (3, Mode.HANDING_BACK, 3, build.request(2, 3 * S)),
    )
    assert takeovers(rows, 0) == ()


def test_a_restarted_stack_that_counts_anew_asks_anew(build: Any) -> None:
    rows = told(
        build,
        (2, Mode.TAKEOVER_REQUESTED, 2, build.request(1, 2 * S)),
        (3, Mode.REMOTE, 3, None),
        (20, Mode.TAKEOVER_REQUESTED, 20, build.request(1, 20 * S)),
        (24, Mode.REMOTE, 24, None),
    )
    assert times(takeovers(rows, 0)) == [(2.0, 1.0), (20.0, 4.0)]


def test_a_request_is_dated_by_the_cars_clock_not_by_its_arrival(build: Any) -> None:
    late = [StatusRow(107 * S, build.status(5 * S, Mode.TAKEOVER_REQUESTED, 3 * S, build.request(1, 3 * S)))]
    assert times(takeovers(late, 100 * S)) == [(5.0, None)]  # told at 7 s, when it was 2 s old


def test_the_time_between_two_boots_belongs_to_no_mode(build: Any) -> None:
    rows = [
        StatusRow(at * S, build.status(at * S, mode, since * S, boot_id=boot))
        for at, mode, since, boot in (
            (1, Mode.AUTONOMOUS, 0, "a"),
            (3, Mode.AUTONOMOUS, 0, "a"),
            (9, Mode.SAFE_STOP, 8, "b"),
            (10, Mode.SAFE_STOP, 8, "b"),
        )
    ]
    assert seconds_by_mode(rows) == {"autonomous": 2.0, "safe_stop": 1.0}


def test_one_message_is_a_drive_of_no_length(build: Any) -> None:
    assert seconds_by_mode(told(build, (1, Mode.REMOTE, 0, None))) == {}
    assert seconds_by_mode([]) is None and takeovers([], 0) is None


@given(st.lists(st.tuples(st.sampled_from(list(Mode)), st.integers(1, 5000)), min_size=2, max_size=30))
def test_the_modes_together_last_as_long_as_the_drive(build: Any, spans: list[tuple[Mode, int]]) -> None:
    """Told at 20 Hz, late by up to 50 ms: a plain simulation of the gateway says how long each mode really lasted."""
    truth: dict[str, float] = {}
    timeline: list[tuple[int, Mode]] = []  # ms, mode entered
    at = 0
    for mode, span in spans:
        if not timeline or timeline[-1][1] != mode:
            timeline.append((at, mode))
        truth[mode.value] = truth.get(mode.value, 0.0) + span / 1000
        at += span
    told_at = sorted({*range(0, at, 50), *(begin for begin, _ in timeline), at})
    rows = []
    for now in told_at:
        begin, mode = max(entry for entry in timeline if entry[0] <= now)[:2]
        rows.append(StatusRow(now, build.status(now * S // 1000, mode, begin * S // 1000)))
    assert seconds_by_mode(rows) == pytest.approx(truth)
