"""Who gives way, in which order, and that nobody does without a reason."""

from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.load import (
    ALONE,
    DOWN_AFTER_S,
    LADDER,
    START_S,
    UP_AFTER_MAX_S,
    UP_AFTER_S,
    UP_AFTER_START_S,
    ControlLoops,
    Load,
    after_a_second,
    allowance,
    hear,
    is_late,
    others_may_give,
)
from wire.messages.health import LoopHealth


def health(cycles: int, late: int, process: str = "vehicle-gateway run") -> LoopHealth:
    return LoopHealth(
        stamp_ns=1,
        process=process,
        loop="cycle",
        period_ms=10.0,
        cycles=cycles,
        late_cycles=late,
        lateness_p50_ms=0.1,
        lateness_max_ms=1.0,
        scheduling="other",
        dropped={},
    )


def test_the_sides_have_lost_all_they_can_before_the_front_loses_anything() -> None:
    load, rates = Load(), []
    for _ in range(20):
        load = after_a_second(load, pressed=True)
        (side, side_halved), (front, front_halved) = allowance(15.0, False, load), allowance(30.0, True, load)
        assert not side_halved
        assert front_halved == (side == 2.5 and front < 30.0 and (side, 20.0) in rates)  # rate, then size, then both
        rates.append((side, front))
    assert front_halved
    assert rates[:2] == [(15.0, 30.0), (10.0, 30.0)]  # one bad second is none
    assert all(side <= 5.0 for side, front in rates if front < 30.0)
    assert rates[2][0] < rates[1][0]  # and then a step for each bad second
    assert (5.0, 20.0) in rates and rates[-1] == (2.5, 15.0)  # the car allows 200 ms between pictures: room for one lost one


@given(st.lists(st.booleans(), max_size=200))
def test_the_level_moves_by_single_steps_and_comes_back_after_calm(seconds: list[bool]) -> None:
    load = Load()
    for pressed in seconds:
        before, load = load, after_a_second(load, pressed)
        assert 0 <= load.level < len(LADDER)
        assert load.level - before.level in ((0, 1) if pressed else (0, -1))
    for _ in range(UP_AFTER_MAX_S + UP_AFTER_S * len(LADDER)):
        load = after_a_second(load, pressed=False)
    assert load.level == 0


def test_a_car_with_one_camera_gives_up_something_with_every_step() -> None:
    assert ALONE[0] == LADDER[0] and ALONE[-1] == LADDER[-1]
    allowed = [allowance(30.0, True, Load(level=level), ALONE) for level in range(len(ALONE))]
    assert allowed == [(30.0, False), (20.0, False), (20.0, True), (15.0, True)]
    load = Load()
    for _ in range(20):
        load = after_a_second(load, True, ALONE)
    assert load.level == len(ALONE) - 1


def seconds_between_tries(load: Load, tries: int, enough_at: int) -> list[int]:
    """On a machine that keeps up at a level and below, and not above."""
    begun, found = 0, []
    for second in range(1000):
        before, load = load, after_a_second(load, pressed=load.level < enough_at)
        if load.level < before.level:
            found.append(second - begun)
            begun = second
    return found[:tries]


def test_a_step_back_that_was_too_much_is_tried_again_after_twice_as_long() -> None:
    assert seconds_between_tries(Load(level=3, runs_s=START_S), 7, enough_at=3)[1:] == [
        8 + DOWN_AFTER_S,
        16 + DOWN_AFTER_S,
        32 + DOWN_AFTER_S,
        *[64 + DOWN_AFTER_S] * 3,
    ]


def test_what_was_given_to_programs_that_start_is_taken_back_soon_until_a_step_is_too_much() -> None:
    load = Load()
    for second in range(START_S - 1):  # too much, with a good moment in between
        load = after_a_second(load, pressed=second % 6 < 4)
    assert load.level > 1
    lowest, calm = load.level, 0
    while load.level > 0:
        load, calm = after_a_second(load, pressed=False), calm + 1
    assert calm <= UP_AFTER_START_S * lowest
    assert seconds_between_tries(load, 2, enough_at=1)[1] >= UP_AFTER_S


def test_a_step_back_that_held_is_followed_by_the_next_as_soon_as_ever() -> None:
    load = Load(level=3, patience_s=UP_AFTER_MAX_S)
    times = []
    for second in range(1, 200):
        before, load = load, after_a_second(load, pressed=False)
        times += [second] * (load.level < before.level)
    assert times == [UP_AFTER_MAX_S, UP_AFTER_MAX_S + UP_AFTER_S, UP_AFTER_MAX_S + 2 * UP_AFTER_S]


def test_the_ladder_never_gives_the_front_less_than_the_sides_and_only_goes_down() -> None:
    assert LADDER[0] == (1.0, 1.0, False)
    assert all(rung.others <= rung.required for rung in LADDER)
    assert all(a[0] >= b[0] and a[1] >= b[1] for a, b in zip(LADDER, LADDER[1:], strict=False))


def test_late_side_pictures_count_as_long_as_the_sides_alone_pay_for_it() -> None:
    may = [level for level in range(len(LADDER)) if others_may_give(Load(level=level))]
    assert may == [0, 1, 2, 4]
    assert all(LADDER[level + 1].required == LADDER[level].required for level in may)
    assert not any(others_may_give(Load(level=level), ALONE) for level in range(len(ALONE)))


def test_a_fifth_of_the_pictures_late_or_lost_is_too_much() -> None:
    assert not is_late(30, 6, 0)
    assert is_late(30, 7, 0)
    assert is_late(20, 0, 10)
    assert not is_late(0, 0, 0)


def test_a_control_loop_that_misses_deadlines_is_heard_and_one_that_always_did_is_not() -> None:
    state = hear(ControlLoops(), health(1000, 50))  # before we listened
    assert not state.were_late
    assert not hear(state, health(1100, 51)).were_late  # one in a hundred happens
    assert hear(state, health(1100, 55)).were_late
    assert not hear(state, health(1100, 55, "recordings record")).were_late
    assert not hear(state, health(10, 0)).were_late  # started again
