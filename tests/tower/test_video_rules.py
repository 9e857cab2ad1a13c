"""The rules of the receiver: the stamp, which pictures are whole, when to ask for a new session."""

import struct

from hypothesis import given
from hypothesis import strategies as st

from tower.video.continuity import Continuity, follow
from tower.video.reconnect import Session, Step, asked, delivered, next_step
from wire.stamp import STAMP_UUID, Stamp, read_stamp

MS = 1_000_000


@given(st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 1), st.lists(st.binary(max_size=40), max_size=3))
def test_the_stamp_is_found_among_other_messages(capture_ns: int, sequence: int, others: list[bytes]) -> None:
    ours = STAMP_UUID + struct.pack(">Q", capture_ns) + struct.pack(">I", sequence)
    assert read_stamp([*others, ours]) == Stamp(capture_ns, sequence)


@given(st.lists(st.binary(max_size=60), max_size=4), st.integers(0, 11))
def test_anything_else_is_no_stamp(messages: list[bytes], length: int) -> None:
    cut_off = STAMP_UUID + bytes(length)
    assert read_stamp([*(message for message in messages if not message.startswith(STAMP_UUID)), cut_off]) is None


@given(st.lists(st.tuples(st.integers(1, 3), st.booleans(), st.integers(0, 9)), max_size=60), st.integers(0, 2**32 - 1))
def test_a_picture_is_shown_only_when_nothing_is_missing_since_a_key_picture(
    steps: list[tuple[int, bool, int]], first: int
) -> None:
    state, sequence, chain = Continuity(), first, False
    for step, is_key, luck in steps:
        sequence = (sequence + step) % 2**32
        is_corrupt = luck == 0
        state = follow(state, sequence, is_key, is_corrupt)
        chain = (is_key or (chain and step == 1)) and not is_corrupt
        assert state.whole == chain


def test_the_first_look_asks_at_once() -> None:
    assert next_step(Session(), 5 * MS, None, has_failed=False) is Step.ASK


def test_pictures_keep_a_session_and_1500_ms_of_silence_end_it() -> None:
    session = asked(Session(), 10_000 * MS, answered=True)
    assert next_step(session, 11_499 * MS, None, has_failed=False) is Step.WAIT
    assert next_step(session, 11_501 * MS, None, has_failed=False) is Step.ASK
    assert next_step(session, 11_501 * MS, 11_000 * MS, has_failed=False) is Step.WAIT
    assert next_step(session, 12_501 * MS, 11_000 * MS, has_failed=False) is Step.ASK


def test_a_failed_connection_is_not_waited_for() -> None:
    session = asked(Session(), 10_000 * MS, answered=True)
    assert next_step(session, 10_600 * MS, 10_590 * MS, has_failed=True) is Step.ASK


def test_a_car_that_does_not_answer_is_asked_after_500_1000_2000_2000_ms() -> None:
    session, now_ns, waits = Session(), 0, []
    for _ in range(5):
        session = asked(session, now_ns, answered=False)
        waited = 0
        while next_step(session, now_ns, None, has_failed=False) is Step.WAIT:
            now_ns, waited = now_ns + 50 * MS, waited + 50
        waits.append(waited)
    assert waits == [500, 1000, 2000, 2000, 2000]


def test_after_a_picture_the_next_loss_is_answered_quickly_again() -> None:
    session = asked(asked(asked(Session(), 0, answered=False), 0, answered=False), 0, answered=True)
    assert session.back_off_ns == 2000 * MS
    assert delivered(session).back_off_ns == 500 * MS


@given(st.lists(st.tuples(st.integers(1, 3000), st.booleans(), st.booleans()), max_size=80))
def test_whatever_happens_the_car_is_asked_at_most_twice_a_second_and_again_within_4_s_of_silence(
    steps: list[tuple[int, bool, bool]],
) -> None:
    session, now_ns, picture_ns, asks, quiet_since_ns = Session(), 0, None, [], 0
    for step_ms, answers, pictures in steps:
        now_ns += step_ms * MS
        if next_step(session, now_ns, picture_ns, has_failed=False) is Step.ASK:
            session, quiet_since_ns = asked(session, now_ns, answers), now_ns
            asks.append(now_ns)
        elif pictures and session.open:
            picture_ns = quiet_since_ns = now_ns
            session = delivered(session)
        else:
            assert now_ns - quiet_since_ns <= 4000 * MS
    assert all(late - early >= 500 * MS for early, late in zip(asks, asks[1:], strict=False))
