"""A process that ends is started again, each time a little later."""

from tower.devices.revival import PAUSES_S, WELL_NS, Revival, looked, words

S = 1_000_000_000


def ends_at_once(state: Revival, now_ns: int) -> tuple[Revival, int]:
    """It has just ended; (state, how long until it is started again, in whole seconds)."""
    state, start = looked(state, True, now_ns)
    assert not start
    for second in range(100):
        state, start = looked(state, True, now_ns + second * S)
        if start:
            return state, second
        assert words(state, now_ns + second * S).endswith(f"started again in {state.again_ns // S - now_ns // S - second} s")
    raise AssertionError("it was never started again")


def test_the_pause_grows_to_half_a_minute_and_stays_there():
    state, now_ns, pauses = Revival(started_ns=0), 10 * S, []
    for _ in range(8):
        state, pause_s = ends_at_once(state, now_ns)
        pauses.append(pause_s)
        now_ns = state.started_ns
    assert pauses == [*PAUSES_S, 30, 30] == [1, 2, 4, 8, 16, 30, 30, 30]
    assert words(state, now_ns) == ""


def test_one_that_ran_well_is_started_again_after_the_shortest_pause():
    state = Revival(started_ns=0, ends=5)
    assert ends_at_once(state, WELL_NS)[1] == 1
    assert ends_at_once(state, WELL_NS - S)[1] == 30


def test_how_often_it_ended_is_said():
    assert words(Revival(started_ns=0, ends=1, again_ns=3 * S), 2 * S + 1) == "its forces have ended, started again in 1 s"
    assert words(Revival(started_ns=0, ends=3, again_ns=5 * S), S) == "its forces have ended (3 times), started again in 4 s"
