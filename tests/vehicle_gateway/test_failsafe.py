"""The list of causes around each of its limits, and that only a source that drives or receives can be missed."""

from itertools import product

import pytest
from msgspec.structs import replace

from vehicle_gateway.authority import Event, Source
from vehicle_gateway.failsafe import RULES, Ages, Cause, FailsafeLimits, Response, active_causes, brakes_gently

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
    rolled_away=True,
    way_known=False,
)
OPERATOR = {Cause.COMMAND_LOST, Cause.PICTURE_LOST, Cause.LOOP_TOO_SLOW}

# field, last value that is still good, first that is not, cause, who drives
EDGES = [
    ("feedback_ms", 100.0, 100.1, Cause.FEEDBACK_LOST, Source.OPERATOR),
    ("feedback_ms", 100.0, 100.1, Cause.FEEDBACK_LOST, Source.AUTONOMY),
    ("ecu_following", True, False, Cause.ECU_FAULT, Source.OPERATOR),
    ("ecu_following", True, False, Cause.ECU_FAULT, Source.AUTONOMY),
    ("command_ms", 120.0, 120.1, Cause.COMMAND_SILENT, Source.OPERATOR),
    ("way_known", True, False, Cause.WAY_UNKNOWN, Source.OPERATOR),
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


def test_a_car_that_rolls_away_is_noticed_whoever_drives_but_the_person_in_it():
    for driving in set(Source) - {Source.LOCAL}:
        assert active_causes(replace(FINE, rolled_away=True), driving, None, LIMITS) == (Cause.ROLLED_AWAY,)


def test_causes_come_worst_first_and_only_late_commands_are_recoverable():
    assert active_causes(DEAD, Source.OPERATOR, Source.AUTONOMY, LIMITS) == tuple(Cause) == tuple(RULES)
    responses = [rule.response for rule in RULES.values()]
    assert responses == sorted(responses, reverse=True)
    assert [cause for cause in Cause if RULES[cause].event is None] == [Cause.COMMAND_SILENT, Cause.WAY_UNKNOWN]


def test_a_cause_that_stops_tells_the_authority_and_no_other_does():
    for rule in RULES.values():
        assert (rule.response >= Response.STOP) == (rule.event is not None)


def test_only_late_commands_are_braked_for_gently():
    for cause in Cause:
        assert brakes_gently((cause,)) == (cause is Cause.COMMAND_SILENT)
    assert brakes_gently(tuple(Cause))
    assert not brakes_gently(())


# cause, what is still wrong enough to keep it while the car stands, what ends it; each from a car where all else is fine
CLEARS = [
    (Cause.ROLLED_AWAY, {"standing": False}, {"standing": True}),
    (Cause.FEEDBACK_LOST, {"feedback_ms": 100.1}, {"feedback_ms": 100.0}),
    (Cause.ECU_FAULT, {"ecu_following": False}, {"ecu_following": True}),
    (Cause.COMMAND_LOST, {"command_ms": 120.1}, {"command_ms": 120.0}),
    (Cause.PICTURE_LOST, {"picture_ms": 200.1}, {"picture_ms": 200.0}),
    (Cause.LOOP_TOO_SLOW, {"loop_too_slow_s": 0.01}, {"loop_too_slow_s": 0.0}),
    (Cause.AUTONOMY_LOST, {"autonomy_ms": 200.1}, {"autonomy_ms": 200.0}),
    (Cause.AUTONOMY_LOST, {"autonomy_status_ms": 500.1}, {"autonomy_status_ms": 500.0}),
    (Cause.AUTONOMY_LOST, {"autonomy_healthy": False}, {"autonomy_healthy": True}),
    (Cause.COMMAND_SILENT, {"command_ms": 120.1}, {"command_ms": 120.0}),
    (Cause.WAY_UNKNOWN, {"way_known": False}, {"way_known": True}),
]


@pytest.mark.parametrize(("cause", "kept", "gone"), CLEARS)
def test_what_stopped_the_car_stays_until_its_rule_says_that_it_is_gone(cause, kept, gone):
    standing = replace(FINE, standing=True)
    still = active_causes(replace(standing, **kept), Source.GATEWAY, None, LIMITS, (cause,))
    assert still == (cause,)
    assert active_causes(replace(standing, **gone), Source.GATEWAY, None, LIMITS, (cause,)) == ()


def test_a_lost_operator_or_car_is_back_only_once_the_car_stands():
    lost = tuple(cause for cause in Cause if RULES[cause].event in (Event.FAULT, Event.OPERATOR_LOST))
    assert active_causes(FINE, Source.GATEWAY, None, LIMITS, tuple(Cause)) == lost
    assert active_causes(replace(FINE, standing=True), Source.GATEWAY, None, LIMITS, tuple(Cause)) == ()


def test_a_cause_is_not_kept_when_somebody_else_drives_and_none_begins_by_itself_while_the_gateway_does():
    for driving in set(Source) - {Source.GATEWAY}:
        assert active_causes(FINE, driving, None, LIMITS, tuple(Cause)) == ()
    assert active_causes(replace(DEAD, rolled_away=False), Source.GATEWAY, None, LIMITS) == ()


def test_every_cause_tells_the_authority_who_was_lost_and_the_operator_what_happened_and_what_clears_it():
    lost = {
        Cause.ROLLED_AWAY: Event.FAULT,
        Cause.FEEDBACK_LOST: Event.FAULT,
        Cause.ECU_FAULT: Event.FAULT,
        Cause.COMMAND_LOST: Event.OPERATOR_LOST,
        Cause.PICTURE_LOST: Event.OPERATOR_LOST,
        Cause.LOOP_TOO_SLOW: Event.OPERATOR_LOST,
        Cause.AUTONOMY_LOST: Event.AUTONOMY_LOST,
        Cause.COMMAND_SILENT: None,
        Cause.WAY_UNKNOWN: None,
    }
    assert {cause: rule.event for cause, rule in RULES.items()} == lost
    assert all(rule.text and rule.when and rule.clears for rule in RULES.values())


def test_late_commands_brake_gently_and_anything_else_leaves_braking_to_the_safe_stop():
    assert -2.5 < LIMITS.gentle_braking_m_s2 < 0.0
