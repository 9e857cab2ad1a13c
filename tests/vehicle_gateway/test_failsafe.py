"""The list of causes around each of its limits, and that only a source that drives or receives can be missed."""

from itertools import product

import pytest
from msgspec.structs import replace

from vehicle_gateway.authority import Event, Source
from vehicle_gateway.failsafe import RULES, Ages, Cause, FailsafeLimits, active_causes

LIMITS = FailsafeLimits()
FINE = Ages(
    feedback_ms=10.0,
    ecu_following=True,
    command_ms=10.0,
    picture_ms=33.0,
    loop_too_slow_s=0.0,
    autonomy_ms=10.0,
    autonomy_status_ms=50.0,
    autonomy_healthy=True,
)
NEVER = 1e9
DEAD = Ages(
    feedback_ms=NEVER,
    ecu_following=False,
    command_ms=NEVER,
    picture_ms=NEVER,
    loop_too_slow_s=NEVER,
    autonomy_ms=NEVER,
    autonomy_status_ms=NEVER,
    autonomy_healthy=False,
)
OPERATOR = {Cause.COMMAND_LOST, Cause.PICTURE_LOST, Cause.LOOP_TOO_SLOW}

# field, last value that is still good, first that is not, cause, who drives
EDGES = [
    ("feedback_ms", 100.0, 100.1, Cause.FEEDBACK_LOST, Source.OPERATOR),
    ("feedback_ms", 100.0, 100.1, Cause.FEEDBACK_LOST, Source.AUTONOMY),
    ("ecu_following", True, False, Cause.ECU_FAULT, Source.OPERATOR),
    ("ecu_following", True, False, Cause.ECU_FAULT, Source.AUTONOMY),
    ("command_ms", 120.0, 120.1, Cause.COMMAND_SILENT, Source.OPERATOR),
    ("picture_ms", 200.0, 200.1, Cause.PICTURE_LOST, Source.OPERATOR),
    ("loop_too_slow_s", 0.99, 1.0, Cause.LOOP_TOO_SLOW, Source.OPERATOR),
    ("autonomy_ms", 200.0, 200.1, Cause.AUTONOMY_LOST, Source.AUTONOMY),
    ("autonomy_status_ms", 500.0, 500.1, Cause.AUTONOMY_LOST, Source.AUTONOMY),
    ("autonomy_healthy", True, False, Cause.AUTONOMY_LOST, Source.AUTONOMY),
]


@pytest.mark.parametrize(("field", "good", "bad", "cause", "driving"), EDGES)
def test_each_cause_begins_exactly_at_its_limit(field, good, bad, cause, driving):
    assert active_causes(replace(FINE, **{field: good}), driving, None, LIMITS) == ()
    assert active_causes(replace(FINE, **{field: bad}), driving, None, LIMITS) == (cause,)


def test_half_a_second_without_a_command_is_a_lost_operator_on_top_of_a_silent_one():
    for age, expected in ((500.0, (Cause.COMMAND_SILENT,)), (500.1, (Cause.COMMAND_LOST, Cause.COMMAND_SILENT))):
        assert active_causes(replace(FINE, command_ms=age), Source.OPERATOR, None, LIMITS) == expected


def test_a_source_that_is_not_needed_is_never_missed():
    for driving, receiving in product(Source, (None, Source.OPERATOR, Source.AUTONOMY)):
        found = set(active_causes(DEAD, driving, receiving, LIMITS))
        assert (found >= OPERATOR) == (driving is Source.OPERATOR)
        assert bool(OPERATOR & found) == (driving is Source.OPERATOR)  # who receives has 300 ms to answer instead
        assert (Cause.AUTONOMY_LOST in found) == (Source.AUTONOMY in {driving, receiving})
        assert (Cause.COMMAND_SILENT in found) == (driving is Source.OPERATOR)


def test_nothing_of_ours_counts_while_a_person_in_the_car_drives():
    assert active_causes(DEAD, Source.LOCAL, None, LIMITS) == ()


def test_causes_come_worst_first_and_only_late_commands_are_recoverable():
    assert active_causes(DEAD, Source.OPERATOR, Source.AUTONOMY, LIMITS) == tuple(Cause)
    assert [cause for cause in Cause if RULES[cause].event is None] == [Cause.COMMAND_SILENT]


def test_every_cause_tells_the_authority_who_was_lost_and_the_operator_what_happened_and_what_clears_it():
    lost = {
        Cause.FEEDBACK_LOST: Event.FAULT,
        Cause.ECU_FAULT: Event.FAULT,
        Cause.COMMAND_LOST: Event.OPERATOR_LOST,
        Cause.PICTURE_LOST: Event.OPERATOR_LOST,
        Cause.LOOP_TOO_SLOW: Event.OPERATOR_LOST,
        Cause.AUTONOMY_LOST: Event.AUTONOMY_LOST,
        Cause.COMMAND_SILENT: None,
    }
    assert {cause: rule.event for cause, rule in RULES.items()} == lost
    assert all(rule.text and rule.clears for rule in RULES.values())


def test_late_commands_brake_gently_and_anything_else_leaves_braking_to_the_safe_stop():
    assert -2.5 < LIMITS.gentle_braking_m_s2 < 0.0
