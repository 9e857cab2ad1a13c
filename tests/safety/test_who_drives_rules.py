"""Precedence when several things happen in one cycle, exhaustively; and the person in the car, at the limits of his rules."""

from itertools import combinations, permutations

import pytest
from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import LIMITS, M, autonomous, remote, stopped
from tests.vehicle_gateway.test_authority import MAY_TAKE_FROM, STATES
from vehicle_gateway.authority import Authority, Event, Source, driving_source, next_authority
from vehicle_gateway.cycle import decide
from vehicle_gateway.failsafe import Cause
from vehicle_gateway.state import initial_state

E = Event
STOPS = {E.LOCAL_UNCLEAR, E.FAULT, E.TOWER_STOP}
STARTS = {E.TAKE_COMMITTED, E.TAKE_GRANTED, E.HAND_BACK_COMMITTED, E.ENGAGED}
LOSSES = {Source.AUTONOMY: E.AUTONOMY_LOST, Source.OPERATOR: E.OPERATOR_LOST}


def together(now: Authority, events) -> Authority:
    """One cycle with all of them: from the strongest to the weakest, each from where the one before led."""
    for event in Event:
        if event in events:
            now = next_authority(now, event)
    return now


def test_the_cycle_takes_events_in_the_order_of_precedence_in_whatever_order_they_come():
    state = replace(initial_state("boot", 10**12, 1, False), causes=tuple(Cause))  # each loss has its words
    for now in STATES:
        at = replace(state, authority=now)
        for pair in combinations(Event, 2):
            expected = together(now, pair)
            for events in permutations(pair):
                assert decide(at, events, 10**12, LIMITS)[0].authority == expected
    for triple in combinations((E.EMERGENCY_BUTTON, E.LOCAL_OVERRIDE, E.TOWER_STOP, E.TAKE_COMMITTED, E.TAKEOVER_NEEDED), 3):
        for now, events in ((now, events) for now in STATES for events in permutations(triple)):
            assert decide(replace(state, authority=now), events, 10**12, LIMITS)[0].authority == together(now, triple)


@pytest.mark.parametrize("most", [2, 3])
def test_the_emergency_button_wins_over_everything_that_comes_with_it(most):
    others = [event for event in Event if event not in {E.EMERGENCY_BUTTON, E.EMERGENCY_RELEASED}]
    for now in STATES:
        for with_it in combinations(others, most - 1):
            assert together(now, {E.EMERGENCY_BUTTON, *with_it}).mode is M.EMERGENCY_STOP


def test_a_person_who_takes_the_car_wins_over_every_stop_and_everybody_who_asks():
    weaker = [event for event in Event if event not in {E.EMERGENCY_BUTTON, E.LOCAL_OVERRIDE, E.LOCAL_UNCLEAR, E.LOCAL_RELEASED}]
    for now in STATES:
        for with_it in combinations(weaker, 2):
            then = together(now, {E.LOCAL_OVERRIDE, *with_it}).mode
            latched = now.mode is M.EMERGENCY_STOP and E.EMERGENCY_RELEASED not in with_it
            assert then is (M.EMERGENCY_STOP if latched else then)
            assert then in (M.LOCAL_DRIVER, M.EMERGENCY_STOP, M.STOPPED, M.HANDING_OVER)
            assert (then is M.LOCAL_DRIVER) == (now.mode is not M.EMERGENCY_STOP)


def test_a_safe_stop_wins_over_operator_and_automation_whatever_they_ask_in_the_same_cycle():
    """Even standing at once, nobody drives in the cycle of a stop: a granted hand-over waits with the brakes held."""
    for now in STATES:
        for stop in STOPS | {LOSSES.get(driving_source(now), E.FAULT)}:
            for with_it in combinations([*STARTS, E.STANDSTILL, E.TAKEOVER_NEEDED, E.TAKEOVER_WITHDRAWN], 2):
                then = together(now, {stop, *with_it})
                drives = driving_source(then)
                assert drives in (Source.GATEWAY, Source.NOBODY) or (now.mode is M.LOCAL_DRIVER and drives is Source.LOCAL)


def test_the_operator_wins_over_the_automation_when_both_ask_in_one_cycle():
    for origin in MAY_TAKE_FROM:
        now = Authority(mode=origin, origin=origin)
        for asked in (E.TAKEOVER_NEEDED, E.TAKEOVER_WITHDRAWN, E.ENGAGED):
            assert together(now, {E.TAKE_GRANTED, asked}).mode is M.HANDING_OVER
    handing = Authority(mode=M.HANDING_OVER, origin=M.AUTONOMOUS)
    assert together(handing, {E.TAKE_COMMITTED, E.TAKEOVER_WITHDRAWN}).mode is M.REMOTE


def test_a_commit_that_comes_with_its_lapse_counts_and_one_that_comes_with_a_lost_operator_does_not():
    handing = Authority(mode=M.HANDING_OVER, origin=M.AUTONOMOUS)
    assert together(handing, {E.TAKE_COMMITTED, E.TAKE_LAPSED}).mode is M.REMOTE
    assert together(handing, {E.TAKE_COMMITTED, E.OPERATOR_LOST}).mode is M.AUTONOMOUS
    back = Authority(mode=M.HANDING_BACK, origin=M.HANDING_BACK)
    assert together(back, {E.HAND_BACK_COMMITTED, E.AUTONOMY_LOST}).mode is M.REMOTE


# -- the person in the car ------------------------------------------------------------------------------------------------

TORQUE, BRAKE = {"driver_torque_nm": 3.1}, {"driver_brake": 0.11}


def touched_for(drive, ms, controls, seat=True):
    drive.local |= controls | {"seat_occupied": seat}
    drive.tick()
    since_ns = drive.now
    while (left_ms := ms - (drive.now - since_ns) / 1e6) > 1e-9:
        drive.tick(min(left_ms, 10.0))
    return drive


@pytest.mark.parametrize("controls", [TORQUE, BRAKE], ids=["torque", "brake"])
@pytest.mark.parametrize("story", [autonomous, remote])
def test_seat_and_torque_or_brake_for_50_ms_is_a_driver_and_a_microsecond_less_is_not(story, controls):
    assert touched_for(story(), 49.999, controls).mode is story().mode
    assert touched_for(story(), 50.0, controls).mode is M.LOCAL_DRIVER


@pytest.mark.parametrize("controls", [TORQUE, BRAKE], ids=["torque", "brake"])
@pytest.mark.parametrize("story", [autonomous, remote])
def test_otherwise_torque_or_brake_for_50_ms_is_a_safe_stop(story, controls):
    assert touched_for(story(), 49.999, controls, seat=False).mode is story().mode
    assert touched_for(story(), 50.0, controls, seat=False).mode is M.SAFE_STOP


@pytest.mark.parametrize("controls", [{"driver_torque_nm": 3.0}, {"driver_brake": 0.1}, {"driver_torque_nm": -3.0}])
def test_what_the_road_does_to_wheel_and_pedal_is_no_touch_however_long(controls):
    assert touched_for(remote(), 500.0, controls).mode is M.REMOTE


def test_a_pull_to_the_right_is_a_pull():
    assert touched_for(remote(), 50.0, {"driver_torque_nm": -3.1}).mode is M.LOCAL_DRIVER


def test_a_seat_alone_drives_nothing():
    assert touched_for(remote(), 500.0, {}).mode is M.REMOTE


def test_a_touch_that_pauses_begins_anew():
    drive = touched_for(remote(), 40.0, BRAKE)
    drive.local |= {"driver_brake": 0.0}
    drive.tick()
    assert touched_for(drive, 40.0, BRAKE).mode is M.REMOTE


@pytest.mark.parametrize("controls", [TORQUE, BRAKE], ids=["torque", "brake"])
def test_a_person_in_the_seat_takes_a_stopping_car_and_a_stopped_one(controls):
    stopping = remote()
    stopping.press_stop()
    assert touched_for(stopping, 50.0, controls).mode is M.LOCAL_DRIVER
    standing = remote()
    standing.press_stop()
    assert touched_for(stopped(standing), 50.0, controls).mode is M.LOCAL_DRIVER


def test_nobody_s_command_drives_against_a_person_in_the_car():
    """While he drives the gateway asks for nothing: steering gives way, no traction; an operator's brake still adds."""
    drive = touched_for(remote(), 60.0, BRAKE)
    drive.ann.throttle, drive.ann.steer = 2.0, 0.3
    drive.run(0.2)
    assert drive.mode is M.LOCAL_DRIVER
    assert drive.out.requested.acceleration_m_s2 == 0.0
    assert drive.out.applied.road_wheel_angle_rad == pytest.approx(drive.angle)
    drive.ann.throttle = -3.0
    drive.run(0.1)
    assert drive.out.applied.acceleration_m_s2 == -3.0
