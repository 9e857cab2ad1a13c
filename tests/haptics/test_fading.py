"""Forces come in slowly and go at once, whatever was between."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.fading import FADE_NS, SILENCE_NS, Hearing, heard, rendered
from haptics.force_feedback import Abilities, Effects

CAN = Abilities(constant=True, spring=True, damper=True)
STRONG = Effects(spring=0.5, spring_max=0.4, centre=0.1, damper=0.2, constant=-0.3)
MS = 1_000_000


def test_forces_come_in_over_a_second_and_the_damper_at_once():
    state = heard(Hearing(), STRONG, 5 * FADE_NS)
    assert rendered(state, 5 * FADE_NS, CAN) == Effects(spring=0.5, spring_max=0.0, centre=0.1, damper=0.2, constant=0.0)
    for ms in range(50, 1050, 50):
        state = heard(state, STRONG, 5 * FADE_NS + ms * MS)
    half = rendered(heard(heard(Hearing(), STRONG, 0), STRONG, 250 * MS), 500 * MS, CAN)
    assert (half.spring_max, half.constant) == (pytest.approx(0.2), pytest.approx(-0.15))
    assert rendered(state, 6 * FADE_NS, CAN) == STRONG


def test_silence_takes_them_at_once_and_they_begin_from_nothing_again():
    state = heard(heard(Hearing(), STRONG, 0), STRONG, 200 * MS)
    late_ns = 200 * MS + SILENCE_NS + 1
    gone = rendered(state, late_ns, CAN)
    assert (gone.spring_max, gone.constant) == (0.0, 0.0)
    assert rendered(heard(state, STRONG, late_ns), late_ns, CAN).constant == 0.0


@given(st.lists(st.tuples(st.integers(0, 700), st.booleans()), max_size=60))
def test_no_force_grows_faster_than_all_of_it_in_a_second(moments: list[tuple[int, bool]]):
    """moments: ms since the last one, and whether a packet came then."""
    state, now_ns, last = Hearing(), 0, 0.0
    for wait_ms, comes in moments:
        now_ns += wait_ms * MS
        state = heard(state, STRONG, now_ns) if comes else state
        force = rendered(state, now_ns, CAN).spring_max
        assert force <= last + STRONG.spring_max * wait_ms / 1000 + 1e-9
        last = force
