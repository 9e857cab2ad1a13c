"""A gateway that starts, sleeps, or does not hear the car: stories in simulated time."""

from math import cos, hypot, sin

import pytest
from msgspec.structs import replace

from tests.messages import autonomy_status
from tests.vehicle_gateway.one_gateway import Drive, M, autonomous, remote, stopped
from vehicle_gateway.corridor import Corridor
from vehicle_gateway.gateway import recalled_state, remember
from wire.messages.session import Action, Outcome


def test_a_gateway_that_starts_while_the_car_moves_stops_it_with_the_wheels_as_they_are():
    drive = Drive(speed=5.0)
    drive.local["road_wheel_angle_rad"] = drive.angle = 0.1
    drive.automation = False
    drive.tick()
    assert drive.mode is M.SAFE_STOP
    drive.local.pop("road_wheel_angle_rad")
    drive.run(0.5)
    assert drive.angle == pytest.approx(0.1, abs=0.02), "the curvature was not held"
    stopped(drive)


def test_a_gateway_that_starts_while_a_person_drives_leaves_the_car_to_him():
    before = Drive(speed=5.0)
    before.local |= {"seat_occupied": True, "driver_torque_nm": 5.0}
    before.run(0.2)
    again = recalled_state(remember(before.state, 2_000_000, 0), "second", before.now, 0)
    drive = Drive(speed=5.0, state=again)
    drive.local |= {"seat_occupied": True}
    drive.run(0.2)
    assert drive.mode is M.LOCAL_DRIVER


def test_somebody_in_the_seat_who_did_not_drive_before_is_no_driver_for_a_gateway_that_starts_while_moving():
    drive = Drive(speed=4.0)
    drive.local |= {"seat_occupied": True}
    drive.run(0.1)
    assert drive.mode is M.SAFE_STOP
    drive.until(M.STOPPED, 5.0)


def test_a_gateway_that_died_in_a_safe_stop_goes_on_stopping_the_moving_car():
    drive = remote()
    drive.ann.silent = True
    drive.until(M.SAFE_STOP, 1.0)
    again = recalled_state(remember(drive.state, 2_000_000, 0), "second", drive.now, 0)
    restarted = Drive(speed=drive.speed, state=again)
    restarted.now = drive.now
    restarted.run(0.05)
    assert restarted.mode is M.SAFE_STOP
    stopped(restarted)


@pytest.mark.parametrize(("mode", "expected"), [("emergency", M.EMERGENCY_STOP), ("stopped", M.STOPPED)])
def test_latches_survive_a_restart(mode, expected):
    drive = autonomous()
    if mode == "emergency":
        drive.local["emergency_button"] = True
        drive.run(4.0)
    else:
        drive.press_stop()
        stopped(drive)
    again = recalled_state(remember(drive.state, 2_000_000, 0), "second", drive.now, 0)
    restarted = Drive(state=again)
    restarted.run(1.0)
    assert restarted.mode is expected
    assert restarted.lease().granted
    restarted.run(0.2)
    assert restarted.ask(Action.TAKE).outcome is Outcome.REFUSED
    assert restarted.ann.epoch > 100


@pytest.mark.parametrize("story", [autonomous, remote])
def test_a_gateway_that_stalls_for_three_seconds_takes_no_leap(story):
    drive = story()
    drive.ann.throttle, drive.ann.steer, drive.auto_steer = 2.0, 0.5, 0.5
    before = drive.out.applied
    drive.tick(3000.0)
    assert abs(drive.out.applied.road_wheel_angle_rad - before.road_wheel_angle_rad) <= 0.6 * 0.1 + 1e-9
    assert drive.out.applied.acceleration_m_s2 <= max(before.acceleration_m_s2, 0.0) + 3.0 * 0.1 + 1e-9


def test_a_stall_during_which_the_operator_fell_silent_stops_the_car_in_the_first_cycle_after_it():
    drive = remote()
    drive.ann.silent = True
    drive.tick(3000.0)
    assert drive.mode is M.SAFE_STOP


@pytest.mark.parametrize("story", [autonomous, remote])
@pytest.mark.parametrize("loss", [{"feedback": False}, {"ecu_following": False}])
def test_a_car_that_does_not_tell_or_follow_is_stopped(story, loss):
    drive = story()
    drive.feedback = loss.get("feedback", True)
    drive.local |= {name: value for name, value in loss.items() if name != "feedback"}
    drive.run(0.13)
    assert drive.mode is M.SAFE_STOP
    assert drive.out.applied.acceleration_m_s2 < 0.0


def test_the_corridor_checked_last_is_followed_though_the_automation_then_says_it_has_none():
    """It turns unhealthy in a bend and sends () from then on: what it checked 100 ms before is still the last checked."""
    drive = autonomous()
    radius = 30.0
    arc = tuple(
        (drive.pose[0] + radius * sin(s / radius), drive.pose[1] + radius * (1 - cos(s / radius)))
        for s in (0.25 * k for k in range(120))
    )
    drive.scenes = False
    drive.tick(scene=drive.scene(stopping_corridor=arc))
    drive.status = autonomy_status(healthy=False, health_note="no plan")
    drive.ticks = 0
    drive.tick(scene=drive.scene(stopping_corridor=()))
    worst = 0.0
    for _ in range(500):
        drive.tick(**({"scene": drive.scene(stopping_corridor=())} if drive.ticks % 10 == 0 else {}))
        worst = max(worst, min(hypot(drive.pose[0] - x, drive.pose[1] - y) for x, y in arc))
    assert drive.mode is M.STOPPED
    assert worst < 0.3


@pytest.mark.parametrize("stamp", [lambda now: now + 3600 * 10**9, lambda now: now - 20 * 10**9])
def test_a_scene_of_the_future_or_of_long_ago_steers_nothing(stamp):
    drive = autonomous()
    aside = tuple((drive.pose[0] + 0.5 * k, 0.3 * k) for k in range(80))
    drive.scenes = False
    drive.tick(scene=drive.scene(stopping_corridor=aside, stamp_ns=stamp(drive.now)))
    drive.automation = False
    stopped(drive)
    assert abs(drive.pose[1]) < 0.3


@pytest.mark.parametrize("corridor_m", [5.0, 8.0, 20.0])
def test_the_speed_is_bounded_beforehand_so_that_a_blind_stop_stays_within_the_corridor(corridor_m):
    """A corridor of this length goes before the car. At full throttle everybody falls silent, and there is no corridor any more."""
    drive = remote().run(8.0)
    drive.corridor_m, drive.ann.throttle = corridor_m, 2.0
    drive.run(15.0)
    assert drive.speed > 1.0
    x = drive.pose[0]
    drive.ann.silent, drive.automation = True, False
    drive.state = replace(drive.state, corridor=Corridor())
    stopped(drive)
    assert drive.pose[0] - x <= corridor_m
