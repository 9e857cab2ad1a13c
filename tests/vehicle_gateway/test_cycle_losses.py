"""The operator, the link or the automation is lost: stories of one gateway in simulated time."""

import pytest
from msgspec.structs import replace

from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import CAR, MS, Drive, M, autonomous, lag, remote, stopped, taken
from vehicle_gateway.lease import refuse_command
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.session import Action, Outcome


def test_130_ms_without_a_command_brakes_gently_and_the_next_command_drives_on():
    drive = remote()
    drive.ann.silent = True
    drive.run(0.15)
    assert drive.mode is M.REMOTE
    assert drive.out.applied.acceleration_m_s2 == -1.5
    assert drive.told().failsafe == "command_silent"
    drive.ann.silent = False
    drive.run(0.5)
    assert (drive.mode, drive.told().failsafe) == (M.REMOTE, "")
    assert drive.out.applied.acceleration_m_s2 > 0.0


def test_110_ms_without_a_command_change_nothing():
    drive = remote()
    before = drive.out.requested
    drive.ann.silent = True
    drive.run(0.10)
    assert (drive.out.requested, drive.told().failsafe) == (before, "")


def test_600_ms_without_a_command_end_at_standstill_with_hazard_lights_and_the_brakes_held():
    drive = remote()
    speed, x = drive.speed, drive.pose[0]
    drive.ann.silent = True
    drive.run(0.6)
    assert drive.mode is M.SAFE_STOP
    assert drive.out.applied.hazard
    stopped(drive)
    assert drive.speed == 0.0
    assert drive.out.brake_hold
    assert drive.pose[0] - x <= stopping_distance_m(speed, 0.5, 2.5, 5.0)
    assert drive.told().stops_in_ten_minutes == 1


def test_a_returning_operator_does_not_get_the_safe_stop_back():
    drive = remote()
    drive.ann.silent = True
    drive.until(M.SAFE_STOP, 1.0)
    drive.ann.silent = False
    stopped(drive)
    assert drive.modes[-2:] == [M.SAFE_STOP, M.STOPPED]


def test_a_released_dead_man_takes_traction_and_steering_at_once_and_the_car_in_half_a_second():
    drive = remote()
    angle = drive.angle
    drive.ann.dead_man, drive.ann.throttle, drive.ann.steer = False, 2.0, 0.3
    drive.tick()
    assert drive.out.applied.acceleration_m_s2 <= 0.0
    drive.run(0.4)
    assert drive.mode is M.REMOTE
    assert drive.angle == angle
    drive.run(0.15)
    assert drive.mode is M.SAFE_STOP
    assert drive.angle == pytest.approx(angle, abs=0.01)


def test_a_frozen_picture_ends_the_drive_though_commands_go_on():
    drive = remote()
    drive.ann.frozen = True
    drive.run(0.19)
    assert drive.mode is M.REMOTE
    angle = drive.angle
    drive.ann.steer, drive.ann.throttle = 0.3, -3.5
    drive.run(0.05)
    assert drive.mode is M.SAFE_STOP
    assert drive.told().failsafe != "" or "picture" in drive.told().cause
    drive.run(0.1)
    assert abs(drive.angle - angle) < 0.05, "steering without a picture was followed"
    assert drive.out.applied.acceleration_m_s2 <= -3.5, "braking without a picture was not followed"


def test_one_of_two_required_cameras_that_freezes_is_enough():
    two = replace(CAR, cameras=(CAR.cameras[0], replace(CAR.cameras[0], name="left")))
    drive = remote(vehicle=two)
    seen = dict(drive.ann.seen)
    drive.ann.frozen = True
    for _ in range(25):
        drive.ann.seen = {"front": drive.now, "left": seen["left"]}
        drive.tick()
    assert drive.mode is M.SAFE_STOP


def test_pictures_that_only_come_again_are_no_new_pictures():
    """Two old ones in turn: each is another than the one before, and neither is newer than both."""
    drive = remote()
    drive.ann.frozen = True
    newest = drive.ann.seen["front"]
    for cycle in range(25):
        drive.ann.seen = {"front": newest - (cycle % 2) * 50 * MS}
        drive.tick()
    assert drive.mode is M.SAFE_STOP


def test_pictures_with_stamps_of_the_future_are_no_new_pictures():
    """The stamps are the car's own clock: one that is still to come was never given out by a camera."""
    drive = remote()
    drive.ann.loop_ms = -3_600_000
    drive.run(0.3)
    assert drive.mode is M.SAFE_STOP


def test_a_loop_of_600_ms_lasting_a_second_ends_the_drive():
    drive = remote()
    lag(drive, 600)
    assert drive.mode is M.REMOTE
    drive.run(0.7)
    assert drive.mode is M.REMOTE
    drive.until(M.SAFE_STOP, 2.0)
    assert "slow" in drive.told().cause
    stopped(drive)


def test_a_loop_of_400_ms_halves_the_speed_and_drives_on():
    drive = remote().run(6.0)
    drive.ann.throttle = 2.0
    lag(drive, 400)
    drive.run(25.0)
    assert drive.mode is M.REMOTE
    assert drive.speed == pytest.approx(8.33 * 0.2 / 0.4, abs=0.1)


def test_an_echo_older_than_its_limit_is_as_good_as_silence():
    drive = remote()
    command = drive.ann.command(drive.now, "boot", 0.0)
    old = replace(command, echoed_vehicle_ns=drive.now - 501 * MS)
    assert refuse_command(old, replace(drive.guard, epoch=drive.state.lease.epoch), True, drive.now) == "command echo age"


def test_the_cap_is_15_km_h_for_ten_seconds_and_then_rises_slowly():
    drive = Drive().run(0.3)
    drive.lease()
    drive.run(0.3)
    taken(drive)
    drive.ann.throttle = 2.0
    fastest = 0.0
    for _ in range(990):
        drive.tick()
        fastest = max(fastest, drive.speed)
    assert 3.0 < fastest <= 15 / 3.6 + 0.02
    drive.run(15.0)
    assert drive.speed == pytest.approx(8.33, abs=0.1)


@pytest.mark.parametrize("loss", ["silent", "unhealthy", "status silent"])
def test_an_automation_that_is_lost_while_it_drives_ends_at_standstill(loss):
    drive = autonomous()
    speed, x = drive.speed, drive.pose[0]
    if loss == "silent":
        drive.automation = False
    elif loss == "unhealthy":
        drive.status = autonomy_status(healthy=False, health_note="no localization")
    else:
        drive.ticks = 0
        drive.status = autonomy_status()
        for _ in range(60):
            drive.tick(autonomy_status=None)
    drive.until(M.SAFE_STOP, 0.6)
    stopped(drive)
    assert drive.pose[0] - x <= stopping_distance_m(speed, 0.6, 2.5, 5.0)


def test_losing_the_automation_while_the_operator_drives_changes_nothing():
    drive = remote()
    drive.automation = False
    drive.run(3.0)
    assert drive.mode is M.REMOTE


def test_an_automation_lost_while_control_comes_back_to_it_leaves_the_operator_driving():
    drive = remote()
    drive.auto_steer = 0.2  # does not fit: the hand-back waits
    assert drive.ask(Action.HAND_BACK).outcome is Outcome.GRANTED
    drive.run(0.3)
    assert drive.mode is M.HANDING_BACK
    drive.automation = False
    drive.run(0.3)
    assert drive.mode is M.REMOTE
    assert drive.told().hand_over.state == "aborted"


def test_a_hand_back_that_does_not_fit_lapses_and_the_operator_drives_on():
    drive = remote()
    drive.auto_steer = 0.2
    drive.ask(Action.HAND_BACK)
    drive.run(2.2)
    assert (drive.mode, drive.told().hand_over.state) == (M.REMOTE, "expired")


def test_losing_the_operator_while_he_hands_back_is_a_safe_stop():
    drive = remote()
    drive.auto_steer = 0.2
    drive.ask(Action.HAND_BACK)
    drive.ann.silent = True
    drive.run(0.6)
    assert drive.modes[-1] in (M.SAFE_STOP, M.STOPPED)
    assert M.AUTONOMOUS not in drive.modes[drive.modes.index(M.HANDING_BACK) :]


def test_the_automation_s_braking_counts_while_it_receives():
    drive = remote()
    drive.auto_steer, drive.auto_acceleration = 0.2, -2.2
    drive.ask(Action.HAND_BACK)
    drive.run(0.05)
    assert drive.mode is M.HANDING_BACK
    assert drive.out.applied.acceleration_m_s2 == -2.2


def test_nobody_takes_over_until_the_budget_is_over_and_the_car_stands():
    drive = autonomous()
    drive.request_takeover(budget_s=4.0)
    drive.cruise = 0.0
    drive.until(M.SAFE_STOP, 4.2)
    assert "in time" in drive.told().cause
    stopped(drive)
    assert drive.told().stops_in_ten_minutes == 0, "a planned standstill is no stop that needs a supervisor"


def test_a_withdrawn_request_lets_the_automation_drive_on():
    drive = autonomous()
    drive.request_takeover().until(M.TAKEOVER_REQUESTED)
    drive.withdraw().until(M.AUTONOMOUS, 0.2)
