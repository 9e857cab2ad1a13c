"""The rules of the failsafe through whole cycles, at their limits: not before, and in the first cycle after."""

import pytest
from msgspec.structs import replace

from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import AHEAD_NS, CAR, MS, REAR, M, autonomous, camera_status, lag, remote, stopped
from wire.messages.session import Action, Outcome

LIMIT_AND_JUST_AFTER_MS = 0.001  # a microsecond


def silent_for(drive, ms):
    """Cycles of 10 ms and a last one, until the last command is exactly so old."""
    drive.ann.silent = True
    while (left_ms := ms - (drive.now - drive.state.command_ns) / MS) > 1e-9:
        drive.tick(min(left_ms, 10.0))
    return drive


def test_at_120_ms_of_silence_nothing_happens_and_in_the_next_cycle_the_car_brakes_gently():
    drive = remote()
    asked = drive.out.requested
    silent_for(drive, 120.0)
    assert (drive.mode, drive.told().failsafe, drive.out.requested) == (M.REMOTE, "", asked)
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert (drive.mode, drive.told().failsafe) == (M.REMOTE, "command_silent")
    assert drive.out.applied.acceleration_m_s2 == -1.5


def test_gentle_braking_holds_the_steering_and_ends_with_the_next_command():
    drive = remote()
    drive.ann.steer = 0.02
    drive.run(0.5)
    angle = drive.angle
    silent_for(drive, 400.0)
    assert drive.out.applied.road_wheel_angle_rad == angle
    drive.ann.silent = False
    drive.tick()
    assert (drive.mode, drive.told().failsafe) == (M.REMOTE, "")
    assert drive.out.applied.acceleration_m_s2 > -1.5


def test_at_500_ms_of_silence_the_car_brakes_gently_and_in_the_next_cycle_it_is_a_safe_stop():
    drive = silent_for(remote(), 500.0)
    assert drive.mode is M.REMOTE
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert drive.mode is M.SAFE_STOP
    assert drive.out.applied.hazard


def test_a_command_499_ms_late_drives_on_and_one_501_ms_late_does_not():
    for late_ms, mode in ((499.0, M.REMOTE), (501.0, M.SAFE_STOP)):
        drive = silent_for(remote(), late_ms)
        drive.ann.silent = False
        drive.run(0.1)
        assert drive.mode is mode


def test_a_required_camera_with_no_new_picture_for_200_ms_is_a_safe_stop_in_the_next_cycle():
    drive = remote()
    drive.ann.frozen = True
    advanced_ns = drive.state.pictures["front"].advanced_ns
    while drive.state.command_ns - advanced_ns < 200 * MS:
        drive.tick()
    assert drive.state.command_ns - advanced_ns == 200 * MS
    assert drive.mode is M.REMOTE
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert drive.mode is M.SAFE_STOP


def test_silence_hides_no_frozen_picture_the_command_that_ends_it_tells():
    """While nothing comes nothing is known of the screen, and silence is graded; a picture 300 ms old is too old at once."""
    drive = remote()
    drive.ann.frozen = True
    silent_for(drive, 300.0)
    assert (drive.mode, drive.told().failsafe) == (M.REMOTE, "command_silent")
    drive.ann.silent = False
    drive.tick()
    assert (drive.mode, drive.told().failsafe) == (M.SAFE_STOP, "picture_lost")


@pytest.mark.parametrize("freezes", [False, True])
def test_a_command_that_was_long_on_its_way_tells_of_the_screen_when_it_was_sent(freezes):
    drive = remote()
    drive.ann.frozen, drive.ann.sent_ns = True, drive.now + AHEAD_NS + 8 * MS
    silent_for(drive, 300.0)
    drive.ann.silent = False
    drive.tick()
    assert (drive.mode, drive.told().failsafe) == (M.REMOTE, "")
    drive.ann.frozen, drive.ann.sent_ns = freezes, None
    drive.tick()
    assert (drive.mode, drive.told().failsafe) == ((M.SAFE_STOP, "picture_lost") if freezes else (M.REMOTE, ""))


def test_if_the_tower_s_clock_stands_a_frozen_picture_is_noticed_a_command_s_age_later():
    drive = remote()
    drive.ann.frozen, drive.ann.sent_ns = True, drive.now + AHEAD_NS
    advanced_ns = drive.state.pictures["front"].advanced_ns
    while drive.state.command_ns - advanced_ns < (500 + 200) * MS:
        drive.tick()
    assert (drive.mode, drive.state.command_ns - advanced_ns) == (M.REMOTE, (500 + 200) * MS)
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert drive.mode is M.SAFE_STOP


def test_without_a_new_picture_steering_commands_are_ignored_and_braking_is_accepted():
    drive = remote()
    drive.ann.frozen = True
    drive.until(M.SAFE_STOP, 0.4)
    drive.ann.steer, drive.ann.throttle = 0.3, -6.0
    drive.tick()
    assert abs(drive.out.applied.road_wheel_angle_rad) < 0.01
    assert drive.out.applied.acceleration_m_s2 == -6.0


def test_the_automation_s_silence_is_a_safe_stop_in_the_first_cycle_after_200_ms():
    drive = autonomous()
    drive.automation = False
    while (left_ms := 200.0 - (drive.now - drive.state.autonomy_ns) / MS) > 1e-9:
        drive.tick(min(left_ms, 10.0))
    assert drive.mode is M.AUTONOMOUS
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert drive.mode is M.SAFE_STOP


def test_feedback_that_is_missing_is_a_safe_stop_in_the_first_cycle_after_100_ms():
    drive = remote()
    drive.feedback = False
    while (left_ms := 100.0 - (drive.now - drive.state.feedback_ns) / MS) > 1e-9:
        drive.tick(min(left_ms, 10.0))
    assert drive.mode is M.REMOTE
    drive.tick(LIMIT_AND_JUST_AFTER_MS)
    assert drive.mode is M.SAFE_STOP


def test_what_stopped_the_car_is_told_until_it_is_gone():
    """Silent through the stop: the cause stays; back while it still rolls: stays; back and standing: gone."""
    drive = silent_for(remote(), 510.0)
    drive.run(0.2)
    assert drive.told().failsafe == "command_lost"
    drive.ann.silent = False
    drive.run(0.3)
    assert drive.speed > 0.5
    assert drive.told().failsafe == "command_lost"
    stopped(drive)
    assert drive.told().failsafe == ""


def test_an_automation_that_is_lost_stays_the_cause_until_it_is_healthy_and_an_operator_may_take_over_all_the_same():
    drive = autonomous()
    drive.status = autonomy_status(healthy=False, health_note="no plan")
    stopped(drive)
    assert drive.told().failsafe == "autonomy_lost"
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED


def test_a_lost_side_camera_stops_nothing():
    drive = remote(replace(CAR, cameras=(*CAR.cameras, REAR)))
    drive.cameras = False
    for _ in range(40):
        drive.tick(cameras=(camera_status("front", drive.now), camera_status("rear", drive.now, live=False)))
    assert drive.mode is M.REMOTE


@pytest.mark.parametrize(("loop_ms", "expected"), [(200, 8.33), (250, 6.664), (400, 4.165)])
def test_above_200_ms_the_speed_cap_is_v_max_times_200_ms_through_the_loop_age(loop_ms, expected):
    drive = remote().run(20.0)
    drive.ann.loop_ms = 80
    lag(drive, loop_ms - 2)  # a command is 2 ms old when it is taken in
    drive.run(12.0)
    assert drive.out.cap_m_s == pytest.approx(expected, rel=0.02)
