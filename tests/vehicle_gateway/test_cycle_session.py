"""The whole session of one gateway in simulated time, and reverse."""

import pytest
from msgspec.structs import replace

from tests.vehicle_gateway.one_gateway import CAR, ENGAGING, REAR, Drive, M, autonomous, remote, stopped, taken
from wire.messages.base import Gear, Lights, Wipers
from wire.messages.session import Action, Outcome


def test_the_whole_session_from_standby_to_the_car_driving_itself_again():
    drive = autonomous()
    assert drive.speed > 5.0
    drive.request_takeover().until(M.TAKEOVER_REQUESTED)
    taken(drive)
    drive.ann.throttle = 0.5
    drive.run(3.0)
    assert drive.speed > 2.0
    drive.withdraw().run(0.2)
    assert drive.ask(Action.HAND_BACK).outcome is Outcome.GRANTED
    drive.until(M.AUTONOMOUS, 2.0)
    assert drive.modes == [M.STANDBY, M.AUTONOMOUS, M.TAKEOVER_REQUESTED, M.HANDING_OVER, M.REMOTE, M.HANDING_BACK, M.AUTONOMOUS]
    assert drive.told().hand_over.state == "committed"
    assert drive.told().stops_in_ten_minutes == 0


def test_wipers_go_on_when_the_automation_drives_again_and_its_lights_are_dipped():
    drive = remote()
    drive.ann.lights, drive.ann.wipers = Lights.HIGH, Wipers.FAST
    drive.run(0.1)
    assert (drive.out.applied.lights, drive.out.applied.wipers) == (Lights.HIGH, Wipers.FAST)
    drive.run(2.0)
    assert drive.ask(Action.HAND_BACK).outcome is Outcome.GRANTED
    drive.until(M.AUTONOMOUS, 2.0)
    drive.run(0.1)
    assert (drive.out.applied.lights, drive.out.applied.wipers) == (Lights.LOW, Wipers.FAST)


def test_a_safe_stop_leaves_lights_and_wipers_as_the_operator_had_them():
    drive = remote()
    drive.ann.lights, drive.ann.wipers = Lights.HIGH, Wipers.SLOW
    drive.run(0.1)
    drive.ann.silent = True
    drive.run(0.6)
    assert drive.mode is M.SAFE_STOP
    assert (drive.out.applied.lights, drive.out.applied.wipers) == (Lights.HIGH, Wipers.SLOW)


def test_a_gateway_that_hears_nothing_at_all_waits_in_standby_and_counts_no_stop():
    drive = Drive()
    drive.feedback = drive.cameras = drive.automation = False
    drive.ann.silent = True
    drive.run(2.0)
    assert (drive.modes, drive.told().stops_in_ten_minutes) == ([M.STANDBY], 0)
    drive.feedback = drive.cameras = drive.automation = True
    drive.ann.silent = False
    drive.run(1.0)
    assert drive.mode is M.STANDBY
    assert drive.told().take_refused != "" and drive.lease().granted
    drive.run(0.2)
    assert drive.told().take_refused == ""


def test_a_car_that_may_engages_by_itself_once_and_not_again_after_a_stop():
    drive = Drive(limits=ENGAGING).run(0.1)
    drive.lease()
    drive.until(M.AUTONOMOUS, 2.0).run(3.0)
    drive.press_stop()
    stopped(drive).run(5.0)
    assert drive.mode is M.STOPPED


def standing_remote(vehicle=CAR):
    drive = Drive(vehicle=vehicle).run(0.3)
    drive.lease()
    drive.run(0.3)
    return taken(drive).run(0.2)


def test_reverse_is_refused_to_a_car_that_shows_no_rear_picture():
    drive = standing_remote()
    drive.ann.gear, drive.ann.throttle = Gear.REVERSE, 0.5
    for _ in range(300):
        assert drive.tick().out.applied.gear is not Gear.REVERSE
        assert drive.speed > -0.01


def test_reverse_with_a_fresh_rear_picture_is_never_faster_than_5_km_h():
    drive = standing_remote(replace(CAR, cameras=(*CAR.cameras, REAR)))
    drive.ann.gear, drive.ann.throttle = Gear.REVERSE, 2.0
    drive.run(12.0)
    assert -5 / 3.6 - 0.05 <= drive.speed < -0.5


def test_reverse_ends_when_the_rear_picture_freezes():
    drive = standing_remote(replace(CAR, cameras=(*CAR.cameras, REAR)))
    drive.ann.gear, drive.ann.throttle = Gear.REVERSE, 0.5
    drive.run(3.0)
    assert drive.speed < -0.3
    drive.ann.frozen = True
    rear = drive.ann.seen["rear"]
    for _ in range(300):
        drive.ann.seen = {"front": drive.now, "rear": rear}
        drive.tick()
    assert drive.speed == pytest.approx(0.0, abs=0.01)
