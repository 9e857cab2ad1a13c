"""Whole stories of one gateway, told in simulated time: a car, its automation, its cameras and its operators around `step`.

Longer than a test file should be, because the stories share one simulated drive. The drive checks the invariants of every
cycle (`must_hold`), whatever story is told; a state machine at the end makes up stories of its own.
"""

from copy import deepcopy
from functools import cache
from math import cos, hypot, isfinite, pi, sin, tan

import pytest
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, rule
from msgspec.structs import replace

from vehicle_gateway.authority import Event, next_authority
from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.corridor import Corridor
from vehicle_gateway.cycle import step
from vehicle_gateway.gateway import recalled_state, remember
from vehicle_gateway.lease import CommandGuard, refuse_command
from vehicle_gateway.reports import status_of
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, Outputs, State, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.automation import AutonomyCommand, AutonomyStatus, Doubt, Reason, Scene, TakeoverRequest
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.operating import DriveCommand
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.messages.vehicle import Mode, VehicleDescription

M = Mode
SHIPPED: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
CAR = replace(SHIPPED, cameras=SHIPPED.cameras[:1])  # the front one; stories that need another one add it
REAR = replace(CAR.cameras[0], name="rear", required=False, x_m=-0.8, yaw_rad=3.14)
LIMITS = GatewayLimits()
ENGAGING = GatewayLimits(authority=AuthorityLimits(engage_autonomously=True))
MS = 1_000_000
REMOTE = (M.REMOTE, M.HANDING_BACK)
HELD_TINY = 1e-9


def feedback(**changes):
    calm = Feedback(
        speed_m_s=0.0,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=0.0,
        gear=Gear.DRIVE,
        ecu_following=True,
        brake_holding=False,
        seat_occupied=False,
        driver_torque_nm=0.0,
        driver_brake=0.0,
        emergency_button=False,
        release_button=False,
    )
    return replace(calm, **changes)


def automation(**changes):
    fine = AutonomyStatus(
        stamp_ns=0,
        sequence=0,
        healthy=True,
        health_note="",
        doubt=Doubt.NOMINAL,
        evidence=(),
        request=None,
        clear_s=60.0,
        drivable_s=60.0,
        state_matched=True,
        match_note="",
        goal_reached=False,
    )
    return replace(fine, **changes)


class Operator:
    """One tower: what it holds, what it sees, what it knows of the lease. Commands leave it every cycle unless silent."""

    def __init__(self, name="ann", session="s1"):
        self.name, self.session = name, session
        self.epoch = self.sequence = self.number = 0
        self.silent = self.deaf = self.frozen = False  # deaf: no answer of the car reaches it
        self.dead_man, self.throttle, self.gear = True, 0.0, Gear.DRIVE
        self.override = False
        self.lights, self.wipers = Lights.LOW, Wipers.OFF
        self.steer: float | None = None  # None: as the car steers now
        self.loop_ms = 80
        self.seen: dict[str, int] = {}

    def see(self, now_ns, cameras):
        if not self.frozen:
            self.seen = {camera.name: now_ns - self.loop_ms * MS for camera in cameras}

    def command(self, now_ns, boot_id, measured_rad):
        self.sequence += 1
        return DriveCommand(
            lease_epoch=self.epoch,
            sequence=self.sequence,
            sent_ns=3600 * 10**9,
            event_ns=0,
            echoed_vehicle_ns=now_ns - 40 * MS,
            echoed_boot_id=boot_id,
            displayed_capture_ns=dict(self.seen),
            acceleration_m_s2=self.throttle,
            override=self.override,
            gear=self.gear,
            road_wheel_angle_rad=measured_rad if self.steer is None else self.steer,
            indicators=Indicators.OFF,
            hazard=False,
            horn=False,
            lights=self.lights,
            wipers=self.wipers,
            dead_man=self.dead_man,
        )


class Drive:
    """The car in simulated time; every flag is something that can fail. `run` and `until` move the time."""

    def __init__(self, *, speed=0.0, limits=LIMITS, vehicle=CAR, state: State | None = None, latched=False, gear=Gear.DRIVE):
        self.now = 5000 * 10**9
        self.vehicle, self.limits = vehicle, limits
        self.state = state or initial_state("boot", self.now, 100, latched)
        self.speed, self.angle, self.pose = speed, 0.0, (0.0, 0.0, 0.0)
        self.local: dict[str, object] = {"gear": gear}  # what the feedback says about the controls in the car
        self.feedback = self.cameras = self.automation = self.scenes = True
        self.status = automation()
        self.auto_steer, self.auto_acceleration, self.cruise = 0.0, 0.0, 6.0
        self.corridor_m = 60.0
        self.ann = Operator()
        self.operators = [self.ann]
        self.driver = self.ann  # whose commands the car hears
        self.guard = CommandGuard(epoch=0, boot_id=self.state.boot_id, last_sequence=0)
        self.late_guard = False  # commands are checked against what was known one cycle ago: they came in between
        self.ticks = 0
        self.out: Outputs | None = None
        self.modes: list[Mode] = [self.state.authority.mode]
        self.granted_at_ns = 0
        self.allowed_ns = 0  # when a command last came that gives the operator the right to drive

    @property
    def mode(self):
        return self.state.authority.mode

    def told(self):
        return status_of(self.state, self.now, self.vehicle, self.limits, {})

    # what happens to the car -------------------------------------------------------------------------------------------

    def tick(self, dt_ms=10.0, **extra):
        self.now += round(dt_ms * MS)
        self.ticks += 1
        inputs = self._inputs(**extra)
        before = self.state
        self.state, self.out = step(before, inputs, self.now, self.vehicle, self.limits)
        self._note(before, inputs)
        must_hold(self, before, inputs, min(dt_ms, 100.0) / 1e3)
        self._move(dt_ms / 1e3)
        if self.mode is not self.modes[-1]:
            self.modes.append(self.mode)
        return self

    def run(self, seconds, dt_ms=10.0):
        for _ in range(round(seconds * 1e3 / dt_ms)):
            self.tick(dt_ms)
        return self

    def until(self, mode, seconds=20.0):
        for _ in range(round(seconds * 100)):
            if self.mode is mode:
                return self
            self.tick()
        raise AssertionError(f"{mode} never came: {self.modes}, {self.told().cause}, {self.told().take_refused}")

    def _inputs(self, **extra):
        fields: dict[str, object] = {}
        if self.feedback:
            fields["feedback"] = feedback(
                **{
                    "speed_m_s": self.speed,
                    "road_wheel_angle_rad": self.angle,
                    "yaw_rate_rad_s": self.speed * tan(self.angle) / self.vehicle.wheelbase_m,
                }
                | self.local
            )
        for operator in self.operators:
            operator.see(self.now, self.vehicle.cameras)
            if not operator.deaf and operator.session == self.state.lease.session and self.ticks % 5 == 0:
                operator.epoch = self.state.lease.epoch  # GatewayStatus, 20 Hz, tells it
        fields |= self._command() | self._of_automation()
        if self.cameras and self.ticks % 20 == 1:
            fields["cameras"] = tuple(camera_status(camera.name, self.now) for camera in self.vehicle.cameras)
        return Inputs(**(fields | extra))

    def _command(self):
        if self.driver.silent:
            return {}
        command = self.driver.command(self.now, self.state.boot_id, self.angle)
        guard = self.guard
        self.guard = replace(guard, epoch=self.state.lease.epoch)
        if refuse_command(command, guard if self.late_guard else self.guard, True, self.now):
            return {}
        self.guard = replace(self.guard, last_sequence=command.sequence)
        return {"command": command, "command_ns": self.now - 2 * MS}

    def _of_automation(self):
        if not self.automation:
            return {}
        brakes = min(max(self.cruise - self.speed, -1.0), 1.0) if self.auto_acceleration == 0.0 else self.auto_acceleration
        fields = {
            "autonomy": AutonomyCommand(
                stamp_ns=self.now, sequence=self.ticks, road_wheel_angle_rad=self.auto_steer, acceleration_m_s2=brakes
            )
        }
        if self.ticks % 5 == 1:
            fields["autonomy_status"] = replace(self.status, stamp_ns=self.now, sequence=self.ticks)
        if self.scenes and self.ticks % 10 == 1:
            fields["scene"] = self.scene()
        return fields

    def scene(self, **changes):
        x, y, heading = self.pose
        ahead = tuple((x + s * cos(heading), y + s * sin(heading)) for s in (0.5 * k for k in range(int(self.corridor_m * 2) + 1)))
        now = Scene(
            stamp_ns=self.now,
            x_m=x,
            y_m=y,
            heading_rad=(heading + pi) % (2 * pi) - pi,
            speed_m_s=self.speed,
            yaw_rate_rad_s=0.0,
            deviation_m=0.1,
            station_m=0.0,
            offset_m=0.0,
            objects=(),
            plan=(),
            stopping_corridor=ahead,
        )
        return replace(now, **changes)

    def _move(self, dt_s):
        assert self.out is not None
        x, y, heading = self.pose
        self.pose = (
            x + self.speed * dt_s * cos(heading),
            y + self.speed * dt_s * sin(heading),
            heading + self.speed * dt_s * tan(self.angle) / self.vehicle.wheelbase_m,
        )
        if not self.out.send or self.mode is M.LOCAL_DRIVER:
            return
        self.angle = self.out.applied.road_wheel_angle_rad
        way = -1.0 if self.out.applied.gear is Gear.REVERSE else 1.0
        along = self.speed * way + self.out.applied.acceleration_m_s2 * dt_s
        stands = self.out.applied.acceleration_m_s2 < 0.0 and along < 0.0
        self.speed = 0.0 if stands else along * way

    def _note(self, before, inputs):
        """The test's own account of when the operator last earned the right to drive."""
        command = inputs.command
        if command is not None and command.dead_man and command.lease_epoch == self.state.lease.epoch:
            self.allowed_ns = inputs.command_ns

    # what the people do ------------------------------------------------------------------------------------------------

    def lease(self, operator=None) -> LeaseReply:
        operator = operator or self.ann
        self.tick(lease_requests=(LeaseRequest(operator=operator.name, session=operator.session, sent_ns=0),))
        assert self.out is not None
        reply = self.out.lease_replies[0]
        if reply.granted:
            self.guard = replace(self.guard, last_sequence=0) if operator is not self.driver else self.guard
            operator.epoch, self.driver = reply.epoch, operator
        return reply

    def ask(self, action, operator=None) -> HandOverReply:
        operator = operator or self.ann
        operator.number += 1
        self.tick(
            hand_over_requests=(
                HandOverRequest(
                    lease_epoch=operator.epoch,
                    number=operator.number,
                    action=action,
                    sent_ns=0,
                    echoed_vehicle_ns=self.now,
                    echoed_boot_id=self.state.boot_id,
                ),
            )
        )
        assert self.out is not None
        reply = self.out.hand_over_replies[0]
        if reply.outcome is Outcome.GRANTED:
            self.granted_at_ns = self.now
        if not operator.deaf:
            operator.epoch = reply.lease_epoch
        return reply

    def press_stop(self, number=1):
        return self.tick(stop_number=number)

    def request_takeover(self, budget_s=10.0):
        request = TakeoverRequest(
            number=1,
            raised_ns=self.now,
            budget_s=budget_s,
            place=(30.0, 0.0),
            reasons=(Reason(channel="planner", text="the lane is closed"),),
        )
        self.status = replace(self.status, doubt=Doubt.REQUEST, request=request, clear_s=0.0)
        return self

    def withdraw(self):
        self.status = automation()
        return self


def camera_status(name, now, **changes):
    fine = CameraStatus(
        stamp_ns=now,
        camera=name,
        source="simulated",
        live=True,
        newest_capture_ns=now,
        frames=1,
        repeated=0,
        bitrate_kbps=3000.0,
        encode_ms=5.0,
        watching=1,
    )
    return replace(fine, **changes)


def must_hold(drive: Drive, before: State, inputs: Inputs, dt_s: float) -> None:
    """What is true of every cycle of every story."""
    after, out = drive.state, drive.out
    assert out is not None
    applied, previous = out.applied, before.applied
    if before.feedback is None and after.feedback is not None:
        previous = replace(previous, road_wheel_angle_rad=after.feedback.road_wheel_angle_rad)
    assert all(
        map(
            isfinite, (applied.road_wheel_angle_rad, applied.acceleration_m_s2, out.cap_m_s, after.odometry.x_m, after.odometry.y_m)
        )
    )
    assert abs(applied.road_wheel_angle_rad) <= 0.6 + HELD_TINY
    assert abs(applied.road_wheel_angle_rad - previous.road_wheel_angle_rad) <= 0.6 * dt_s + HELD_TINY
    assert -8.0 <= applied.acceleration_m_s2 <= min(2.0, max(previous.acceleration_m_s2, 0.0) + 3.0 * dt_s + HELD_TINY)
    authority = before.authority
    for name in out.events:
        authority = next_authority(authority, Event(name))
    assert authority == after.authority == replace(after.authority, mode=out.mode), "a mode that the table does not give"
    assert after.lease.epoch >= before.lease.epoch, "an epoch fell"
    if after.mode_since_ns == drive.now and before.authority.mode is M.SAFE_STOP:
        assert after.authority.mode in (M.STOPPED, M.LOCAL_DRIVER, M.EMERGENCY_STOP, M.HANDING_OVER)
        assert after.authority.mode is not M.HANDING_OVER or Event.STANDSTILL in out.events
    if after.hand_over.state == "granted":
        assert after.authority.mode in (M.HANDING_OVER, M.HANDING_BACK), "a grant that nothing can come of is still called granted"
    if out.mode in REMOTE:
        _operator_must_be_allowed(drive, before, inputs, out)
    if out.mode in (M.STANDBY, M.STOPPED, M.SAFE_STOP, M.EMERGENCY_STOP):
        assert applied.acceleration_m_s2 <= 0.0, "the car is driven though nobody drives"


def _operator_must_be_allowed(drive: Drive, before: State, inputs: Inputs, out: Outputs) -> None:
    if before.authority.mode not in REMOTE:
        command = inputs.command
        assert command is not None and command.dead_man, "committed without a dead-man"
        assert command.lease_epoch == before.lease.epoch, "committed by a command with an old epoch"
        assert drive.now - drive.granted_at_ns <= 300 * MS, "committed too late"
    command = drive.state.command
    fresh = drive.now - drive.allowed_ns <= 120 * MS
    if not fresh or command is None or not command.dead_man:
        assert out.applied.acceleration_m_s2 <= 0.0, "traction without the right to drive"
        angle, held = out.applied.road_wheel_angle_rad, before.applied.road_wheel_angle_rad
        assert angle == held or (abs(angle) < abs(held) and drive.speed > 3.0), "steering without the right to drive"


@cache
def _prepared(story, vehicle):
    return story(vehicle)


def autonomous(vehicle=CAR) -> Drive:
    """A car that drives itself at cruising speed, an operator ready."""
    return deepcopy(_prepared(_autonomous, vehicle))


def remote(vehicle=CAR) -> Drive:
    """A car that the operator has been driving for four seconds, straight on at its cap, with a little throttle."""
    return deepcopy(_prepared(_remote, vehicle))


def _autonomous(vehicle) -> Drive:
    drive = Drive(vehicle=vehicle).run(0.1)
    drive.lease()
    assert drive.ask(Action.ENGAGE).outcome is Outcome.GRANTED
    return drive.run(8.0)


def _remote(vehicle) -> Drive:
    drive = taken(_autonomous(vehicle))
    drive.ann.throttle = 0.2
    return drive.run(4.0)


def taken(drive: Drive) -> Drive:
    """The operator takes over and drives."""
    reply = drive.ask(Action.TAKE)
    assert reply.outcome is Outcome.GRANTED, reply.rule
    return drive.until(M.REMOTE, 0.3)


def lag(drive: Drive, loop_ms: int) -> None:
    """The link grows slower bit by bit: pictures go on advancing."""
    while drive.ann.loop_ms < loop_ms:
        drive.ann.loop_ms += 4
        drive.tick()


def stopped(drive: Drive) -> Drive:
    return drive.until(M.STOPPED, 15.0).run(0.5)


# -- the whole session ---------------------------------------------------------------------------------------------------


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


# -- the operator or the link lost ----------------------------------------------------------------------------------------


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


# -- the automation lost --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("loss", ["silent", "unhealthy", "status silent"])
def test_an_automation_that_is_lost_while_it_drives_ends_at_standstill(loss):
    drive = autonomous()
    speed, x = drive.speed, drive.pose[0]
    if loss == "silent":
        drive.automation = False
    elif loss == "unhealthy":
        drive.status = automation(healthy=False, health_note="no localization")
    else:
        drive.ticks = 0
        drive.status = automation()
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


# -- grants ---------------------------------------------------------------------------------------------------------------


def test_a_grant_that_is_not_used_within_300_ms_lapses_and_changes_nothing():
    drive = autonomous()
    reply = drive.ask(Action.TAKE)
    drive.ann.deaf, drive.ann.epoch = True, reply.lease_epoch - 1  # the grant is still on its way
    drive.run(0.28)
    assert drive.mode is M.HANDING_OVER
    drive.run(0.04)
    assert (drive.mode, drive.told().hand_over.state) == (M.AUTONOMOUS, "expired")
    drive.ann.epoch = reply.lease_epoch
    drive.run(1.0)
    assert drive.mode is M.AUTONOMOUS


@pytest.mark.parametrize("seconds", [0.05, 0.15, 0.25, 0.28])
def test_a_grant_that_reaches_a_slow_tower_within_300_ms_is_committed(seconds):
    """Until then its commands carry the old epoch and are dropped: that is no loss of who receives."""
    drive = autonomous()
    drive.ann.deaf = True
    reply = drive.ask(Action.TAKE)
    drive.run(seconds)
    drive.ann.epoch = reply.lease_epoch
    drive.run(0.02)
    assert drive.mode is M.REMOTE


def test_an_operator_whose_picture_froze_while_the_grant_was_under_way_does_not_get_the_car():
    """Who receives is lost: the hand-over is aborted, and the healthy automation drives on instead of being stopped."""
    drive = autonomous()
    drive.ann.deaf = True
    reply = drive.ask(Action.TAKE)
    drive.ann.frozen = True
    drive.run(0.25)
    drive.ann.epoch = reply.lease_epoch
    drive.run(1.0)
    assert drive.mode is M.AUTONOMOUS
    assert M.SAFE_STOP not in drive.modes


def test_an_operator_who_falls_silent_does_not_get_the_car():
    drive = autonomous()
    drive.ask(Action.TAKE)
    drive.ann.silent = True
    drive.run(0.5)
    assert drive.modes[-2:] == [M.HANDING_OVER, M.AUTONOMOUS]
    assert drive.told().hand_over.state in ("expired", "aborted")


def test_a_gateway_that_slept_over_a_grant_does_not_commit_it_afterwards():
    drive = autonomous()
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.tick(400.0)
    assert drive.mode is M.AUTONOMOUS


def test_a_grant_that_never_reaches_the_tower_changes_nothing():
    drive = autonomous()
    drive.ann.deaf = True
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.run(2.0)
    assert drive.modes[-3:] == [M.AUTONOMOUS, M.HANDING_OVER, M.AUTONOMOUS]


def test_a_command_with_the_old_epoch_never_commits_a_grant_even_if_it_passed_the_door_before_the_grant_was_known():
    drive = autonomous()
    drive.ann.deaf = drive.late_guard = True
    assert drive.ask(Action.TAKE).outcome is Outcome.GRANTED
    drive.run(1.0)
    assert M.REMOTE not in drive.modes


def test_a_grant_without_the_dead_man_is_not_committed():
    drive = autonomous()
    drive.ask(Action.TAKE)
    drive.ann.dead_man = False
    drive.run(0.5)
    assert M.REMOTE not in drive.modes


def test_a_hand_back_whose_grant_is_lost_in_flight_leaves_the_operator_driving():
    """Architecture: a grant lost in flight changes nothing. The tower goes on with the epoch it knows."""
    drive = remote()
    drive.auto_steer = 0.2
    drive.ann.deaf = True
    assert drive.ask(Action.HAND_BACK).outcome is Outcome.GRANTED
    drive.run(3.0)
    assert drive.modes[-3:] == [M.REMOTE, M.HANDING_BACK, M.REMOTE]


def test_a_grant_in_the_very_cycle_of_an_emergency_does_not_stay_granted():
    drive = autonomous()
    drive.local["emergency_button"] = True
    drive.ask(Action.TAKE)
    assert drive.mode is M.EMERGENCY_STOP
    assert drive.told().hand_over.state != "granted"


def test_each_question_gets_one_answer_and_two_at_once_are_not_both_granted():
    drive = autonomous()
    two = tuple(
        HandOverRequest(
            lease_epoch=drive.ann.epoch,
            number=number,
            action=Action.TAKE,
            sent_ns=0,
            echoed_vehicle_ns=drive.now,
            echoed_boot_id=drive.state.boot_id,
        )
        for number in (8, 9)
    )
    drive.tick(hand_over_requests=two)
    assert [reply.number for reply in drive.out.hand_over_replies] == [8, 9]
    assert [reply.outcome for reply in drive.out.hand_over_replies] == [Outcome.GRANTED, Outcome.REFUSED]


def test_steering_and_traction_step_less_while_control_changes_hands():
    drive = taken(autonomous())
    drive.ann.steer, drive.ann.throttle = 0.3, 2.0
    before = drive.out.applied
    for _ in range(20):
        drive.tick()
        assert abs(drive.out.applied.road_wheel_angle_rad - before.road_wheel_angle_rad) <= 0.3 * 0.01 + 1e-9
        assert drive.out.applied.acceleration_m_s2 <= max(before.acceleration_m_s2, 0.0) + 0.5 * 0.01 + 1e-9
        before = drive.out.applied
    drive.ann.throttle = -6.0
    assert drive.tick().out.applied.acceleration_m_s2 == -6.0


@pytest.mark.parametrize(
    ("spoil", "word"),
    [
        (lambda drive: setattr(drive.ann, "dead_man", False), "dead-man"),
        (lambda drive: setattr(drive.ann, "throttle", 0.5), "throttle"),
        (lambda drive: setattr(drive.ann, "steer", 0.1), "wheel"),
        (lambda drive: setattr(drive.ann, "frozen", True), "picture"),
        (lambda drive: setattr(drive.ann, "silent", True), "no "),
        (lambda drive: setattr(drive.ann, "loop_ms", 700), "slow"),
        (lambda drive: setattr(drive, "cameras", False), "camera front"),
        (lambda drive: drive.local.update(ecu_following=False), "car"),
    ],
)
def test_a_take_over_is_refused_with_its_reason_and_the_screen_says_the_same(spoil, word):
    drive = Drive().run(0.3)
    drive.lease()
    drive.run(0.5)
    assert drive.told().take_refused == ""
    spoil(drive)
    drive.run(2.0)
    assert word in drive.told().take_refused
    reply = drive.ask(Action.TAKE)
    assert (reply.outcome, drive.mode) == (Outcome.REFUSED, M.STANDBY)
    assert word in reply.rule


@pytest.mark.parametrize("mode", [M.STANDBY, M.AUTONOMOUS])
def test_a_take_over_without_feedback_from_the_car_is_refused(mode):
    drive = autonomous() if mode is M.AUTONOMOUS else Drive().run(0.5)
    drive.lease()
    drive.run(0.2)
    drive.feedback = False
    drive.run(0.09 if mode is M.AUTONOMOUS else 0.5)
    reply = drive.tick(20.0).ask(Action.TAKE)
    assert reply.outcome is Outcome.REFUSED


def test_a_file_played_as_a_camera_is_refused_with_its_reason():
    drive = Drive().run(0.3)
    drive.lease()
    drive.cameras = False
    drive.tick(cameras=(camera_status("front", drive.now, live=False, source="file"),)).run(0.2)
    assert "front" in drive.told().take_refused and "file" in drive.told().take_refused


# -- the lease ------------------------------------------------------------------------------------------------------------


def test_a_second_operator_is_told_who_holds_the_lease_and_his_questions_are_refused():
    drive = remote()
    bob = Operator("bob", "s2")
    bob.deaf = True  # a refusal tells him the epoch; without the key of the lease that is of no use, and there is no key here
    reply = drive.lease(bob)
    assert not reply.granted and "ann" in reply.rule
    for action in Action:
        assert drive.ask(action, bob).outcome is Outcome.REFUSED
    assert drive.mode is M.REMOTE
    assert drive.told().lease_holder == "ann"


def test_after_five_silent_seconds_a_second_operator_takes_over_and_the_first_is_worthless():
    drive = autonomous()
    drive.ann.silent = True
    drive.run(5.1)
    bob = Operator("bob", "s2")
    drive.operators.append(bob)
    assert drive.lease(bob).granted
    drive.run(0.3)
    assert drive.ask(Action.TAKE).outcome is Outcome.REFUSED
    assert drive.ask(Action.TAKE, bob).outcome is Outcome.GRANTED
    drive.until(M.REMOTE, 0.3)
    drive.driver, drive.ann.silent = drive.ann, False
    drive.run(0.6)
    assert drive.mode is not M.REMOTE, "the old operator's commands kept the drive alive"


def test_a_question_that_lay_about_while_the_gateway_slept_is_not_answered_with_a_yes():
    drive = Drive(limits=LIMITS).run(0.3)
    drive.lease()
    drive.run(0.3)
    old = HandOverRequest(
        lease_epoch=drive.ann.epoch,
        number=1,
        action=Action.ENGAGE,
        sent_ns=0,
        echoed_vehicle_ns=drive.now - 600 * MS,
        echoed_boot_id=drive.state.boot_id,
    )
    for stale in (old, replace(old, number=2, echoed_vehicle_ns=drive.now, echoed_boot_id="another boot")):
        drive.tick(hand_over_requests=(stale,))
        assert drive.out.hand_over_replies[0].outcome is Outcome.REFUSED
        assert drive.mode is M.STANDBY


def test_a_return_hours_after_another_is_no_second_bounce():
    drive = handed_back(remote())
    for _ in range(2):
        drive.ann.throttle = 0.0
        drive.run(0.1)
        assert drive.ask(Action.RETURN).outcome is Outcome.GRANTED
        drive.until(M.REMOTE, 0.3)
        handed_back(drive).run(11.0)  # the guard has run out
        assert drive.mode is M.AUTONOMOUS
        taken(drive)
        handed_back(drive)


def test_what_the_former_operator_saw_and_held_does_not_count_for_the_next():
    drive = autonomous()
    drive.ann.silent = True
    drive.run(5.1)
    bob = Operator("bob", "s2")
    bob.silent = True
    assert drive.lease(bob).granted
    reply = drive.ask(Action.TAKE, bob)
    assert reply.outcome is Outcome.REFUSED


def test_a_returning_tower_asks_anew_and_gets_a_new_epoch():
    drive = autonomous()
    old = drive.ann.epoch
    drive.ann.silent = True
    drive.run(0.6)
    drive.ann.session, drive.ann.silent, drive.ann.epoch = "s2", False, 0
    reply = drive.lease()
    assert reply.granted and reply.epoch > old


# -- STOP -----------------------------------------------------------------------------------------------------------------


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


# -- guard and bounces ----------------------------------------------------------------------------------------------------


def handed_back(drive: Drive) -> Drive:
    drive.withdraw().run(0.2)
    reply = drive.ask(Action.HAND_BACK)
    assert reply.outcome is Outcome.GRANTED, reply.rule
    return drive.until(M.AUTONOMOUS, 2.0).run(1.0)


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


# -- the person in the car --------------------------------------------------------------------------------------------------


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


# -- the gateway itself -----------------------------------------------------------------------------------------------------


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
    drive.status = automation(healthy=False, health_note="no plan")
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


# -- reverse --------------------------------------------------------------------------------------------------------------


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


# -- stories nobody thought of ----------------------------------------------------------------------------------------------

SWITCHES = ("feedback", "cameras", "automation", "scenes")
HABITS = ("silent", "deaf", "frozen")


class AnyStory(RuleBasedStateMachine):
    """Arbitrary losses, presses, commands and pauses, from a car that drives itself or stands; `must_hold` checks each cycle."""

    @initialize(story=st.sampled_from([autonomous, remote, lambda: Drive().run(0.2), lambda: Drive(speed=4.0).run(0.02)]))
    def begin(self, story):
        self.drive = story()
        self.bob = Operator("bob", "s2")
        self.drive.operators.append(self.bob)

    @rule(seconds=st.sampled_from([0.01, 0.05, 0.15, 0.6, 2.0]))
    def time_goes_on(self, seconds):
        self.drive.run(seconds)

    @rule(dt_ms=st.sampled_from([1.0, 4.0, 50.0, 400.0, 3000.0]))
    def a_cycle_comes_early_or_late(self, dt_ms):
        self.drive.tick(dt_ms)

    @rule(name=st.sampled_from(SWITCHES), seconds=st.sampled_from([0.05, 0.3, 1.0]))
    def something_fails_for_a_while(self, name, seconds):
        setattr(self.drive, name, False)
        self.drive.run(seconds)
        setattr(self.drive, name, True)

    @rule(name=st.sampled_from(HABITS), seconds=st.sampled_from([0.05, 0.15, 0.3, 1.0, 6.0]))
    def the_operator_is_gone_for_a_while(self, name, seconds):
        setattr(self.drive.driver, name, True)
        self.drive.run(seconds)
        setattr(self.drive.driver, name, False)

    @rule(on=st.booleans())
    def commands_come_in_while_a_grant_is_made(self, on):
        self.drive.late_guard = on

    @rule(
        steer=st.sampled_from([None, -0.6, -0.02, 0.1]),
        throttle=st.sampled_from([-10.0, -2.0, 0.0, 0.5, 5.0]),
        gear=st.sampled_from(Gear),
        loop_ms=st.sampled_from([0, 80, 300, 600]),
        dead_man=st.booleans(),
    )
    def the_operator_acts(self, steer, throttle, gear, loop_ms, dead_man):
        driver = self.drive.driver
        driver.steer, driver.throttle, driver.gear, driver.loop_ms, driver.dead_man = steer, throttle, gear, loop_ms, dead_man
        self.drive.run(0.2)

    @rule(deaf=st.booleans())
    def the_operator_calmly_takes_over(self, deaf):
        driver = self.drive.driver
        driver.steer, driver.throttle, driver.gear, driver.loop_ms, driver.dead_man = None, 0.0, Gear.DRIVE, 80, True
        self.drive.run(0.3)
        driver.deaf = deaf
        self.drive.ask(Action.TAKE, driver)
        self.drive.run(0.05)
        driver.deaf = False

    @rule(steer=st.sampled_from([0.0, 0.2, -0.8]), acceleration=st.floats(-10.0, 5.0))
    def the_automation_acts(self, steer, acceleration):
        self.drive.auto_steer, self.drive.auto_acceleration = steer, acceleration

    @rule(changes=st.sampled_from([{}, {"healthy": False}, {"clear_s": 0.0}, {"state_matched": False}]))
    def the_automation_judges_itself(self, changes):
        self.drive.status = automation(**changes)

    @rule(budget_s=st.sampled_from([0.0, 1.0, 10.0]))
    def the_automation_asks(self, budget_s):
        self.drive.request_takeover(budget_s)

    @rule(action=st.sampled_from(Action), second=st.booleans())
    def a_question_comes(self, action, second):
        self.drive.ask(action, self.bob if second else self.drive.driver)

    @rule(second=st.booleans())
    def a_lease_is_asked_for(self, second):
        self.drive.lease(self.bob if second else self.drive.ann)

    @rule(number=st.integers(1, 3))
    def stop_is_pressed(self, number):
        self.drive.press_stop(number)

    @rule(
        local=st.sampled_from(
            [
                {"driver_torque_nm": 5.0},
                {"driver_brake": 0.3},
                {"emergency_button": True},
                {"release_button": True},
                {"seat_occupied": True},
                {"seat_occupied": True, "driver_torque_nm": -5.0},
                {"ecu_following": False},
            ]
        ),
        seconds=st.sampled_from([0.02, 0.07, 0.6]),
    )
    def the_person_in_the_car_acts(self, local, seconds):
        before = dict(self.drive.local)
        self.drive.local |= local
        self.drive.run(seconds)
        self.drive.local = before

    @rule(action=st.sampled_from(Action))
    def a_question_comes_in_the_cycle_of_an_emergency(self, action):
        self.drive.local["emergency_button"] = True
        self.drive.ask(action, self.drive.driver)
        del self.drive.local["emergency_button"]

    @rule()
    def the_gateway_dies_and_comes_back(self):
        drive = self.drive
        moving = abs(drive.speed) > 0.06
        epoch = drive.state.lease.epoch
        drive.state = recalled_state(remember(drive.state, epoch + 1_000_000, 0), "boot", drive.now, 0)
        drive.allowed_ns = 0
        assert drive.state.lease.epoch > epoch
        if drive.feedback:
            drive.tick()
            assert not moving or drive.mode in (M.SAFE_STOP, M.EMERGENCY_STOP, M.LOCAL_DRIVER), "it moves, and nobody stops it"

    def teardown(self):
        """In the end everybody who could drive is lost: the car stands, and soon."""
        if not hasattr(self, "drive"):
            return
        drive = self.drive
        drive.feedback, drive.automation = True, False
        drive.ann.silent = self.bob.silent = True
        drive.local = {"gear": Gear.DRIVE}
        drive.run(1.0 + abs(drive.speed) / 1.5 + 2.0)
        assert abs(drive.speed) < 0.06, f"still at {drive.speed} m/s in {drive.mode}"
        assert drive.mode in (M.STANDBY, M.STOPPED, M.SAFE_STOP, M.EMERGENCY_STOP, M.LOCAL_DRIVER)


AnyStory.TestCase.settings = settings(
    max_examples=60,
    stateful_step_count=25,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
test_no_story_breaks_what_must_hold = AnyStory.TestCase
