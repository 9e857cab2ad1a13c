"""STOP, the guard after a hand-over, and bounces: stories of one gateway in simulated time."""

import pytest

from tests.vehicle_gateway.one_gateway import Drive, M, autonomous, handed_back, remote, stopped, taken
from wire.messages.session import Action, Outcome


@pytest.mark.parametrize("story", [autonomous, remote])
def test_stop_needs_no_lease_and_is_confirmed_by_its_number(story):
    drive = story()
    drive.press_stop(number=41)
    assert (drive.mode, drive.told().stop_number) == (M.SAFE_STOP, 41)
    stopped(drive)
    assert "STOP" in drive.told().cause


@pytest.mark.parametrize("granted", [False, True], ids=["standby", "handing over from standby"])
def test_a_stop_while_nobody_drives_and_the_car_stands_is_confirmed_latched_and_not_counted(granted):
    """The checklist before the drive asks for it, again and again as operators change."""
    drive = Drive()
    drive.run(0.2)
    for number in range(1, 5):
        if granted and number == 1:
            drive.lease()
            assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED and drive.mode is M.HANDING_OVER
        drive.press_stop(number=number)
        assert (drive.told().stop_number, drive.out.brake_hold) == (number, True)
        drive.run(0.2)
        assert (drive.mode, drive.told().stops_in_ten_minutes) == (M.STOPPED, 0)
        drive.lease()
        assert "STOP" in drive.ask(Action.TAKE).rule
        assert drive.ask(Action.CLEAR).outcome is Outcome.GRANTED
    assert taken(drive).mode is M.REMOTE


@pytest.mark.parametrize(("speed", "heard"), [(0.06, True), (-0.06, True), (0.0, False)], ids=["rolls", "rolls back", "unheard"])
def test_a_stop_counts_when_the_car_rolls_or_nobody_knows(speed, heard):
    drive = Drive(speed=0.0)
    drive.feedback = heard
    drive.tick()
    drive.speed = speed
    assert drive.mode is M.STANDBY
    drive.press_stop()
    assert (drive.mode, drive.told().stops_in_ten_minutes) == (M.SAFE_STOP, 1)


@pytest.mark.parametrize("story", [autonomous, remote])
def test_a_stop_that_takes_a_standing_car_from_its_driver_counts(story):
    drive = story()
    drive.speed = 0.0
    drive.press_stop()
    assert (drive.mode, drive.told().stops_in_ten_minutes) == (M.STOPPED, 1)


def test_a_stopped_car_is_taken_only_after_the_stop_was_cleared_and_with_a_new_epoch():
    drive = remote()
    drive.press_stop()
    stopped(drive)
    epoch = drive.ann.epoch
    drive.ann.throttle = 0.0
    drive.run(0.2)
    refused = drive.ask(Action.TAKE)
    assert refused.outcome is Outcome.REFUSED and "STOP" in refused.rule
    assert drive.ask(Action.CLEAR).outcome is Outcome.GRANTED
    assert drive.mode is M.STOPPED
    taken(drive)
    assert drive.ann.epoch > epoch


def test_stop_cannot_be_cleared_while_the_car_still_moves():
    drive = remote()
    drive.press_stop()
    assert drive.ask(Action.CLEAR).outcome is Outcome.REFUSED
    drive.run(0.5)
    assert drive.ask(Action.CLEAR).outcome is Outcome.REFUSED


def test_a_restarted_tower_s_first_stop_stops_though_an_older_tower_s_had_the_same_number():
    """The car confirms number 1 already: an ignored press would be shown as CONFIRMED."""
    drive = remote()
    drive.press_stop(number=1)
    stopped(drive)
    drive.ask(Action.CLEAR)
    drive.ann.throttle = 0.0
    drive.run(0.2)
    taken(drive)
    drive.ann.throttle = 1.0
    drive.run(2.0)
    drive.press_stop(number=1)
    assert drive.mode is M.SAFE_STOP


def test_three_stops_in_ten_minutes_need_a_supervisor_and_time_heals():
    drive = autonomous()
    for _ in range(3):
        taken(drive)
        drive.ann.throttle = 1.0
        drive.run(1.0)
        drive.ann.silent = True
        stopped(drive)
        drive.ann.silent, drive.ann.throttle = False, 0.0
        drive.run(0.3)
    assert drive.told().stops_in_ten_minutes == 3
    assert "supervisor" in drive.ask(Action.TAKE).rule
    drive.now += 600 * 10**9
    drive.run(1.0)
    assert drive.told().take_refused == ""


def test_a_stop_whose_cause_is_still_there_is_not_left():
    """Somebody pulls at the wheel and nobody is seen in the seat: that stopped the car, and it goes on."""
    drive = remote()
    drive.local["driver_torque_nm"] = 5.0
    stopped(drive)
    drive.ann.throttle = 0.0
    drive.run(0.2)
    assert drive.ask(Action.TAKE).outcome is Outcome.REFUSED


def test_one_press_within_the_guard_returns_control_though_the_wheel_is_not_aligned():
    drive = handed_back(remote())
    assert drive.told().guard_remaining_s > 8.0
    drive.ann.steer, drive.ann.throttle = 0.1, 0.0
    drive.run(0.1)
    assert drive.ask(Action.RETURN).outcome is Outcome.GRANTED
    drive.until(M.REMOTE, 0.3)


def test_after_the_guard_a_return_is_refused():
    drive = handed_back(remote())
    drive.ann.throttle = 0.0
    drive.run(10.0)
    assert drive.told().guard_remaining_s == 0.0
    assert drive.ask(Action.RETURN).outcome is Outcome.REFUSED


def test_two_bounces_stop_the_car_and_it_can_be_released_or_says_why_not():
    drive = handed_back(remote())
    drive.ann.throttle = 0.0
    drive.run(0.1)
    assert drive.ask(Action.RETURN).outcome is Outcome.GRANTED
    drive.until(M.REMOTE, 0.3)
    handed_back(drive)
    drive.ask(Action.RETURN)
    drive.until(M.SAFE_STOP, 0.5)
    assert "hands" in drive.told().cause
    stopped(drive).run(1.0)
    reply = drive.ask(Action.TAKE)
    if reply.outcome is Outcome.GRANTED:
        drive.run(1.0)
        assert drive.mode is M.REMOTE, "granted, and stopped again for what is long over"
    else:
        assert "supervisor" in reply.rule or "hands" in reply.rule


def test_a_new_request_right_after_a_hand_back_is_a_bounce():
    drive = handed_back(remote())
    drive.request_takeover().until(M.TAKEOVER_REQUESTED)
    drive.ann.throttle = 0.0
    drive.run(0.2)
    taken(drive)
    handed_back(drive)
    drive.request_takeover()
    drive.until(M.SAFE_STOP, 0.5)
