from random import Random

from hypothesis import given
from hypothesis import strategies as st

from tower.cockpit.clock_sync import ClockSync, exchanged
from wire.messages.operating import ClockPong

OFFSET_NS = -3_600_000_000_123
MS = 1_000_000


def exchange(state: ClockSync, sent_ns: int, up_ns: int, held_ns: int, down_ns: int) -> ClockSync:
    arrived_at_car = sent_ns + up_ns + OFFSET_NS
    pong = ClockPong(number=1, ping_sent_ns=sent_ns, received_ns=arrived_at_car, sent_ns=arrived_at_car + held_ns)
    return exchanged(state, pong, sent_ns + up_ns + held_ns + down_ns)


def test_on_a_path_without_asymmetry_the_offset_is_exact_and_the_round_trip_without_the_cars_own_time() -> None:
    state = exchange(ClockSync(), 10**13, 20 * MS, 7 * MS, 20 * MS)
    assert (state.offset_ns, state.bound_ns, state.round_trip_ms) == (OFFSET_NS, 20 * MS, 40.0)


@given(ways=st.lists(st.tuples(st.integers(0, 10**9), st.integers(0, 10**8), st.integers(0, 10**9)), min_size=1, max_size=60))
def test_the_true_offset_is_always_within_the_bound(ways: list[tuple[int, int, int]]) -> None:
    state = ClockSync()
    for number, (up, held, down) in enumerate(ways):
        state = exchange(state, 10**13 + number * 200 * MS, up, held, down)
        assert abs(state.offset_ns - OFFSET_NS) <= state.bound_ns + 1


def test_with_queues_on_a_20_ms_path_the_error_stays_below_a_millisecond() -> None:
    random, state, errors = Random(1), ClockSync(), []
    for number in range(300):
        up, down = (20 * MS + round(random.expovariate(1 / (3 * MS))) for _ in range(2))
        state = exchange(state, 10**13 + number * 200 * MS, up, 50_000, down)
        if number > 50:
            errors.append(abs(state.offset_ns - OFFSET_NS))
    assert sorted(errors)[int(0.95 * len(errors))] < MS


def test_what_is_older_than_ten_seconds_is_forgotten() -> None:
    state = exchange(ClockSync(), 10**13, MS, 0, MS)
    state = exchange(state, 10**13 + 11_000 * MS, 30 * MS, 0, 30 * MS)
    assert state.bound_ns == 30 * MS and len(state.exchanges) == 1


def test_a_pong_that_contradicts_itself_changes_nothing() -> None:
    state = exchange(ClockSync(), 10**13, MS, 0, MS)
    assert exchange(state, 10**13, 0, 5, -10) is state
    assert exchange(state, 10**13, 5, -3, 5) is state


def test_before_the_first_exchange_nothing_is_claimed() -> None:
    assert (ClockSync().offset_ns, ClockSync().bound_ns, ClockSync().round_trip_ms) == (0, 0, 0.0)
