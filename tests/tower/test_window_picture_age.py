"""FROZEN by an injected clock."""

from hypothesis import given
from hypothesis import strategies as st

from tower.window.picture_age import PictureSeen, PictureState, age_ns, picture_state, see

HOUR_NS = 3_600_000_000_000
MS = 1_000_000


def test_the_same_picture_shown_again_and_again_is_frozen_after_200_ms() -> None:
    seen = None
    states = []
    for tick in range(0, 300, 10):
        seen = see(seen, 5_000 * MS, tick * MS)
        states.append((tick, picture_state(seen, tick * MS, None)))
    assert all(state is PictureState.LIVE for tick, state in states if tick <= 200)
    assert all(state is PictureState.FROZEN for tick, state in states if tick > 200)


def test_a_new_capture_stamp_lifts_it_and_an_older_one_does_not() -> None:
    frozen = PictureSeen(capture_ns=5_000 * MS, new_since_ns=0)
    assert picture_state(see(frozen, 5_033 * MS, 400 * MS), 400 * MS, None) is PictureState.LIVE
    assert picture_state(see(frozen, 4_967 * MS, 400 * MS), 400 * MS, None) is PictureState.FROZEN


def test_a_restarted_car_may_count_from_the_beginning() -> None:
    before = PictureSeen(capture_ns=HOUR_NS, new_since_ns=0)
    assert see(before, 40 * MS, 900 * MS) == PictureSeen(40 * MS, 900 * MS)


@given(st.integers(-2 * HOUR_NS, 2 * HOUR_NS), st.integers(0, 10**10), st.integers(0, 10**10))
def test_no_clock_offset_whatever_lifts_frozen(offset_ns: int, capture_ns: int, later_ns: int) -> None:
    state = picture_state(PictureSeen(capture_ns, 0), later_ns, offset_ns)
    assert (state is PictureState.FROZEN) == (later_ns > 200 * MS)


def test_a_moving_picture_of_long_ago_is_late_not_frozen() -> None:
    offset_ns = -HOUR_NS
    now_ns = 2 * HOUR_NS
    seen = PictureSeen(capture_ns=now_ns + offset_ns - 620 * MS, new_since_ns=now_ns - 10 * MS)
    assert picture_state(seen, now_ns, offset_ns) is PictureState.LATE
    assert age_ns(seen, now_ns, offset_ns) == 620 * MS


@given(st.integers(0, 10**12), st.integers(0, 10**12), st.integers(-HOUR_NS, HOUR_NS) | st.none())
def test_the_age_is_never_less_than_the_time_since_arrival(capture_ns: int, later_ns: int, offset_ns: int | None) -> None:
    age = age_ns(PictureSeen(capture_ns, 0), later_ns, offset_ns)
    assert age is not None
    assert age >= later_ns


def test_before_the_first_picture_there_is_no_age() -> None:
    assert see(None, None, 1) is None
    assert age_ns(None, 1, 0) is None
    assert picture_state(None, 1, 0) is PictureState.NONE
