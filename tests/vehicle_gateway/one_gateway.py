"""One gateway in simulated time, for the stories of `test_cycle_*.py`: its car, automation, cameras and operators around `step`.

The drive checks the invariants of every cycle (`must_hold`), whatever story is told.
"""

from copy import deepcopy
from functools import cache
from math import cos, isfinite, pi, sin, tan

from msgspec.structs import replace

from tests.messages import autonomy_status, drive_command, feedback
from vehicle_gateway.authority import Event, next_authority
from vehicle_gateway.cycle import step
from vehicle_gateway.lease import CommandGuard, refuse_command
from vehicle_gateway.reports import status_of
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, Outputs, State, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.automation import AutonomyCommand, Doubt, Reason, Scene, TakeoverRequest, TrackedObject
from wire.messages.base import Gear, Lights, Wipers
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
AHEAD_NS = 3600 * 10**9  # the towers' clocks, before the car's


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
        self.sent_ns: int | None = None  # None: now
        self.loop_ms = 80
        self.seen: dict[str, int] = {}
        self.stuck: set[str] = set()  # cameras that bring nothing new to this screen

    def see(self, now_ns, cameras):
        if not self.frozen:
            self.seen |= {camera.name: now_ns - self.loop_ms * MS for camera in cameras if camera.name not in self.stuck}

    def command(self, now_ns, boot_id, measured_rad):
        self.sequence += 1
        return drive_command(
            lease_epoch=self.epoch,
            sequence=self.sequence,
            sent_ns=now_ns + AHEAD_NS if self.sent_ns is None else self.sent_ns,
            echoed_vehicle_ns=now_ns - 40 * MS,
            echoed_boot_id=boot_id,
            displayed_capture_ns=dict(self.seen),
            acceleration_m_s2=self.throttle,
            override=self.override,
            gear=self.gear,
            road_wheel_angle_rad=measured_rad if self.steer is None else self.steer,
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
        self.status = autonomy_status()
        self.auto_steer, self.auto_acceleration, self.cruise = 0.0, 0.0, 6.0
        self.corridor_m = 60.0
        self.objects: tuple[TrackedObject, ...] = ()
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
            objects=self.objects,
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
        self.status = autonomy_status()
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


def handed_back(drive: Drive) -> Drive:
    drive.withdraw().run(0.2)
    reply = drive.ask(Action.HAND_BACK)
    assert reply.outcome is Outcome.GRANTED, reply.rule
    return drive.until(M.AUTONOMOUS, 2.0).run(1.0)
