"""The failsafe's responses in their order, and what is assumed where a recording from before says nothing."""

from vehicle_gateway.failsafe import Ages, Response


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
