from dataclasses import replace

import msgspec
from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import Phase
from tests.messages import gateway_status
from tower.cockpit.hand_over import HandOverInputs, HandOverState, answered, is_driving, step, wheel_wanted
from wire.messages.automation import Reason, TakeoverRequest
from wire.messages.session import Action, HandOverReply, Outcome
from wire.messages.vehicle import GatewayStatus, HandOver, Mode, Succession

S = 1_000_000_000
CARS = 7  # the car's own number of what it grants
STATUS = gateway_status(lease_holder="o", lease_epoch=3)
REQUEST = TakeoverRequest(number=1, raised_ns=0, reasons=(Reason(channel="map", text="closed"),), budget_s=15.0, place=(0.0, 0.0))
READY = HandOverInputs(
    pressed=frozenset(), phase=Phase.READY, dead_man=True, lease_epoch=3, status=STATUS, asker_busy=False, operator="o"
)


def press(button: str, inputs: HandOverInputs = READY) -> HandOverInputs:
    return replace(inputs, pressed=frozenset({button}))


def reply(number: int, outcome: Outcome = Outcome.GRANTED, rule: str = "") -> HandOverReply:
    granted = outcome is Outcome.GRANTED
    return HandOverReply(number=number, outcome=outcome, rule=rule, lease_epoch=4, hand_over=CARS if granted else 0)


def told(state: str, rule: str = "", number: int = 0) -> GatewayStatus:
    """What the car says of a hand-over, by default of the one it granted us."""
    return with_status(hand_over=HandOver(number=number or CARS, action="take", state=state, rule=rule))


def with_status(**changes: object) -> GatewayStatus:
    return msgspec.structs.replace(STATUS, **changes)


def test_one_press_asks_once_when_the_wheel_is_ready_and_the_dead_man_held() -> None:
    state, asked = step(HandOverState(), press("accept"), 0)
    assert asked is not None and (asked.action, asked.number, asked.lease_epoch) == (Action.TAKE, 1, 3)
    assert step(state, READY, S)[1] is None
    assert step(answered(state, reply(1), S), READY, S)[1] is None


def test_a_take_waits_for_the_wheel_and_the_dead_man_and_says_for_which() -> None:
    turning = replace(READY, phase=Phase.ALIGN)
    state, asked = step(HandOverState(), press("accept", turning), 0)
    assert asked is None and state.note == "take: the wheel is turning to the car's angle"
    state, asked = step(state, replace(READY, dead_man=False), S)
    assert asked is None and state.note == "take: hold the dead-man control"
    assert step(state, READY, 2 * S)[1] is not None


def test_a_wish_is_given_up_after_its_patience() -> None:
    state, _ = step(HandOverState(), press("accept", replace(READY, dead_man=False)), 0)
    state, _ = step(state, replace(READY, dead_man=False), 16 * S)
    assert state.wish is None and "given up" in state.note
    assert step(state, READY, 17 * S)[1] is None


def test_hand_back_engage_and_clear_need_no_wheel() -> None:
    for button, action in (("hand_back", Action.HAND_BACK), ("engage", Action.ENGAGE), ("clear", Action.CLEAR)):
        _, asked = step(HandOverState(), press(button, replace(READY, phase=Phase.IDLE, dead_man=False)), 0)
        assert asked is not None and asked.action is action


def test_one_press_returns_control_in_the_guard_time_whatever_the_wheel_does() -> None:
    _, asked = step(HandOverState(), press("return_", replace(READY, phase=Phase.ALIGN)), 0)
    assert asked is not None and asked.action is Action.RETURN


def test_without_a_lease_nothing_is_asked() -> None:
    state, asked = step(HandOverState(), press("engage", replace(READY, lease_epoch=0)), 0)
    assert asked is None and state.note == "engage: no lease"


def test_a_refusal_shows_the_rule_and_silence_says_no_answer() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    assert answered(state, reply(1, Outcome.REFUSED, "too fast"), S).note == "take refused: too fast"
    assert answered(state, None, S).note == "take: no answer"
    assert answered(state, reply(7), S).note == "take: no answer"  # the answer to another question


def test_a_grant_makes_the_wheel_ours_until_the_car_confirms_or_a_second_has_passed() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    state = answered(state, reply(1), 0)
    assert is_driving(state, STATUS, "o", S // 2) and not is_driving(state, STATUS, "o", S)
    assert is_driving(state, with_status(mode=Mode.REMOTE), "o", 2 * S)
    assert not is_driving(state, with_status(mode=Mode.REMOTE, lease_holder="p"), "o", 2 * S)


def test_an_expired_grant_gives_the_wheel_back_at_once_and_is_told() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    state = answered(state, reply(1), 0)
    expired = told("expired", "no command in 300 ms")
    state, _ = step(state, replace(READY, status=expired), S // 4)
    assert not is_driving(state, expired, "o", S // 4)
    assert state.note == "take expired: no command in 300 ms"


def test_a_grant_of_the_past_does_not_end_the_next_one() -> None:
    old = replace(READY, status=told("expired", number=CARS - 1))
    state, _ = step(HandOverState(), old, 0)
    state, _ = step(state, press("accept", old), S)
    state, _ = step(answered(state, reply(1), S), old, S + 1)
    assert is_driving(state, old.status, "o", S + 2)


def test_a_question_is_kept_with_its_number_and_what_becomes_of_it() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    assert (state.question.number, state.question.action, state.question.state) == (1, "take", "requested")
    granted = answered(state, reply(1), 0)
    assert (granted.question.state, granted.question.hand_over) == ("granted", CARS)
    for how in ("committed", "expired", "aborted"):
        ended, _ = step(granted, replace(READY, status=told(how, "why")), S // 4)
        assert (ended.question.state, ended.question.rule, ended.question.number) == (how, "why", 1)
    again, asked = step(ended, press("accept"), S)
    assert asked is not None and (again.question.number, again.question.state) == (asked.number, "requested") == (2, "requested")


def test_a_refused_question_keeps_its_rule_and_one_without_an_answer_has_expired() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    refused, lost = answered(state, reply(1, Outcome.REFUSED, "too fast"), S).question, answered(state, None, S).question
    assert (refused.state, refused.rule) == ("refused", "too fast")
    assert (lost.state, lost.rule) == ("expired", "no answer")


def test_what_the_car_says_of_another_hand_over_does_not_end_ours() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    state, _ = step(answered(state, reply(1), 0), replace(READY, status=told("committed", number=CARS + 1)), S // 4)
    assert state.question.state == "granted"


def test_engage_and_clear_are_done_with_the_grant() -> None:
    for button in ("engage", "clear"):
        state, _ = step(HandOverState(), press(button), 0)
        assert answered(state, reply(1), 0).question.state == "committed"


def test_a_car_that_started_anew_has_forgotten_what_it_granted() -> None:
    state, _ = step(HandOverState(), press("accept"), 0)
    state, _ = step(answered(state, reply(1), 0), replace(READY, status=with_status(boot_id="another")), S // 4)
    assert state.question.state == "aborted" and "started anew" in state.note
    assert not is_driving(state, STATUS, "o", S // 4)


def test_a_press_while_driving_asks_for_nothing() -> None:
    assert step(HandOverState(), press("accept", replace(READY, status=with_status(mode=Mode.REMOTE))), 0)[1] is None


def test_the_wheel_turns_to_the_car_for_a_request_a_wish_a_held_dead_man_or_within_the_guard_time() -> None:
    rest = HandOverState()
    assert not wheel_wanted(rest, STATUS, "o", False)
    assert wheel_wanted(rest, STATUS, "o", True)
    assert wheel_wanted(rest, with_status(request=REQUEST), "o", False)
    assert wheel_wanted(rest, with_status(guard_remaining_s=5.0), "o", False)
    assert wheel_wanted(HandOverState(wish=Action.TAKE), STATUS, "o", False)
    for mode in (Mode.REMOTE, Mode.SAFE_STOP, Mode.EMERGENCY_STOP, Mode.LOCAL_DRIVER):
        assert not wheel_wanted(rest, with_status(request=REQUEST, mode=mode), "o", True)


BUTTONS = st.sampled_from(["accept", "hand_back", "return_", "engage", "clear"])


MOMENTS = st.tuples(
    st.frozensets(BUTTONS, max_size=2),
    st.sampled_from(list(Phase)),
    st.booleans(),
    st.integers(0, 3),
    st.sampled_from(list(Mode)),
    st.booleans(),
    st.sampled_from(["grant", "refuse", "silence", "wait"]),
    st.integers(1, 3000),
)


@given(history=st.lists(MOMENTS, max_size=50))
def test_the_wheel_is_asked_for_only_when_ready_and_held_one_question_at_a_time_each_press_once(
    history: list[tuple[frozenset[str], Phase, bool, int, Mode, bool, str, int]],
) -> None:
    state, now, in_flight, numbers, presses = HandOverState(), 0, False, [0], 0
    for pressed, phase, dead_man, epoch, mode, busy, answer, later_ms in history:
        now += later_ms * 1_000_000
        presses += len(pressed)
        seen = HandOverInputs(
            pressed=pressed,
            phase=phase,
            dead_man=dead_man,
            lease_epoch=epoch,
            status=with_status(mode=mode),
            asker_busy=busy or in_flight,
            operator="o",
        )
        state, asked = step(state, seen, now)
        if asked is not None:
            assert not in_flight and not busy and epoch > 0 and asked.number > numbers[-1]
            assert asked.action not in (Action.TAKE, Action.RETURN) or dead_man
            assert asked.action is not Action.TAKE or phase is Phase.READY
            numbers.append(asked.number)
            in_flight = True
        if in_flight and answer != "wait":
            in_flight = False
            replies = {"grant": reply(numbers[-1]), "refuse": reply(numbers[-1], Outcome.REFUSED, "no"), "silence": None}
            state = answered(state, replies[answer], now)
    assert len(numbers) - 1 <= presses


NAMED = Succession(operator="n", lease_epoch=8, agreed=False, refused="", remaining_s=50.0)
DRIVING = with_status(mode=Mode.REMOTE, succession=NAMED)
NEXT = replace(READY, status=DRIVING, operator="n", lease_epoch=8)


def test_whoever_drives_and_accepts_that_another_is_named_passes_the_car_on() -> None:
    driver = replace(READY, status=DRIVING)
    state, asked = step(HandOverState(), press("accept", driver), 0)
    assert asked is not None and asked.action is Action.PASS_ON and not wheel_wanted(state, DRIVING, "o", False)
    state = answered(state, reply(1), S)
    assert (state.question.state, state.note, state.commit_until_ns) == ("committed", "pass on: granted", 0)
    for other in (replace(driver, guard_holds=True), replace(driver, status=with_status(mode=Mode.REMOTE))):
        assert step(HandOverState(), press("accept", other), 0)[1] is None, "then it is the guard that he means, or nothing"


def test_the_next_operator_s_wheel_follows_the_car_s_and_he_asks_when_the_car_would_grant_it() -> None:
    assert wheel_wanted(HandOverState(), DRIVING, "n", True) and not wheel_wanted(HandOverState(), DRIVING, "x", True)
    waiting = replace(NEXT, status=with_status(mode=Mode.REMOTE, succession=msgspec.structs.replace(NAMED, refused="not yet")))
    state, asked = step(HandOverState(), press("accept", waiting), 0)
    assert asked is None and state.note == "take: not yet"
    state, asked = step(state, NEXT, S)
    assert asked is not None and (asked.action, asked.lease_epoch) == (Action.TAKE, 8)
    assert not is_driving(state, DRIVING, "n", S)
    state = answered(state, reply(1), S)
    assert is_driving(state, DRIVING, "n", S + 1), "the other one's driving says nothing against ours"
    assert is_driving(step(state, NEXT, S + 1)[0], DRIVING, "n", S + 2)
    assert is_driving(HandOverState(), with_status(mode=Mode.REMOTE, lease_holder="n"), "n", 0)
    assert not is_driving(HandOverState(), with_status(mode=Mode.REMOTE, lease_holder="n"), "o", 0)


def test_of_a_car_that_another_one_drives_only_the_next_operator_s_press_is_kept() -> None:
    """Whoever is not named asks, and the car refuses him: the rule is its own."""
    stranger = replace(READY, status=DRIVING, operator="x")
    assert step(HandOverState(), press("accept", stranger), 0)[0].question.action == "take"
