from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from haptics.alignment import Phase
from tower.cockpit.behaviour import TAKES_MAX, Behaviour, Doing, Situation, step
from wire.messages.vehicle import Mode

S = 1_000_000_000
CALM = Situation(
    mode=Mode.AUTONOMOUS,
    request_open=False,
    hand_back_ready=False,
    home=True,
    picture_live=True,
    picture_steady=True,
    phase=Phase.IDLE,
    reaction_ns=2 * S,
)
ASKED = replace(CALM, mode=Mode.TAKEOVER_REQUESTED, request_open=True, home=False)


def run(state: Behaviour, seen: Situation, from_s: float, to_s: float) -> Behaviour:
    for tick in range(round(from_s * 25), round(to_s * 25)):
        state = step(state, seen, tick * S // 25)
    return state


def test_it_reaches_for_the_wheel_one_reaction_after_the_request_and_presses_once_a_second_when_aligned() -> None:
    state = run(Behaviour(), CALM, 0, 10)
    assert state.engaged and not state.grips
    state = run(state, ASKED, 10, 11.9)
    assert state.doing is Doing.REACT and not state.grips
    state = run(state, ASKED, 11.9, 13)
    assert state.grips and state.presses.accept == 0
    state = run(state, replace(ASKED, phase=Phase.READY), 13, 15.9)
    assert state.presses.accept == 3
    assert run(state, replace(ASKED, phase=Phase.ACTIVE), 15.9, 16).doing is Doing.DRIVE


def test_it_engages_the_car_from_standby_until_it_drives_and_never_again() -> None:
    standby = replace(CALM, mode=Mode.STANDBY)
    state = run(Behaviour(), standby, 1, 3.9)
    assert state.presses.engage == 3
    state = run(run(state, CALM, 4, 5), standby, 5, 20)
    assert state.presses.engage == 3


def test_a_request_that_goes_away_by_itself_is_nobodys() -> None:
    state = run(run(Behaviour(), CALM, 0, 5), ASKED, 5, 6)
    assert run(state, CALM, 6, 7).doing is Doing.WATCH
    state = run(run(run(Behaviour(), CALM, 0, 5), ASKED, 5, 8), CALM, 8, 9)
    assert state.doing is Doing.WATCH and not state.grips


def test_it_hands_back_when_the_car_is_ready_and_home_and_drives_until_the_wheel_lets_go() -> None:
    driving = Behaviour(doing=Doing.DRIVE, since_ns=0, requested=True, takes=1)
    at_wheel = replace(CALM, mode=Mode.REMOTE, phase=Phase.ACTIVE)
    assert run(driving, at_wheel, 5, 8).presses.hand_back == 0
    assert run(driving, replace(at_wheel, hand_back_ready=True, home=False), 5, 8).presses.hand_back == 0
    state = run(driving, replace(at_wheel, hand_back_ready=True), 5, 5.5)
    assert state.presses.hand_back == 1 and state.grips
    state = run(state, replace(at_wheel, mode=Mode.HANDING_BACK), 5.5, 7)
    assert state.presses.hand_back == 1 and state.grips
    assert not run(state, replace(CALM, phase=Phase.RELEASE), 7, 7.1).grips


def test_after_a_safe_stop_it_takes_again_from_stopped_at_most_twice() -> None:
    state, now = run(Behaviour(), CALM, 0, 5), 5.0
    for _ in range(6):
        state = run(state, replace(ASKED, mode=Mode.STOPPED), now, now + 5)
        state = run(state, replace(ASKED, mode=Mode.STOPPED, phase=Phase.ACTIVE), now + 5, now + 6)
        state = run(state, replace(ASKED, mode=Mode.SAFE_STOP), now + 6, now + 9)
        now += 10
    assert state.takes == TAKES_MAX == 3


def test_a_car_stranded_in_the_middle_of_its_drive_is_taken_over_and_one_that_never_drove_is_left_alone() -> None:
    stopped = replace(CALM, mode=Mode.STOPPED)
    assert run(run(Behaviour(), CALM, 0, 5), stopped, 5, 10).doing is Doing.TAKE
    assert run(Behaviour(), stopped, 0, 30).doing is Doing.WATCH


def test_a_car_that_stands_is_taken_only_with_a_steady_picture_one_that_drives_with_a_live_one() -> None:
    stutters, taking = replace(ASKED, phase=Phase.READY, picture_steady=False), Behaviour(doing=Doing.TAKE)
    assert run(taking, replace(stutters, mode=Mode.STOPPED), 5, 10).presses.accept == 0
    assert run(taking, stutters, 5, 10).presses.accept > 0


def test_without_a_moving_picture_it_presses_nothing_and_takes_nothing() -> None:
    dark = replace(ASKED, picture_live=False)
    assert run(run(Behaviour(), CALM, 0, 5), dark, 5, 30).doing is Doing.WATCH
    aligned = replace(dark, phase=Phase.READY)
    assert run(Behaviour(doing=Doing.TAKE), aligned, 5, 10).presses.accept == 0


@given(
    history=st.lists(
        st.tuples(
            st.sampled_from([None, *Mode]),
            st.booleans(),
            st.booleans(),
            st.booleans(),
            st.booleans(),
            st.sampled_from(list(Phase)),
            st.integers(1, 100),
        ),
        max_size=60,
    )
)
def test_it_never_presses_stop_clear_or_return_and_holds_the_dead_man_only_to_take_or_drive(
    history: list[tuple[Mode | None, bool, bool, bool, bool, Phase, int]],
) -> None:
    state, now = Behaviour(), 0
    for mode, asked, ready, home, live, phase, ticks in history:
        now += ticks * S // 25
        seen = Situation(
            mode=mode,
            request_open=asked,
            hand_back_ready=ready,
            home=home,
            picture_live=live,
            picture_steady=live,
            phase=phase,
            reaction_ns=2 * S,
        )
        before, state = state, step(state, seen, now)
        assert (state.presses.stop, state.presses.clear, state.presses.return_) == (0, 0, 0)
        assert state.grips == (state.doing in (Doing.TAKE, Doing.DRIVE))
        if not before.grips and state.grips:
            assert before.doing is Doing.REACT and now - before.since_ns >= 2 * S
        if before.doing is Doing.DRIVE and phase is not Phase.ACTIVE:
            assert not state.grips


def test_a_keen_one_takes_a_car_that_drives_itself_and_keeps_it():
    keen = replace(CALM, keen=True)
    state = run(run(Behaviour(), keen, 1, 5), replace(keen, phase=Phase.READY), 5, 6)
    assert state.presses.accept == 1 and state.presses.engage == 0
    driving = replace(keen, mode=Mode.REMOTE, phase=Phase.ACTIVE, hand_back_ready=True)
    assert run(run(state, replace(driving, mode=Mode.AUTONOMOUS), 6, 7), driving, 7, 20).presses.hand_back == 0


def test_a_keen_one_takes_a_stopped_car_again_as_often_as_it_stops():
    stopped = replace(CALM, mode=Mode.STOPPED, keen=True)
    assert run(Behaviour(takes=TAKES_MAX), stopped, 1, 5).grips


NAMED = replace(CALM, mode=Mode.REMOTE, another_drives=True, is_next=True)


def test_named_as_the_next_operator_it_takes_over_from_the_one_who_drives() -> None:
    state = run(run(Behaviour(), replace(NAMED, is_next=False), 0, 5), NAMED, 5, 8)
    assert state.doing is Doing.TAKE and state.grips
    state = run(state, replace(NAMED, phase=Phase.READY), 8, 9.9)
    assert state.presses.accept == 2
    assert run(state, replace(NAMED, phase=Phase.ACTIVE), 9.9, 10).doing is Doing.DRIVE


def test_when_it_is_the_next_one_no_longer_it_lets_go_and_looks_on() -> None:
    state = run(Behaviour(), NAMED, 5, 8)
    assert not run(state, replace(NAMED, is_next=False), 8, 9).grips


def test_it_passes_the_car_on_while_it_drives_and_asks_again_when_that_came_to_nothing() -> None:
    driving = Behaviour(doing=Doing.DRIVE, since_ns=0, takes=1)
    at_wheel = replace(CALM, mode=Mode.REMOTE, phase=Phase.ACTIVE, passes_on=True, hand_back_ready=True)
    state = run(driving, at_wheel, 5, 7.9)
    assert (state.presses.accept, state.presses.hand_back, state.grips) == (3, 0, True)
    agreed = run(state, replace(at_wheel, passes_on=False, hand_back_ready=False), 8, 9)
    assert agreed.grips and run(agreed, replace(at_wheel, phase=Phase.IDLE, another_drives=True), 9, 9.1).doing is Doing.WATCH
