"""The table of who drives, against the rules of the architecture written a second time, plainly."""

from itertools import product

from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.authority import TABLE, Authority, Event, Source, brakes_held, driving_source, next_authority
from wire.messages.vehicle import Mode

M, E = Mode, Event
MAY_TAKE_FROM = (M.STANDBY, M.AUTONOMOUS, M.TAKEOVER_REQUESTED, M.STOPPED)
STATES = [Authority(mode=mode, origin=mode) for mode in M if mode is not M.HANDING_OVER] + [
    Authority(mode=M.HANDING_OVER, origin=origin) for origin in MAY_TAKE_FROM
]
STOPS = (E.LOCAL_UNCLEAR, E.FAULT, E.TOWER_STOP)
DRIVER = {
    M.AUTONOMOUS: E.AUTONOMY_LOST,
    M.TAKEOVER_REQUESTED: E.AUTONOMY_LOST,
    M.REMOTE: E.OPERATOR_LOST,
    M.HANDING_BACK: E.OPERATOR_LOST,
}  # mode -> the loss of who drives in it
ASKED = {
    (M.STANDBY, E.ENGAGED): M.AUTONOMOUS,
    (M.AUTONOMOUS, E.TAKEOVER_NEEDED): M.TAKEOVER_REQUESTED,
    (M.TAKEOVER_REQUESTED, E.TAKEOVER_WITHDRAWN): M.AUTONOMOUS,
    (M.TAKEOVER_REQUESTED, E.BUDGET_OVER): M.SAFE_STOP,
    (M.HANDING_OVER, E.TAKE_COMMITTED): M.REMOTE,
    (M.REMOTE, E.HAND_BACK_GRANTED): M.HANDING_BACK,
    (M.HANDING_BACK, E.HAND_BACK_COMMITTED): M.AUTONOMOUS,
    (M.HANDING_BACK, E.HAND_BACK_LAPSED): M.REMOTE,
    (M.HANDING_BACK, E.AUTONOMY_LOST): M.REMOTE,
}


def expected(now: Authority, event: Event) -> Mode:
    """The rules in the order of their precedence."""
    mode = now.mode
    loss = DRIVER.get(now.origin if mode is M.HANDING_OVER else mode)
    rules = (
        (event is E.EMERGENCY_BUTTON, M.EMERGENCY_STOP),
        (mode is M.EMERGENCY_STOP, M.STOPPED if event is E.EMERGENCY_RELEASED else mode),
        (event is E.LOCAL_OVERRIDE, M.LOCAL_DRIVER),
        (mode is M.LOCAL_DRIVER and event is E.LOCAL_UNCLEAR, M.SAFE_STOP),  # nobody in the seat: who drives is lost
        (mode is M.LOCAL_DRIVER, M.STANDBY if event is E.LOCAL_RELEASED else mode),
        (mode is M.SAFE_STOP, M.STOPPED if event is E.STANDSTILL else mode),
        (event in STOPS, mode if mode is M.STOPPED else M.SAFE_STOP),
        (event is loss, M.SAFE_STOP),
        (mode is M.HANDING_OVER and event in (E.TAKE_LAPSED, E.OPERATOR_LOST), now.origin),
        (event is E.TAKE_GRANTED and mode in MAY_TAKE_FROM, M.HANDING_OVER),
    )
    return next((then for applies, then in rules if applies), ASKED.get((mode, event), mode))


def test_the_table_fills_every_pair_of_mode_and_event():
    assert {(event, mode) for event, row in TABLE.items() for mode in row} == set(product(Event, Mode))


def test_every_entry_follows_the_rules_of_the_architecture():
    for now, event in product(STATES, Event):
        assert (now, event, next_authority(now, event).mode) == (now, event, expected(now, event))


def test_losing_who_drives_is_a_safe_stop_in_every_mode():
    losses = {Source.AUTONOMY: E.AUTONOMY_LOST, Source.OPERATOR: E.OPERATOR_LOST}
    for now in STATES:
        if driving_source(now) in losses:
            assert next_authority(now, losses[driving_source(now)]).mode is M.SAFE_STOP


def test_losing_who_receives_lets_the_driver_drive_on():
    for origin in MAY_TAKE_FROM:
        before = Authority(mode=origin, origin=origin)
        assert next_authority(Authority(mode=M.HANDING_OVER, origin=origin), E.OPERATOR_LOST) == before
    assert next_authority(Authority(mode=M.HANDING_BACK, origin=M.HANDING_BACK), E.AUTONOMY_LOST).mode is M.REMOTE


def test_losing_somebody_who_neither_drives_nor_receives_changes_nothing():
    for mode in (M.STANDBY, M.AUTONOMOUS, M.TAKEOVER_REQUESTED, M.STOPPED, M.LOCAL_DRIVER, M.SAFE_STOP):
        now = Authority(mode=mode, origin=mode)
        assert next_authority(now, E.OPERATOR_LOST) == now
    for mode in (M.STANDBY, M.REMOTE, M.STOPPED, M.LOCAL_DRIVER, M.SAFE_STOP):
        now = Authority(mode=mode, origin=mode)
        assert next_authority(now, E.AUTONOMY_LOST) == now


def test_a_safe_stop_ends_only_in_stopped_local_driver_or_emergency_stop():
    now = Authority(mode=M.SAFE_STOP, origin=M.SAFE_STOP)
    ends = {next_authority(now, event).mode for event in Event} - {M.SAFE_STOP}
    assert ends == {M.STOPPED, M.LOCAL_DRIVER, M.EMERGENCY_STOP}


def test_only_the_button_in_the_car_latches_and_only_its_release_unlatches():
    into = {
        event
        for now, event in product(STATES, Event)
        if now.mode is not M.EMERGENCY_STOP and next_authority(now, event).mode is M.EMERGENCY_STOP
    }
    latched = Authority(mode=M.EMERGENCY_STOP, origin=M.EMERGENCY_STOP)
    out = {event for event in Event if next_authority(latched, event) != latched}
    assert (into, out) == ({E.EMERGENCY_BUTTON}, {E.EMERGENCY_RELEASED})


def test_the_operator_gets_to_drive_only_through_a_committed_hand_over():
    into = {
        (now.mode, event)
        for now, event in product(STATES, Event)
        if driving_source(now) is not Source.OPERATOR and driving_source(next_authority(now, event)) is Source.OPERATOR
    }
    assert into == {(M.HANDING_OVER, E.TAKE_COMMITTED)}


def test_the_automation_gets_to_drive_only_by_engaging_or_a_committed_hand_back():
    into = {
        event
        for now, event in product(STATES, Event)
        if driving_source(now) is not Source.AUTONOMY and driving_source(next_authority(now, event)) is Source.AUTONOMY
    }
    assert into == {E.ENGAGED, E.HAND_BACK_COMMITTED}


def test_a_stopped_car_is_left_only_for_the_operator_the_person_in_it_or_the_button():
    now = Authority(mode=M.STOPPED, origin=M.STOPPED)
    assert {next_authority(now, event).mode for event in Event} == {M.STOPPED, M.HANDING_OVER, M.LOCAL_DRIVER, M.EMERGENCY_STOP}


def test_brakes_are_held_when_nobody_drives_and_after_every_stop():
    held = {(now.mode, now.origin) for now in STATES if brakes_held(now)}
    assert held == {
        (M.STANDBY,) * 2,
        (M.STOPPED,) * 2,
        (M.EMERGENCY_STOP,) * 2,
        (M.HANDING_OVER, M.STANDBY),
        (M.HANDING_OVER, M.STOPPED),
    }


def test_the_order_of_the_events_is_the_order_of_precedence():
    groups = (
        [E.EMERGENCY_BUTTON],
        [E.LOCAL_OVERRIDE],
        [E.LOCAL_UNCLEAR, E.FAULT, E.TOWER_STOP, E.OPERATOR_LOST, E.AUTONOMY_LOST, E.BUDGET_OVER],
        [E.TAKE_COMMITTED, E.HAND_BACK_COMMITTED, E.TAKE_GRANTED, E.HAND_BACK_GRANTED],
        [E.TAKEOVER_NEEDED, E.TAKEOVER_WITHDRAWN, E.ENGAGED],
    )
    place = {event: position for position, event in enumerate(Event)}
    for stronger, weaker in zip(groups, groups[1:], strict=False):
        assert max(place[event] for event in stronger) < min(place[event] for event in weaker)


@given(st.sampled_from(STATES), st.lists(st.sampled_from(list(Event)), max_size=40))
def test_no_sequence_of_events_leaves_the_known_states(now: Authority, events: list[Event]):
    for event in events:
        now = next_authority(now, event)
        assert now in STATES


@given(st.sampled_from(STATES), st.lists(st.sampled_from(list(Event)), max_size=40))
def test_after_any_loss_of_the_driver_nobody_drives_off_before_standstill(now: Authority, events: list[Event]):
    now = next_authority(now, E.FAULT)
    for event in events:
        if now.mode is not M.SAFE_STOP:
            break
        now = next_authority(now, event)
        assert now.mode in (M.SAFE_STOP, M.STOPPED, M.LOCAL_DRIVER, M.EMERGENCY_STOP)
        assert now.mode is not M.STOPPED or event is E.STANDSTILL
