"""A gateway among enemies, in simulated time: a car, two towers and a network that loses, repeats, delays and swaps.

The gateway is the real one: Inbox with real signatures, `step`, what it remembers. What is not modelled: slopes, slip, the
delay of the actuators. The far-side ECU brakes when no frame came for 100 ms, as the real one.
"""

from collections import Counter
from math import cos, sin, tan
from types import SimpleNamespace

from msgspec.structs import replace

from tests.messages import autonomy_status, drive_command
from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.vehicles import car_bus_of
from vehicle_gateway.cycle import step
from vehicle_gateway.gateway import recalled_state, remember
from vehicle_gateway.identity import Identity
from vehicle_gateway.inbox import Inbox, lease_reply_with_key
from vehicle_gateway.memory import EPOCH_BLOCK, Remembered
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, Outputs, State
from wire.configuration import read_sections, shipped
from wire.latest import EventQueue, Latest
from wire.messages.automation import (
    AutonomyCommand,
    Reason,
    RoadMap,
    RoadSegment,
    Scene,
    TakeoverRequest,
    TrackedObject,
    Zone,
    ZoneKind,
)
from wire.messages.base import Gear, Message
from wire.messages.operating import DriveCommand, TowerStop
from wire.messages.sensing import CameraStatus
from wire.messages.session import Action, HandOverRequest, LeaseReply, LeaseRequest, Outcome, SupervisionRequest
from wire.messages.vehicle import Mode, VehicleDescription
from wire.road import wrap_angle
from wire.signature import sign

MS = 1_000_000
AHEAD_NS = 3600 * 10**9  # the towers' clocks, before the car's
FOREVER_NS = 2**62
EVE = "signed by eve"  # the supervisor
SHIPPED: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
CAR = replace(SHIPPED, cameras=SHIPPED.cameras[:1])
BUS = car_bus_of(CanSettings(), CAR)
LIMITS = GatewayLimits(authority=AuthorityLimits(engage_autonomously=False))
ECU_SILENCE_MS, ECU_BRAKING_M_S2 = 100.0, 4.0
CALM = {
    "acceleration_m_s2": 0.0,
    "ecu_following": True,
    "brake_holding": False,
    "seat_occupied": False,
    "driver_torque_nm": 0.0,
    "driver_brake": 0.0,
    "emergency_button": False,
    "release_button": False,
}
FIT = autonomy_status()


STREET = RoadMap(
    name="street",
    start=(0.0, 0.0),
    start_heading_rad=0.0,  # stations are x, offsets are y
    segments=(RoadSegment(length_m=300.0),),
    lane_width_m=3.5,
    sidewalk_width_m=2.5,
    drives_on="right",
    speed_limit_m_s=8.0,
    goal_station_m=250.0,
    zones=tuple(
        Zone(kind=kind, name=kind, from_station_m=begin, to_station_m=end, right_m=-40.0, left_m=40.0, speed_m_s=speed_m_s)
        for kind, begin, end, speed_m_s in (
            (ZoneKind.ALLOWED, 20.0, 200.0, None),
            (ZoneKind.SPEED, 60.0, 100.0, 3.0),
            (ZoneKind.NO_STOP, 140.0, 148.0, None),
        )
    ),
)
BEHIND_CROSSING = tuple(  # from side to side: nobody has room behind it
    TrackedObject(
        number=number,
        kind="barrier",
        x_m=151.0,
        y_m=1.5 * number,
        velocity_x_m_s=0.0,
        velocity_y_m_s=0.0,
        radius_m=0.8,
        deviation_m=0.1,
        static=True,
        age_s=5.0,
    )
    for number in range(-26, 27)
)


def on_street(x_m, objects=()):
    """A world with a map: a geofence, a speed zone, a no-stop zone."""
    return World(limits=replace(LIMITS, map=STREET), x_m=x_m, objects=objects)


class Ear:
    """The gateway's side of the link, without one: whoever sends calls what the inbox registered."""

    def __init__(self):
        self.heard, self.asked, self.dropped = {}, {}, Counter()
        self.levels: dict[str, Latest] = {}
        self.queues: dict[str, EventQueue] = {}

    def level(self, name):
        return self.levels.setdefault(name, Latest())

    def events(self, name, limit=1024):
        return self.queues.setdefault(name, EventQueue(limit))

    def on(self, name, callback):
        self.heard[name] = callback

    def serve_later(self, name, handler):
        self.asked[name] = handler


class Recognised:
    """Whose certificate asks, without certificates: everybody's is his own. It ends long after the story unless it is said to."""

    def __init__(self):
        self.ends_ns: dict[str, int] = {}  # by operator, what he shows when he asks for the lease
        self.revoked: set[str] = set()  # operators

    def operator(self, request, _):
        if request.operator in self.revoked:
            return Identity(rule="this certificate was revoked")
        ends_ns = self.ends_ns.get(request.operator, FOREVER_NS)
        return Identity(name=f"tower-{request.operator}", operator=request.operator, fingerprint="f", ends_ns=ends_ns)

    def supervisor(self, request, _):
        eve = Identity(name="tower-eve", operator="eve", fingerprint="e", ends_ns=FOREVER_NS)
        return eve if request.signature == EVE else Identity(rule="not signed by a supervisor")

    def is_revoked(self, name):
        return name.removeprefix("tower-") in self.revoked


class Tower:
    """One cockpit. It goes on sending with whatever lease it believes to have."""

    def __init__(self, name):
        self.name, self.session = name, f"{name} 1"
        self.key, self.epoch, self.boot_id = b"", 0, ""
        self.sequence = self.number = 0
        self.silent = self.frozen = self.deaf = self.forging = False
        self.dead_man, self.steer, self.acceleration, self.gear = True, None, 0.0, Gear.DRIVE
        self.echo_ns = self.shown_ns = self.clock_ns = 0
        self.forged: set[str] = set()  # what it did not sign with its key

    def restart(self):
        self.session = self.session + "'"
        self.key, self.epoch, self.sequence = b"", 0, 0

    def command(self, angle_rad) -> DriveCommand:
        self.sequence += 1
        bare = drive_command(
            lease_epoch=self.epoch,
            sequence=self.sequence,
            sent_ns=self.clock_ns,
            event_ns=self.clock_ns,
            echoed_vehicle_ns=self.echo_ns,
            echoed_boot_id=self.boot_id,
            displayed_capture_ns={"front": self.shown_ns},
            road_wheel_angle_rad=angle_rad if self.steer is None else self.steer,
            acceleration_m_s2=self.acceleration,
            gear=self.gear,
            dead_man=self.dead_man,
        )
        if not self.forging:
            return sign(bare, self.key)
        forged = sign(bare, b"a guess")
        self.forged.add(forged.hmac)
        return forged


class World:
    def __init__(self, now_ns=5000 * 10**9, speed_m_s=0.0, remembered=None, limits=LIMITS, x_m=0.0, objects=()):
        self.now_ns, self.utc_ns = now_ns, 10**18
        self.limits, self.objects = limits, objects
        self.pose = x_m, 0.0, 0.0  # of the rear axle, in the map: x, y, heading
        self.speed, self.angle, self.gear, self.travelled_m = speed_m_s, 0.0, Gear.DRIVE, 0.0
        self.since_frame_ms = 0.0
        self.local: dict[str, object] = {}
        self.towers = [Tower("ann"), Tower("bob")]
        self.flying: list[tuple[int, Tower, DriveCommand]] = []  # on the way: when it arrives, whose it is
        self.past: list[tuple[Tower, DriveCommand]] = []
        self.delay_ms, self.loss_every, self.repeats, self.swaps = 20.0, 0, False, False
        self.feedback_lost = self.automation_dead = self.cameras_dead = False
        self.scenes = True
        self.status, self.auto_acceleration, self.auto_steer = FIT, 0.5, 0.0
        self.boots = self.ticks = 0
        self.recognised = Recognised()
        self.witness = None  # set by who watches: told of every arrival, every cycle and every start
        self.disk = remembered or Remembered()
        self.boot()

    def boot(self):
        """The gateway starts: what the disk says, and one block of epochs reserved on it before anything else."""
        if self.boots:
            self._move(0.0)  # what the last one sent is on its way to the wheels
        self.boots += 1
        if self.witness is not None:
            self.witness.saw_start()
        self.boot_id = f"boot {self.boots}"
        self.ear = Ear()
        self.inbox = Inbox(self.ear, self.boot_id, self.recognised, SimpleNamespace(now_ns=lambda: self.now_ns), BUS)
        self.state: State = recalled_state(self.disk, self.boot_id, self.now_ns, self.utc_ns)
        self.reserved = self.disk.epoch_reserved + EPOCH_BLOCK
        self.disk = replace(self.disk, epoch_reserved=self.reserved)
        self.flying = []
        self.inputs, self.out, self.before = Inputs(), None, self.state
        self.replies: list[tuple[Tower, Action | None, Message]] = []
        self.answers: list[tuple[Tower, Action | None, Message]] = []  # of the last cycle

    # one cycle ----------------------------------------------------------------------------------------------------------

    def tick(self, dt_ms=10.0, leases=(), hand_overs=()):
        self._move(dt_ms)
        self.now_ns += round(dt_ms * MS)
        self.ticks += 1
        self._towers_send()
        on_time, just_too_late = self._due()
        self._deliver(on_time)
        self._automation_sends()
        for tower in leases:
            self._ask_lease(tower)
        for tower, action in hand_overs:
            self._ask_hand_over(tower, action)
        self.inputs, waiting = self.inbox.take(self.state.lease.certificate, self.state.successor.lease.certificate)
        if not self.feedback_lost:
            self.inputs = replace(self.inputs, feedback=self._feedback())
        if self.witness is not None:
            self.witness.saw_take()
        self._deliver(just_too_late)
        self.before = self.state
        self.state, self.out = step(self.before, self.inputs, self.now_ns, CAR, self.limits)
        self._answer(waiting)
        self.disk = remember(self.state, self.reserved, self.utc_ns)
        if self.out.send:
            self.since_frame_ms = 0.0
        if self.witness is not None:
            self.witness.saw_cycle(self, dt_ms)
        return self

    def run(self, seconds, dt_ms=10.0):
        for _ in range(round(seconds * 1e3 / dt_ms)):
            self.tick(dt_ms)
        return self

    def _towers_send(self):
        for tower in self.towers:
            tower.clock_ns = self.now_ns + AHEAD_NS
            if not tower.deaf:
                tower.echo_ns, tower.boot_id = max(self.now_ns - 30 * MS, 0), self.boot_id
                if self.state.lease.session and self.holds(tower):
                    tower.epoch = self.state.lease.epoch  # GatewayStatus tells it
            if not tower.frozen and not self.cameras_dead:
                tower.shown_ns = max(self.now_ns - 80 * MS, 0)
            if tower.silent or not tower.key:
                continue
            command = tower.command(self.angle)
            self.past = [*self.past[-300:], (tower, command)]
            if self.loss_every and command.sequence % self.loss_every == 0:
                continue
            late_ms = self.delay_ms + (25.0 if self.swaps and command.sequence % 3 == 0 else 0.0)
            for _ in range(1 + self.repeats):
                self.flying.append((self.now_ns + round(late_ms * MS), tower, command))

    def holds(self, tower):
        """Whether this tower holds the lease."""
        return self.inbox.key_of(self.state.lease.epoch) == tower.key

    def _due(self):
        """What arrives now; every fifth just after the inbox was emptied, while the cycle is made."""
        due = sorted((item for item in self.flying if item[0] <= self.now_ns), key=lambda item: item[0])
        self.flying = [item for item in self.flying if item[0] > self.now_ns]
        late = [item for item in due if item[2].sequence % 5 == 0]
        return [item for item in due if item not in late], late

    def _deliver(self, items):
        for at_ns, tower, command in items:
            self.arrive(tower, command, at_ns)

    def arrive(self, tower, command, at_ns):
        if self.witness is not None:
            self.witness.saw_arrival(self, tower, command, at_ns)
        self.ear.heard["drive_command"](command, at_ns)

    def _automation_sends(self):
        if not self.automation_dead:
            command = AutonomyCommand(
                stamp_ns=self.now_ns,
                sequence=self.ticks,
                road_wheel_angle_rad=self.auto_steer,
                acceleration_m_s2=self.auto_acceleration if self.speed < 6.0 else min(self.auto_acceleration, 0.0),
            )
            self.ear.level("autonomy_command").put(command, self.now_ns)
            self.ear.level("autonomy_status").put(replace(self.status, stamp_ns=self.now_ns), self.now_ns)
            if self.scenes and self.ticks % 10 == 1:
                self.ear.level("scene").put(scene(self.now_ns, self.speed, self.pose, self.objects), self.now_ns)
        if not self.cameras_dead and self.ticks % 10 == 1:
            self.ear.events("camera_status").put(camera_status(self.now_ns), self.now_ns)

    def _ask_lease(self, tower):
        tower.echo_ns, tower.boot_id = max(self.now_ns - 30 * MS, 0), self.boot_id
        request = LeaseRequest(
            operator=tower.name, session=tower.session, sent_ns=0, echoed_vehicle_ns=tower.echo_ns, echoed_boot_id=tower.boot_id
        )
        self.ear.asked["lease"](request, lambda reply: self.replies.append((tower, None, reply)))

    def order(self, action, *, stop=False, forged=False, stale=False, operator=""):
        """What a supervisor asks; the next cycle decides. stale: of a lease that he no longer sees as it is."""
        request = SupervisionRequest(
            action=action,
            lease_epoch=self.state.lease.epoch - stale,
            operator=operator,
            reason="seen from above",
            stop=stop,
            sent_ns=0,
            echoed_vehicle_ns=self.now_ns,
            echoed_boot_id=self.boot_id,
            signature="" if forged else EVE,
        )
        self.ear.asked["supervision"](request, lambda _: None)

    def _ask_hand_over(self, tower, action):
        tower.number += 1
        bare = HandOverRequest(
            lease_epoch=tower.epoch,
            number=tower.number,
            action=action,
            sent_ns=0,
            echoed_vehicle_ns=tower.echo_ns,
            echoed_boot_id=tower.boot_id,
        )
        self.ear.asked["hand_over"](sign(bare, tower.key), lambda reply: self.replies.append((tower, action, reply)))

    def _answer(self, waiting):
        """As the shell does: the guard first, then the answers, each with its key."""
        self.inbox.open_for(self.before, self.state, lambda lease: f"key of {lease.owner} {lease.epoch}".encode())
        for reply, answer in zip(waiting.lease, self.out.lease_replies, strict=True):
            reply(lease_reply_with_key(answer, self.inbox.key_of(answer.epoch)))
        for reply, answer in zip(waiting.hand_over, self.out.hand_over_replies, strict=True):
            reply(answer)
        assert len(waiting.supervision) == len(self.out.supervision_replies), "a supervisor's question has no answer"
        for tower, _, answer in self.replies:
            self._told(tower, answer)
        self.answers, self.replies = self.replies, []

    def _told(self, tower, answer: Message):
        if tower.deaf:
            return
        if isinstance(answer, LeaseReply):
            if answer.granted:
                tower.key, tower.epoch, tower.boot_id = bytes.fromhex(answer.key_hex), answer.epoch, answer.boot_id
        elif answer.outcome is Outcome.GRANTED:
            tower.epoch = answer.lease_epoch

    # the car ------------------------------------------------------------------------------------------------------------

    def _feedback(self):
        fields = CALM | self.local
        yaw = self.speed * tan(self.angle) / CAR.wheelbase_m
        return Feedback(speed_m_s=self.speed, yaw_rate_rad_s=yaw, road_wheel_angle_rad=self.angle, gear=self.gear, **fields)

    def _move(self, dt_ms):
        """What the car does until the next cycle; in a long one the ECU finds itself alone."""
        heard_ms = min(dt_ms, max(ECU_SILENCE_MS - self.since_frame_ms, 0.0))
        self.since_frame_ms += dt_ms
        out: Outputs | None = self.out
        driven_by_us = out is not None and out.send and out.mode is not Mode.LOCAL_DRIVER
        if driven_by_us:
            self.angle, self.gear = out.applied.road_wheel_angle_rad, out.applied.gear
            self._accelerate(out.applied.acceleration_m_s2, heard_ms / 1e3)
        else:
            self._roll(heard_ms / 1e3)
        if self.state.authority.mode is Mode.LOCAL_DRIVER:
            self._roll((dt_ms - heard_ms) / 1e3)
        else:
            self._accelerate(-ECU_BRAKING_M_S2, (dt_ms - heard_ms) / 1e3)

    def speed_seen(self):
        """What the gateway was told last."""
        return 0.0 if self.state.feedback is None else self.state.feedback.speed_m_s

    def _roll(self, dt_s):
        self._go(self.speed * dt_s)

    def _go(self, way_m):
        """Forwards, or backwards when it is negative, with the wheels as they are."""
        x, y, heading = self.pose
        turn = way_m * tan(self.angle) / CAR.wheelbase_m
        middle = heading + turn / 2
        self.pose = x + way_m * cos(middle), y + way_m * sin(middle), heading + turn
        self.travelled_m += abs(way_m)

    def _accelerate(self, asked_m_s2, dt_s):
        way = -1.0 if self.gear is Gear.REVERSE else 1.0
        if asked_m_s2 > 0.0 and self.gear in (Gear.PARK, Gear.NEUTRAL):
            asked_m_s2 = 0.0
        if asked_m_s2 < 0.0 and self.speed * way < 0.0:
            way = -way  # brakes act against the motion, whatever the gear
        along = self.speed * way
        after = along + asked_m_s2 * dt_s
        if asked_m_s2 < 0.0 and after < 0.0:
            braked_s = along / -asked_m_s2
            self._go(way * along * braked_s / 2)
            self.speed = 0.0
            return
        self._go(way * (along + after) / 2 * dt_s)
        self.speed = after * way


def camera_status(now_ns):
    return CameraStatus(
        stamp_ns=now_ns,
        camera="front",
        source="simulated",
        live=True,
        newest_capture_ns=now_ns,
        frames=1,
        repeated=0,
        bitrate_kbps=3000.0,
        encode_ms=5.0,
        watching=1,
    )


def scene(now_ns, speed_m_s, pose, objects):
    """Straight ahead 60 m that are called free."""
    x, y, heading = pose
    return Scene(
        stamp_ns=now_ns,
        x_m=x,
        y_m=y,
        heading_rad=wrap_angle(heading),
        speed_m_s=speed_m_s,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=0.0,
        offset_m=0.0,
        objects=objects,
        plan=(),
        stopping_corridor=tuple((x + ahead * cos(heading), y + ahead * sin(heading)) for ahead in range(61)),
    )


def request(now_ns, budget_s):
    return TakeoverRequest(
        number=1, raised_ns=now_ns, budget_s=budget_s, place=(30.0, 0.0), reasons=(Reason(channel="planner", text="closed"),)
    )


def stop(number=1):
    return TowerStop(number=number, sent_ns=0, operator="ann")


def led_to(mode: Mode, world: World) -> World:
    """The world in a mode, in the midst of it."""
    if mode is Mode.STANDBY:
        return world.run(0.1).tick(leases=[world.towers[0]]).run(0.3)
    if mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER):
        driven_by_itself(world)
    else:
        driven_by_operator(world)
    ann = world.towers[0]
    if mode is Mode.TAKEOVER_REQUESTED:
        world.status = replace(FIT, clear_s=0.0, request=request(world.now_ns, 10.0))
        world.run(0.2)
    elif mode is Mode.HANDING_OVER:
        world.delay_ms = 120.0  # the command that completes it is on its way
        world.run(0.3).tick(hand_overs=[(ann, Action.TAKE)]).run(0.05)
    elif mode is Mode.HANDING_BACK:
        world.auto_steer = 0.3  # does not fit what she steers
        world.run(0.1).tick(hand_overs=[(ann, Action.HAND_BACK)]).run(0.05)
    elif mode is Mode.LOCAL_DRIVER:
        world.local = {"seat_occupied": True, "driver_torque_nm": 5.0}
        world.run(0.1)
        world.local = {"seat_occupied": True}
        world.run(0.1)
    elif mode in (Mode.SAFE_STOP, Mode.STOPPED):
        world.ear.events("tower_stop").put(stop(), world.now_ns)
        world.run(0.1 if mode is Mode.SAFE_STOP else 4.0, 20.0)
    elif mode is Mode.EMERGENCY_STOP:
        world.local = {"emergency_button": True}
        world.run(0.1)
        world.local = {}
    assert world.state.authority.mode is mode, (mode, world.state.authority, world.answers)
    return world


def driven_by_itself(world) -> World:
    """Engaged by ann, who holds the lease."""
    ann = world.run(0.1).towers[0]
    world.tick(leases=[ann]).run(0.3)
    world.tick(hand_overs=[(ann, Action.ENGAGE)]).run(2.0, 40.0)
    assert world.state.authority.mode is Mode.AUTONOMOUS, world.answers
    return world


def driven_by_operator(world) -> World:
    """Ann has taken it over, and is on the throttle."""
    ann = driven_by_itself(world).towers[0]
    world.tick(hand_overs=[(ann, Action.TAKE)]).run(0.2)
    assert world.state.authority.mode is Mode.REMOTE, world.state.cause
    ann.acceleration = 1.0
    return world.run(2.0, 40.0)
