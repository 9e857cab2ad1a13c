"""The failsafe's responses in their order, and what is assumed where a recording from before says nothing."""

from vehicle_gateway.failsafe import RULES, Ages, Response

TOLD = {
    "rolled_away": "the car rolls against its gear, or with its brakes held",
    "feedback_lost": "no CAN feedback from the car",
    "ecu_fault": "the drive-by-wire does not follow",
    "command_lost": "no valid command from the tower",
    "picture_lost": "the operator has no new picture",
    "loop_too_slow": "the loop is too slow to drive",
    "autonomy_lost": "the automation is lost",
    "command_silent": "commands are late: braking gently",
    "way_unknown": "nobody looks at the way ahead: no faster than a blind stop allows",
}


def test_the_operator_is_told_each_cause_in_these_words_worst_first():
    assert [(str(cause), rule.text) for cause, rule in RULES.items()] == list(TOLD.items())


def test_responses_are_ordered_from_nothing_to_holding_the_car():
    assert [(response.name, int(response)) for response in Response] == [
        ("NONE", 0),
        ("WARN", 1),
        ("GENTLE", 2),
        ("STOP", 3),
        ("HOLD", 4),
    ]


def test_an_old_recording_that_says_nothing_of_rolling_and_the_way_changes_nothing():
    silent = {"feedback_ms": 0.0, "command_ms": 0.0, "picture_ms": 0.0, "loop_too_slow_s": 0.0, "autonomy_ms": 0.0}
    ages = Ages(**silent, autonomy_status_ms=0.0, ecu_following=True, autonomy_healthy=True)
    assert (ages.standing, ages.rolled_away, ages.way_known) == (False, False, True)
