"""The person in the car: stories of one gateway in simulated time."""

import pytest

from tests.vehicle_gateway.one_gateway import Drive, M, autonomous, remote, stopped
from wire.messages.session import Action, Outcome


@pytest.mark.parametrize("story", [autonomous, remote])
@pytest.mark.parametrize("control", [{"driver_torque_nm": 4.0}, {"driver_torque_nm": -4.0}, {"driver_brake": 0.2}])
def test_a_person_in_the_seat_who_steers_or_brakes_for_50_ms_drives(story, control):
    drive = story()
    drive.local |= {"seat_occupied": True} | control
    drive.run(0.05)
    assert drive.mode is not M.LOCAL_DRIVER
    drive.run(0.02)
    assert drive.mode is M.LOCAL_DRIVER
    drive.local |= {"driver_torque_nm": 0.0, "driver_brake": 0.0}
    drive.run(2.0)
    assert drive.mode is M.LOCAL_DRIVER
    assert drive.ask(Action.TAKE).outcome is Outcome.REFUSED


def test_a_touch_shorter_than_50_ms_is_nothing():
    drive = autonomous()
    for _ in range(10):
        drive.local |= {"seat_occupied": True, "driver_torque_nm": 8.0}
        drive.run(0.04)
        drive.local["driver_torque_nm"] = 0.0
        drive.run(0.02)
    assert drive.mode is M.AUTONOMOUS


def test_a_pull_at_the_wheel_with_nobody_seen_in_the_seat_is_a_safe_stop():
    drive = autonomous()
    drive.local["driver_torque_nm"] = 5.0
    drive.run(0.07)
    assert drive.mode is M.SAFE_STOP
    stopped(drive)


def test_the_person_gives_the_car_back_only_with_his_hands_off():
    drive = autonomous()
    drive.local |= {"seat_occupied": True, "driver_torque_nm": 5.0}
    drive.run(0.1)
    drive.local["release_button"] = True
    drive.run(0.1)
    assert drive.modes[-1] is M.LOCAL_DRIVER and M.STANDBY not in drive.modes[1:]
    drive.local["driver_torque_nm"] = 0.0
    drive.run(0.1)
    assert drive.mode is not M.LOCAL_DRIVER


def test_a_moving_car_whose_driver_leaves_the_seat_is_stopped():
    """Driving source lost: SAFE_STOP."""
    drive = autonomous()
    drive.local |= {"seat_occupied": True, "driver_torque_nm": 5.0}
    drive.run(0.1)
    assert drive.mode is M.LOCAL_DRIVER
    drive.local |= {"seat_occupied": False, "driver_torque_nm": 0.0}
    drive.run(2.0)
    assert drive.mode is M.SAFE_STOP


def test_a_seat_sensor_that_flickers_for_less_than_50_ms_does_not_take_the_car_from_the_person_in_it():
    drive = autonomous()
    drive.local |= {"seat_occupied": True, "driver_torque_nm": 5.0}
    drive.run(0.1)
    drive.local |= {"seat_occupied": False, "driver_torque_nm": 0.0}
    drive.run(0.03)
    drive.local |= {"seat_occupied": True}
    drive.run(0.5)
    assert drive.mode is M.LOCAL_DRIVER


def test_the_tower_s_stop_does_not_take_the_car_from_the_person_in_it():
    drive = autonomous()
    drive.local |= {"seat_occupied": True, "driver_torque_nm": 5.0}
    drive.run(0.1)
    drive.press_stop()
    drive.run(0.5)
    assert drive.mode is M.LOCAL_DRIVER


@pytest.mark.parametrize("story", [autonomous, remote, lambda: Drive().run(0.2)])
def test_the_button_in_the_car_latches_until_it_is_out_and_confirmed(story):
    drive = story()
    drive.local["emergency_button"] = True
    drive.tick()
    assert drive.mode is M.EMERGENCY_STOP
    assert drive.out.applied.acceleration_m_s2 <= -4.0 or drive.speed == 0.0
    drive.run(3.0)
    drive.local["emergency_button"] = False
    drive.run(1.0)
    for action in Action:
        assert drive.ask(action).outcome is Outcome.REFUSED
    assert (drive.mode, drive.speed) == (M.EMERGENCY_STOP, 0.0)
    drive.local["release_button"] = True
    drive.run(0.1)
    assert drive.mode is M.STOPPED


def test_the_operator_s_brake_counts_while_the_automation_drives():
    drive = autonomous()
    drive.ann.throttle = -3.0
    drive.run(0.05)
    assert drive.mode is M.AUTONOMOUS
    assert drive.out.applied.acceleration_m_s2 == -3.0
    drive.ann.throttle, drive.ann.silent = 0.0, True
    drive.run(0.2)
    assert drive.out.applied.acceleration_m_s2 > 0.0


def test_an_operator_s_brake_that_is_long_silent_brakes_no_more():
    drive = autonomous()
    drive.ann.throttle = -3.0
    drive.run(0.05)
    drive.ann.silent = True
    drive.run(0.3)
    assert drive.out.applied.acceleration_m_s2 > 0.0
