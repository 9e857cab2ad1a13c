"""A stop that begins now stays inside what is known to be free: the speed beforehand, and the way of the stop itself."""

import pytest
from msgspec.structs import replace

from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import M, remote, stopped
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.automation import TrackedObject

WALKING = 5 / 3.6


def person(drive, ahead_m, beside_m, towards_m_s=0.0):
    """Walks across the road in front of a car that goes along x."""
    return TrackedObject(
        number=1,
        kind="person",
        x_m=drive.pose[0] + ahead_m,
        y_m=drive.pose[1] + beside_m,
        velocity_x_m_s=0.0,
        velocity_y_m_s=towards_m_s,
        radius_m=0.3,
        deviation_m=0.1,
        static=towards_m_s == 0.0,
        age_s=2.0,
    )


def with_scenes(drive, seconds, **changes):
    """Scenes with these changes in place of the usual ones."""
    drive.scenes = False
    for _ in range(round(seconds * 10)):
        drive.tick(scene=drive.scene(**changes))
        drive.run(0.09)
    return drive


def test_a_person_who_walks_into_the_corridor_after_the_automation_died_is_stopped_for():
    """The corridor was free when it was checked; the walker, seen before, gets into it during the stop."""
    drive = remote().run(8.0)
    drive.scenes = False
    walker = person(drive, 9.0, -2.0, 1.4)
    free_from_m = drive.pose[0] + 9.0 - 3.6 - 0.3  # the bumper before him, wherever on the car's way he is
    drive.tick(scene=drive.scene(objects=(walker,)))
    drive.ann.silent, drive.automation = True, False
    stopped(drive)
    assert drive.pose[0] < free_from_m


def test_the_same_corridor_without_the_walker_is_braked_for_less():
    ends = []
    for objects in ((), ((9.0, -2.0, 1.4),)):
        drive = remote().run(8.0)
        drive.scenes = False
        drive.tick(scene=drive.scene(objects=tuple(person(drive, *values) for values in objects)))
        x = drive.pose[0]
        drive.ann.silent, drive.automation = True, False
        stopped(drive)
        ends.append(drive.pose[0] - x)
    assert ends[1] < ends[0] - 0.2


def test_a_standing_thing_in_the_corridor_that_the_automation_overlooked_bounds_the_speed():
    """It offers 60 m; a thing stands 12 m ahead all the time: the blind stop has 8 m."""
    drive = remote().run(8.0)
    drive.scenes = False
    drive.ann.throttle = 2.0
    for _ in range(60):
        drive.tick(scene=drive.scene(objects=(person(drive, 12.0, 0.0),)))
        drive.run(0.09)
    assert WALKING < drive.speed < 5.0
    assert stopping_distance_m(drive.speed, 0.5, 4.0, 5.0) < 12.0 - 3.6 - 0.3


def test_where_nothing_is_known_of_the_way_ahead_the_operator_drives_on_at_walking_pace():
    drive = remote().run(8.0)
    drive.automation = False
    drive.ann.throttle = 2.0
    drive.run(12.0)
    assert drive.mode is M.REMOTE
    assert drive.speed == pytest.approx(WALKING, abs=0.02)


def test_it_falls_to_walking_pace_without_a_jolt():
    drive = remote().run(8.0)
    drive.automation = False
    drive.ann.throttle = 2.0
    hardest = 0.0
    for _ in range(1200):
        drive.tick()
        hardest = min(hardest, drive.out.applied.acceleration_m_s2)
    assert hardest >= -2.5


def test_a_car_that_perceives_nothing_says_itself_how_fast_it_is_driven_blind():
    drive = remote().run(8.0)
    drive.limits = replace(drive.limits, safe_stop=replace(drive.limits.safe_stop, blind_speed_m_s=4.0))
    drive.automation = False
    drive.ann.throttle = 2.0
    drive.run(12.0)
    assert drive.speed == pytest.approx(4.0, abs=0.02)


def test_without_a_corridor_the_speed_is_bounded_by_what_is_free_along_the_wheels_as_they_are():
    """The automation looks but has no corridor; a thing stands 15 m ahead of the moving car, then beside its way."""
    speeds = {}
    for beside_m in (0.0, 5.0):
        drive = remote().run(8.0)
        drive.tick(scene=drive.scene(stopping_corridor=((0.0, 500.0),)))  # it was checked elsewhere: of no use here
        drive.scenes = False
        drive.ann.throttle = 2.0
        for _ in range(80):
            drive.tick(scene=drive.scene(objects=(person(drive, 15.0, beside_m),), stopping_corridor=()))
            drive.run(0.09)
        speeds[beside_m] = drive.speed
    assert WALKING < speeds[0.0] < 6.2 < 6.8 < speeds[5.0]
    assert stopping_distance_m(speeds[0.0], 0.5, 4.0, 5.0) < 15.0 - 3.6 - 0.3


def test_what_an_unhealthy_automation_sees_is_not_known():
    drive = remote().run(8.0)
    drive.tick(scene=drive.scene(stopping_corridor=((0.0, 500.0),)))
    drive.status = autonomy_status(healthy=False, health_note="sensors are silent")
    drive.ann.throttle = 2.0
    with_scenes(drive, 10.0, stopping_corridor=())
    assert drive.speed == pytest.approx(WALKING, abs=0.02)


def test_without_a_corridor_the_stop_holds_the_curvature_and_brakes_firmly():
    drive = remote().run(8.0)
    drive.ann.steer = 0.05
    drive.run(1.0)
    drive.tick(scene=drive.scene(stopping_corridor=((0.0, 500.0),)))
    drive.scenes, drive.ann.silent, drive.automation = False, True, False
    drive.until(M.SAFE_STOP, 1.0)
    angle, hardest = drive.angle, 0.0
    while drive.mode is M.SAFE_STOP:
        drive.tick()
        assert drive.out.requested.road_wheel_angle_rad == angle
        hardest = min(hardest, drive.out.requested.acceleration_m_s2)
    assert -4.0 <= hardest < -2.5


def test_an_operator_may_creep_past_what_the_automation_takes_for_blocked_when_he_says_so():
    """The collision guard holds the car before it until then."""
    for overrides in (False, True):
        drive = remote().run(8.0)
        drive.ann.throttle, drive.ann.override = 1.0, overrides
        x = drive.pose[0]
        with_scenes(drive, 8.0, objects=(replace(person(drive, 8.0, 1.0), radius_m=0.5),))
        assert (drive.pose[0] - x > 6.0) is overrides


def test_the_car_tells_what_a_stop_would_follow_how_much_of_it_is_free_and_where_it_would_end():
    drive = remote().run(8.0)
    way, speed = drive.told().stop_way, drive.state.feedback.speed_m_s
    assert way.along == "corridor"
    assert 58.0 < way.free_m <= 60.0
    assert way.stop_m == pytest.approx(stopping_distance_m(speed, 0.5, 2.5, 5.0))
    drive.scenes = False
    drive.tick(scene=drive.scene(stopping_corridor=((0.0, 500.0),)))
    assert (drive.told().stop_way.along, drive.told().stop_way.free_m) == ("held", 30.0)
    assert drive.told().stop_way.stop_m == pytest.approx(stopping_distance_m(drive.state.feedback.speed_m_s, 0.5, 4.0, 5.0))
    assert drive.told().failsafe == ""
    drive.run(1.2)
    assert (drive.told().stop_way.along, drive.told().stop_way.free_m) == ("", 0.0)
    assert drive.told().failsafe == "way_unknown"
    assert drive.mode is M.REMOTE


def test_a_stop_that_has_begun_is_told_without_the_silence_before_it_and_within_its_corridor():
    drive = remote().run(8.0)
    drive.scenes = False
    speed = drive.state.feedback.speed_m_s
    between_m = (stopping_distance_m(speed, 0.0, 4.0, 5.0) + stopping_distance_m(speed, 0.0, 2.5, 5.0)) / 2
    x, y, _ = drive.pose
    drive.tick(scene=drive.scene(stopping_corridor=tuple((x + 0.1 * k, y) for k in range(round(between_m * 10) + 3))))
    drive.press_stop()
    assert drive.mode is M.SAFE_STOP
    assert drive.told().stop_way.stop_m == pytest.approx(drive.told().stop_way.free_m)
    stopped(drive)
    assert drive.told().stop_way.stop_m == 0.0
