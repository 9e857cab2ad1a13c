from hypothesis import given
from hypothesis import strategies as st

from tower.cockpit.stop_button import StopButton, cleared, pressed, step

MS = 1_000_000


def test_stop_is_sent_at_once_repeated_every_200_ms_with_its_number_and_unconfirmed_after_half_a_second() -> None:
    state, sent_ms, told = pressed(StopButton(), 4, 0), [], {}
    for tick in range(200):
        now_ms = tick * 4
        state, send = step(state, 4, now_ms * MS)
        told[now_ms] = state.state
        if send:
            sent_ms.append(now_ms)
    assert state.number == 5
    assert sent_ms[0] == 0 and all(200 <= b - a <= 204 for a, b in zip(sent_ms, sent_ms[1:], strict=False))
    assert told[496] == "sent" and told[504] == "unconfirmed"


def test_the_cars_answer_confirms_and_ends_the_repetition_but_not_the_silence() -> None:
    state, _ = step(pressed(StopButton(), 0, 0), 0, MS)
    state, send = step(state, 1, 50 * MS)
    assert (state.state, send, state.stream_ended) == ("confirmed", False, True)
    assert not cleared(state).stream_ended and cleared(state).state == ""


def test_a_late_answer_still_confirms() -> None:
    state, _ = step(pressed(StopButton(), 0, 0), 0, 900 * MS)
    assert state.state == "unconfirmed"
    assert step(state, 1, 1000 * MS)[0].state == "confirmed"


def test_a_restarted_cockpit_is_not_confirmed_by_the_stops_of_its_predecessor() -> None:
    state, send = step(pressed(StopButton(), None, 0), None, 0)
    assert send and state.number == 1
    state, send = step(state, 9, 100 * MS)  # the car had counted nine before
    assert send and state.number == 10 and state.state == "sent"
    assert step(state, 10, 150 * MS)[0].state == "confirmed"


def test_pressing_again_is_a_new_stop() -> None:
    state, _ = step(pressed(StopButton(), 0, 0), 1, MS)
    again = pressed(state, 1, 2 * MS)
    assert (again.number, again.state) == (2, "sent") and step(again, 1, 2 * MS)[1]


MOMENTS = st.tuples(st.sampled_from(["press", "wait", "clear"]), st.integers(0, 3), st.integers(1, 400))


@given(history=st.lists(MOMENTS, max_size=60))
def test_confirmed_is_said_only_when_the_car_has_counted_this_number_and_the_stream_is_off_from_press_to_clear(
    history: list[tuple[str, int, int]],
) -> None:
    state, now, car, off = StopButton(), 0, 0, False
    for what, hears, later_ms in history:
        now += later_ms * MS
        if what == "press":
            state, off = pressed(state, car, now), True
        elif what == "clear":
            state, off = cleared(state), False
        state, send = step(state, car, now)
        if send and hears:  # the car heard it
            car = max(car, state.number)
        assert state.stream_ended == off
        if state.state == "confirmed":
            assert car >= state.number
        assert not send or state.stream_ended


def test_a_stop_that_another_tower_cleared_is_over_when_the_car_is_driven_again_and_not_before_it_was_confirmed() -> None:
    """Somebody looks on, and tries his STOP; the one who drives clears it. He could never be the next one, being mute."""
    sent, _ = step(pressed(StopButton(), 0, 0), 0, MS)
    assert step(sent, 0, 2 * MS, is_driven=True)[0].stream_ended, "the car has not heard of it yet"
    confirmed, _ = step(sent, 1, 50 * MS, is_driven=True)
    assert confirmed.stream_ended and step(confirmed, 1, 60 * MS)[0].stream_ended
    over, send = step(confirmed, 1, 60 * MS, is_driven=True)
    assert (over.state, over.stream_ended, over.number, send) == ("", False, 1, False)
