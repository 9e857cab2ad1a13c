"""Which rule refuses a hand-over: one at a time, around its limit, in words."""

import pytest
from msgspec.structs import replace

from tests.messages import autonomy_status
from vehicle_gateway.hand_over import HandOverLimits, TakeView, refuse_hand_back, refuse_take
from wire.messages.automation import Doubt
from wire.messages.vehicle import Mode

LIMITS = HandOverLimits()
READY = TakeView(
    mode=Mode.AUTONOMOUS,
    lease_current=True,
    stop_pressed=False,
    recent_stops=0,
    dead_camera="",
    picture_ms=33.0,
    picture_max_ms=200.0,
    command_ms=10.0,
    dead_man=True,
    wheel_error_rad=0.0,
    throttle_pressed=False,
    loop_p95_ms=150.0,
    loop_max_ms=500.0,
    car_answers=True,
    returning=False,
)
OFFERED = autonomy_status(stamp_ns=1, sequence=1, clear_s=3.0, drivable_s=10.0)

# what is changed, the last value that is granted, the first that is refused, a word the refusal must say
TAKE_EDGES = [
    ("lease_current", True, False, "lease"),
    ("stop_pressed", False, True, "STOP"),
    ("recent_stops", 2, 3, "supervisor"),
    ("dead_camera", "", "camera front says nothing", "camera front"),
    ("picture_ms", 200.0, 200.1, "picture"),
    ("command_ms", 120.0, 120.1, "command"),
    ("dead_man", True, False, "dead-man"),
    ("wheel_error_rad", 0.0075, 0.0076, "wheel"),
    ("wheel_error_rad", -0.0075, -0.0076, "wheel"),
    ("throttle_pressed", False, True, "throttle"),
    ("loop_p95_ms", 500.0, 500.1, "loop"),
    ("car_answers", True, False, "car"),
]
BACK_EDGES = [
    ("healthy", True, False, "healthy"),
    ("doubt", Doubt.CAUTION, Doubt.REQUEST, "reason"),
    ("clear_s", 3.0, 2.9, "clear"),
    ("state_matched", True, False, "automation drives"),
    ("drivable_s", 10.0, 9.9, "drivable"),
]


def test_a_ready_operator_is_granted():
    assert refuse_take(READY, LIMITS) == ""


@pytest.mark.parametrize(("field", "good", "bad", "word"), TAKE_EDGES)
def test_each_rule_of_a_take_over_refuses_alone_and_says_which(field, good, bad, word):
    assert refuse_take(replace(READY, **{field: good}), LIMITS) == ""
    assert word in refuse_take(replace(READY, **{field: bad}), LIMITS)


def test_the_operator_may_take_only_a_car_that_nobody_else_must_keep():
    granted = {mode for mode in Mode if not refuse_take(replace(READY, mode=mode), LIMITS)}
    assert granted == {Mode.STANDBY, Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.STOPPED}


def test_from_another_operator_the_car_is_taken_over_only_while_he_drives_and_by_the_same_rules():
    succeeding = replace(READY, succeeding=True)
    assert {mode for mode in Mode if not refuse_take(replace(succeeding, mode=mode), LIMITS)} == {Mode.REMOTE}
    for field, _, bad, word in TAKE_EDGES:
        assert word in refuse_take(replace(succeeding, mode=Mode.REMOTE, **{field: bad}), LIMITS)


def test_returning_within_the_guard_needs_no_aligned_wheel_but_everything_else():
    returning = replace(READY, returning=True)
    assert refuse_take(replace(returning, wheel_error_rad=0.3), LIMITS) == ""
    for field, _, bad, word in TAKE_EDGES:
        if field != "wheel_error_rad":
            assert word in refuse_take(replace(returning, **{field: bad}), LIMITS)


def test_an_offer_of_the_automation_is_granted():
    assert refuse_hand_back(Mode.REMOTE, OFFERED, True, LIMITS) == ""


@pytest.mark.parametrize(("field", "good", "bad", "word"), BACK_EDGES)
def test_each_rule_of_a_hand_back_refuses_alone_and_says_which(field, good, bad, word):
    assert refuse_hand_back(Mode.REMOTE, replace(OFFERED, **{field: good}), True, LIMITS) == ""
    assert word in refuse_hand_back(Mode.REMOTE, replace(OFFERED, **{field: bad}), True, LIMITS)


def test_a_hand_back_needs_an_automation_that_answers_and_an_operator_who_drives():
    assert refuse_hand_back(Mode.REMOTE, None, True, LIMITS) != ""
    assert refuse_hand_back(Mode.REMOTE, OFFERED, False, LIMITS) != ""
    assert {mode for mode in Mode if not refuse_hand_back(mode, OFFERED, True, LIMITS)} == {Mode.REMOTE}
