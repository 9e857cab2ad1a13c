"""Counters that restart, counters that are told twice."""

from itertools import pairwise
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from recordings.counters import counted
from recordings.drive import CycleRow, StatusRow
from recordings.summary_counts import gate_interventions, messages_dropped
from wire.messages.vehicle import Mode


@given(st.lists(st.lists(st.integers(0, 5), min_size=1, max_size=8), min_size=1, max_size=4))
def test_a_counter_that_restarts_counts_on(lives: list[list[int]]) -> None:
    """Each life of a process counts increments up from its first; a life must begin below where the last one ended."""
    told, total = [], 0
    for life in lives:
        count = 0
        for increment in life:
            count += increment
            told.append(count)
        total += count
    restarts = [sum(life) for life in lives]
    firsts = [life[0] for life in lives]
    if all(first < before for before, first in zip(restarts, firsts[1:], strict=False)):
        assert counted(told) == total
    else:
        assert counted(told) <= total  # a restart that cannot be seen is never invented


def test_what_several_loops_of_a_process_repeat_counts_once(build: Any) -> None:
    health = [
        build.health("tower cockpit", "commands", 1, dropped={"late": 3}),
        build.health("tower cockpit", "platform", 1, dropped={"late": 4}),
        build.health("autonomy run", "plan", 1, dropped={"late": 10, "wrong": 1}),
    ]
    assert messages_dropped([], health) == {"late": 4 + 10, "wrong": 1}


def test_what_the_gateway_says_twice_counts_once(build: Any) -> None:
    statuses = [StatusRow(1, build.status(1, Mode.REMOTE, 1, dropped={"old epoch": 5}))]
    health = [
        build.health("vehicle-gateway run", "cycle", 1, dropped={"old epoch": 4}),
        build.health("vehicle-gateway video", "camera front", 1, dropped={"old epoch": 1}),
    ]
    assert messages_dropped(statuses, health) == {"old epoch": 5 + 1}


@given(st.lists(st.sets(st.sampled_from(["cap", "rate", "speed"])), min_size=1, max_size=40))
def test_episodes_are_what_a_person_with_a_pencil_counts(cycles: list[set[str]]) -> None:
    rows = [CycleRow(at, 0, 0, False, 0.0, Mode.REMOTE, tuple(sorted(rules))) for at, rules in enumerate(cycles)]
    by_hand = {}
    for rule in ("cap", "rate", "speed"):
        line = "".join("#" if rule in rules else "." for rules in cycles)
        begun = sum(pair == (".", "#") for pair in pairwise("." + line))
        if begun:
            by_hand[rule] = begun
    assert gate_interventions(rows) == by_hand
