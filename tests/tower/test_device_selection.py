from hypothesis import given
from hypothesis import strategies as st

from tower.cockpit.selection import SCRIPTED, WINDOW, Held, Offer, chosen, held_back

WHEEL = Offer(key="wheel 1", is_wheel=True)
KEYS = Offer(key=WINDOW, is_wheel=False)


def test_touching_a_device_selects_it():
    assert chosen(WINDOW, (WHEEL,), holds=False, driving=False) == "wheel 1"
    assert chosen("wheel 1", (KEYS,), holds=False, driving=True) == WINDOW


def test_a_held_dead_man_keeps_the_controls_but_not_for_the_scripted_operator():
    assert chosen("wheel 1", (KEYS,), holds=True, driving=True) == "wheel 1"
    assert chosen(SCRIPTED, (KEYS,), holds=True, driving=True) == WINDOW


def test_a_wheel_that_stands_elsewhere_does_not_take_the_controls_while_somebody_drives():
    assert chosen(SCRIPTED, (WHEEL,), holds=True, driving=True) == SCRIPTED
    assert chosen(SCRIPTED, (WHEEL, KEYS), holds=True, driving=True) == WINDOW
    assert chosen(SCRIPTED, (WHEEL,), holds=True, driving=False) == "wheel 1"


def test_lost_controls_come_back_only_armed_anew_and_when_nobody_drives():
    lost = held_back(Held(), "Logitech G920 unplugged", driving=True, armed=True)
    assert (lost.back, lost.note) == (True, "Logitech G920 unplugged")
    assert held_back(lost, "", driving=True, armed=True).back
    assert held_back(lost, "", driving=False, armed=False).back
    assert not held_back(lost, "", driving=False, armed=True).back


@given(st.lists(st.tuples(st.sampled_from(["", "", "", "gone"]), st.booleans(), st.booleans())))
def test_between_a_loss_and_the_next_use_the_car_was_always_given_up(moments: list[tuple[str, bool, bool]]):
    state, owed = Held(), False  # owed: lost, and since then there was no moment armed without driving
    for loss, driving, armed in moments:
        state = held_back(state, loss, driving=driving, armed=armed)
        owed = True if loss else owed and (driving or not armed)
        assert state.back == owed
