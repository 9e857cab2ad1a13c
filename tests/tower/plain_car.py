"""A plain car for the whole cockpit with the scripted operator, around the construction site, in simulated time.

The car is a kinematic bicycle with a steering lag; its gateway knows just enough of the protocol to hand the wheel over.
What is believed about the scene carries noise. Clearance is measured between the true rectangles and circles, by this file.
"""

from collections import deque
from dataclasses import dataclass, field
from math import cos, hypot, sin, tan
from random import Random
from typing import Any

import msgspec

from haptics.settings import HapticsSettings
from tests.messages import gateway_status, vehicle_description
from tower.cockpit.asker import Answer
from tower.cockpit.cockpit import Cockpit
from tower.cockpit.settings import CockpitSettings
from tower.window.keys import released
from vehicle_gateway.corridor import Odometry
from vehicle_gateway.free_way import keep_surroundings
from vehicle_gateway.guard import GuardLimits, motion_of, things_of, watch
from vehicle_gateway.place import fix_of, shift_of
from wire.configuration import shipped
from wire.latest import EventQueue, Latest
from wire.messages.automation import Reason, RoadMap, Scene, TakeoverRequest, TrackedObject
from wire.messages.base import Gear, Message, decoder, encode
from wire.messages.operating import DriveCommand, WindowStatus
from wire.messages.session import Action, HandOverReply, HandOverRequest, LeaseReply, LeaseRequest, Outcome
from wire.messages.vehicle import (
    Actuation,
    CameraCalibration,
    GatewayStatus,
    HandOver,
    Mode,
    VehicleState,
)
from wire.road import Road
from wire.scenario import read_map
from wire.signature import is_genuine

TICK_NS = 8_000_000
HOUR_NS = 3_600_000_000_000  # the tower's clock is an hour ahead
LINK_NS = 20_000_000  # one way
CAR = vehicle_description(
    cameras=(
        CameraCalibration(
            name="front",
            required=True,
            width_px=1280,
            height_px=720,
            frame_rate_hz=30.0,
            focal_length_px=760.0,
            x_m=1.7,
            y_m=0.0,
            z_m=1.35,
            yaw_rad=0.0,
            pitch_rad=0.06,
        ),
    ),
)
KEYS = msgspec.structs.replace(released(0), focus=True)
KEY = bytes(range(32))
SITE_M, SITE_LENGTH_M, TAPER_M = 150.0, 18.0, 8.0


class Thing:
    """A circle, or a bar across the lane made of circles: the truth, and what the tracker says of it."""

    def __init__(self, number: int, kind: str, station_m: float, offset_m: float, half_m: float, road: Road) -> None:
        self.number, self.kind, self.half_m = number, kind, half_m
        self.x, self.y, _ = road.to_world(station_m, offset_m)
        steps = [i / 10 * (half_m - 0.2) for i in range(-10, 11)] if kind == "barrier" else [0.0]
        self.circles = [road.to_world(station_m, offset_m + step)[:2] for step in steps]


def site(road: Road) -> list[Thing]:
    """Own lane closed from 150 to 168 m: barriers at both ends, a taper of cones in front, cones along the centre line."""
    side = road.own_side
    places = [(SITE_M - TAPER_M + 2.7 * i, 3.1 - 1.0 * i) for i in range(3)]
    places += [(SITE_M + 1.5 + 3.0 * i, 0.35) for i in range(6)]
    things = [Thing(i + 1, "cone", station, side * offset, 0.2, road) for i, (station, offset) in enumerate(places)]
    ends = (SITE_M, SITE_M + SITE_LENGTH_M)
    return things + [Thing(50 + i, "barrier", station, side * 1.75, 1.6, road) for i, station in enumerate(ends)]


@dataclass
class Walker:
    """Crosses the road at a station, from the far side to the near one, once the car is close."""

    station_m: float
    starts_within_m: float
    across_m: float = 4.6  # towards the oncoming side
    speed_m_s: float = 1.4
    walks: bool = False


@dataclass
class Car:
    road: Road
    station_m: float
    seed: int = 3
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    angle: float = 0.0
    mode: Mode = Mode.AUTONOMOUS
    epoch: int = 0
    holder: str = ""
    grant_ns: int | None = None
    hand_over: HandOver = HandOver(number=0, action="", state="", rule="")
    command: DriveCommand | None = None
    commands: list[DriveCommand] = field(default_factory=list)
    commanded_ns: int = 0

    def __post_init__(self) -> None:
        self.random = Random(self.seed)
        self.x, self.y, self.heading = self.road.to_world(self.station_m, self.road.own_lane_offset_m)

    def answer(self, request: Message) -> Message:
        if isinstance(request, LeaseRequest):
            self.holder, self.epoch = request.operator, max(self.epoch, 1)
            return LeaseReply(granted=True, epoch=self.epoch, key_hex=KEY.hex(), rule="", boot_id="b")
        assert isinstance(request, HandOverRequest) and is_genuine(request, KEY) and request.lease_epoch == self.epoch
        wrong = "not asked for" if request.action is Action.TAKE and self.mode is not Mode.TAKEOVER_REQUESTED else ""
        if wrong:
            return HandOverReply(number=request.number, outcome=Outcome.REFUSED, rule=wrong, lease_epoch=self.epoch)
        self.epoch += 1
        self.hand_over = HandOver(number=self.hand_over.number + 1, action=request.action, state="granted", rule="")
        if request.action is Action.HAND_BACK:
            self.mode = Mode.AUTONOMOUS
        number = self.hand_over.number
        return HandOverReply(number=request.number, outcome=Outcome.GRANTED, rule="", lease_epoch=self.epoch, hand_over=number)

    def hear(self, command: DriveCommand, now_ns: int) -> None:
        if command.lease_epoch != self.epoch or not is_genuine(command, KEY):
            return
        self.commands.append(command)
        self.command, self.commanded_ns = command, now_ns
        if self.hand_over.state == "granted" and self.hand_over.action == Action.TAKE and command.dead_man:
            self.mode, self.hand_over = Mode.REMOTE, msgspec.structs.replace(self.hand_over, state="committed")

    def drive(self, now_ns: int, stop_station_m: float) -> None:
        dt = TICK_NS / 1e9
        station, offset, heading = self.road.to_road(self.x, self.y)
        if self.mode is Mode.REMOTE and self.command is not None:
            wanted, acceleration = self.command.road_wheel_angle_rad, self.command.acceleration_m_s2
            if not self.command.dead_man or now_ns - self.commanded_ns > 500_000_000:
                self.mode, acceleration = Mode.SAFE_STOP, -3.0
        elif self.mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED):
            error = offset - self.road.own_lane_offset_m
            wanted = -0.25 * error - 0.9 * (self.heading - heading) + 2.7 * self.road.curvature_1_m(station)
            room = stop_station_m - station
            acceleration = 0.8 * (min(5.0, (2 * 0.8 * max(room, 0.0)) ** 0.5) - self.speed)
        else:
            wanted, acceleration = self.angle, -3.0
        self.angle += min(max(min(max(wanted, -0.6), 0.6) - self.angle, -dt * 6.0 * 0.6), dt * 6.0 * 0.6) * min(dt / 0.12 * 3, 1)
        self.acceleration += (min(max(acceleration, -8.0), 2.0) - self.acceleration) * dt / 0.15
        before, self.speed = self.speed, max(self.speed + self.acceleration * dt, 0.0)
        travelled = (before + self.speed) / 2 * dt
        self.heading += travelled * tan(self.angle) / CAR.wheelbase_m
        self.x, self.y = self.x + travelled * cos(self.heading), self.y + travelled * sin(self.heading)
        self.station_m = station

    def gap_to(self, x: float, y: float, radius: float) -> float:
        """From the car's rectangle to a circle; negative when they overlap."""
        ahead = (x - self.x) * cos(self.heading) + (y - self.y) * sin(self.heading)
        left = -(x - self.x) * sin(self.heading) + (y - self.y) * cos(self.heading)
        out = max(ahead - 3.6, -0.9 - ahead, 0.0), max(abs(left) - 0.88, 0.0)
        return hypot(*out) - radius


class Wire:
    """Link and asker of the cockpit, with the time a message is under way."""

    def __init__(self, car: Car) -> None:
        self.car = car
        self.levels: dict[str, Latest[Any]] = {}
        self.dropped: dict[str, int] = {}
        self.answers: EventQueue[Answer] = EventQueue()
        self.busy = False
        self.now_ns = 0  # of the car
        self.up: deque[tuple[int, Any]] = deque()
        self.down: deque[tuple[int, str, Message]] = deque()
        self.published: dict[str, Message] = {}

    def level(self, name: str) -> Latest[Any]:
        return self.levels.setdefault(name, Latest())

    def publish(self, name: str, message: Message) -> None:
        self.published[name] = message
        if name == "drive_command":
            self.up.append((self.now_ns + LINK_NS, decoder(DriveCommand).decode(encode(message))))

    def offer(self, query: str, request: Message) -> bool:
        self.busy = True
        self.up.append((self.now_ns + LINK_NS, (query, request)))
        return True

    def ask(self, name: str, request: Message, timeout_s: float) -> Message | None:
        raise AssertionError("the loop never asks by itself")

    def tell(self, name: str, message: Message) -> None:
        self.down.append((self.now_ns + LINK_NS, name, message))

    def carry(self) -> None:
        while self.up and self.up[0][0] <= self.now_ns:
            item = self.up.popleft()[1]
            if isinstance(item, DriveCommand):
                self.car.hear(item, self.now_ns)
            else:
                self.down.append((self.now_ns + LINK_NS, item[0] + "?", self.car.answer(item[1])))
        while self.down and self.down[0][0] <= self.now_ns:
            _, name, message = self.down.popleft()
            if name.endswith("?"):
                self.busy = False
                self.answers.put(Answer(name[:-1], message), self.now_ns + HOUR_NS)  # type: ignore[arg-type]
            else:
                self.level(name).put(message, self.now_ns + HOUR_NS)


@dataclass
class Drive:
    """One drive, step by step."""

    map_name: str = "bend.toml"
    video_ns: int = 60_000_000
    start_m: float = 112.0
    walker: Walker | None = None
    closed: bool = True
    freeze_at_m: float = 1e9
    closest_m: float = 99.0
    person_gap_m: float = 99.0
    kerb_gap_m: float = 99.0
    stalled: bool = False  # the cockpit does nothing, and hears nothing
    window_died: bool = False
    guarded: int = 0  # scenes in which the collision guard would have taken something away
    ticks: int = 0
    trace: list[tuple[float, float, float, str]] = field(default_factory=list)  # station, offset, speed, mode

    def __post_init__(self) -> None:
        self.road_map: RoadMap = read_map(shipped("maps", self.map_name))
        self.road = Road(self.road_map)
        self.things = site(self.road) if self.closed else []
        self.car = Car(self.road, self.start_m)
        self.wire = Wire(self.car)
        self.cockpit = Cockpit(
            CockpitSettings(device="scripted"), HapticsSettings(), self.wire, self.wire, "s", lambda asked: asked
        )
        self.request: TakeoverRequest | None = None
        self.frozen_capture_ns: int | None = None

    @property
    def now_ns(self) -> int:
        return 1_000_000_000 + self.ticks * TICK_NS

    def step(self) -> None:
        self.ticks += 1
        now = self.wire.now_ns = self.now_ns
        self.car.drive(now, SITE_M - TAPER_M - 3.6 - 7.0 if self.closed else 1e9)
        self._ask_for_help(now)
        self._walk()
        if self.ticks % 3 == 0:
            self.wire.tell("vehicle_state", self._state(now))
        if self.ticks % 6 == 0:
            self.wire.tell("gateway_status", self._status(now))
        if self.ticks % 12 == 0:
            scene = self._scene(now)
            self._guard(scene)
            self.wire.tell("scene", scene)
        if self.ticks % 120 == 1:
            self.wire.tell("road_map", self.road_map)
            self.wire.tell("vehicle_description", CAR)
        self.wire.carry()
        if not self.stalled:
            self.cockpit.cycle(now + HOUR_NS)
            if self.ticks % 4 == 0 and not self.window_died:
                self.wire.level("window_status").put(self._window(now), now + HOUR_NS)
        self._measure()

    def until(self, done: Any, limit_s: float) -> "Drive":
        for _ in range(round(limit_s * 1e9 / TICK_NS)):
            self.step()
            if done(self):
                return self
        raise AssertionError(
            f"not done after {limit_s} s: {self.car.mode} at {self.car.station_m:.1f} m, "
            f"{self.car.speed:.1f} m/s; {self.wire.published.get('operator_status')}"
        )

    def _ask_for_help(self, now: int) -> None:
        beyond = self.car.station_m > SITE_M + SITE_LENGTH_M + 9
        if self.car.mode is Mode.AUTONOMOUS and self.closed and not beyond and self.car.station_m > self.start_m + 6:
            self.car.mode = Mode.TAKEOVER_REQUESTED
            self.request = TakeoverRequest(
                number=1, raised_ns=now, reasons=(Reason(channel="map", text="closed"),), budget_s=15.0, place=(0.0, 0.0)
            )
        if beyond:
            self.request = None

    def _walk(self) -> None:
        walker = self.walker
        if walker is not None:
            walker.walks = walker.walks or walker.station_m - self.car.station_m < walker.starts_within_m
            walker.across_m -= walker.speed_m_s * TICK_NS / 1e9 * walker.walks * (walker.across_m > -4.8)

    def _state(self, now: int) -> VehicleState:
        actuation = Actuation(road_wheel_angle_rad=self.car.angle, acceleration_m_s2=0.0)
        loop_ms = self.video_ns / 1e6 + LINK_NS / 1e6 + 16.0
        return VehicleState(
            stamp_ns=now,
            boot_id="b",
            sequence=self.ticks,
            speed_m_s=self.car.speed,
            acceleration_m_s2=self.car.acceleration,
            yaw_rate_rad_s=self.car.speed * tan(self.car.angle) / 2.7,
            road_wheel_angle_rad=self.car.angle,
            gear=Gear.DRIVE,
            requested=actuation,
            applied=actuation,
            rules=(),
            speed_cap_m_s=4.17 if self.video_ns < 10**8 else 8.33,
            loop_age_ms=loop_ms,
            command_age_ms=0.0,
        )

    def _status(self, now: int) -> GatewayStatus:
        ready = self.car.mode is Mode.REMOTE and self.request is None and self.car.station_m > SITE_M
        return gateway_status(
            stamp_ns=now,
            mode=self.car.mode,
            lease_holder=self.car.holder,
            lease_epoch=self.car.epoch,
            hand_over=self.car.hand_over,
            request=self.request,
            hand_back_ready=ready,
        )

    def _scene(self, now: int) -> Scene:
        noise, car = self.car.random.gauss, self.car
        seen = [
            TrackedObject(
                number=thing.number,
                kind=thing.kind,
                x_m=thing.x + noise(0, 0.05),
                y_m=thing.y + noise(0, 0.05),
                velocity_x_m_s=noise(0, 0.1),
                velocity_y_m_s=noise(0, 0.1),
                radius_m=thing.half_m,
                deviation_m=0.1,
                static=True,
                age_s=2.0,
            )
            for thing in self.things
            if hypot(thing.x - car.x, thing.y - car.y) < 40.0
        ]
        if self.walker is not None:
            x, y, heading = self.road.to_world(self.walker.station_m, -self.road.own_side * self.walker.across_m)
            across = self.walker.speed_m_s * self.walker.walks * (self.walker.across_m > -4.8) * self.road.own_side
            seen.append(
                TrackedObject(
                    number=99,
                    kind="person",
                    x_m=x + noise(0, 0.05),
                    y_m=y + noise(0, 0.05),
                    velocity_x_m_s=-across * sin(heading) + noise(0, 0.1),
                    velocity_y_m_s=across * cos(heading) + noise(0, 0.1),
                    radius_m=0.3,
                    deviation_m=0.1,
                    static=not self.walker.walks,
                    age_s=2.0,
                )
            )
        at = self.road.to_road(car.x, car.y)
        return Scene(
            stamp_ns=now,
            x_m=car.x + noise(0, 0.04),
            y_m=car.y + noise(0, 0.04),
            heading_rad=car.heading + noise(0, 0.006),
            speed_m_s=car.speed,
            yaw_rate_rad_s=0.0,
            deviation_m=0.05,
            station_m=at.station_m,
            offset_m=at.offset_m,
            objects=tuple(seen),
            plan=(),
            stopping_corridor=(),
        )

    def _guard(self, scene: Scene) -> None:
        """Whether the car's collision guard would take anything away from the operator who drives."""
        car, command = self.car, self.car.command
        if car.mode is not Mode.REMOTE or command is None:
            return
        here = Odometry(x_m=car.x, y_m=car.y, heading_rad=car.heading)
        limits, motion = GuardLimits(), motion_of(car.speed, command.road_wheel_angle_rad, False, CAR)
        around = keep_surroundings(scene, shift_of(fix_of(scene, here, 0.0, 0.0, scene.stamp_ns)))
        things = things_of(around, here, car.speed, limits)
        seen = watch(things, (car.x, car.y, car.heading), motion, False, False, scene.stamp_ns, CAR, limits)
        self.guarded += sum(bound.acceleration_m_s2 < command.acceleration_m_s2 for bound in seen.bounds)

    def _window(self, now: int) -> WindowStatus:
        if self.car.station_m >= self.freeze_at_m and self.frozen_capture_ns is None:
            self.frozen_capture_ns = now - self.video_ns
        capture = self.frozen_capture_ns or now - self.video_ns
        return WindowStatus(
            stamp_ns=now + HOUR_NS,
            sequence=self.ticks,
            displayed_capture_ns={"front": capture},
            frozen=False,
            shown=(),
            frames_dropped=0,
            scan_out_delay_ms=22.0,
            scan_out_bound_ms=4.0,
        )

    def _measure(self) -> None:
        car = self.car
        station, offset, _ = self.road.to_road(car.x, car.y)
        self.trace.append((station, offset, car.speed, car.mode.value))
        if self.ticks % 4 == 0 and 125.0 < station < 190.0:
            self.closest_m = min([self.closest_m, *(car.gap_to(x, y, 0.2) for thing in self.things for x, y in thing.circles)])
            corners = [
                (car.x + a * cos(car.heading) - b * sin(car.heading), car.y + a * sin(car.heading) + b * cos(car.heading))
                for a in (-0.9, 3.6)
                for b in (-0.88, 0.88)
            ]
            self.kerb_gap_m = min([self.kerb_gap_m, *(3.5 - abs(self.road.to_road(x, y).offset_m) for x, y in corners)])
        if self.walker is not None:
            x, y, _ = self.road.to_world(self.walker.station_m, -self.road.own_side * self.walker.across_m)
            self.person_gap_m = min(self.person_gap_m, car.gap_to(x, y, 0.3))
