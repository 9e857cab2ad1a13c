"""The whole stack in a closed loop: a kinematic car, walking people, a site, noisy sensors, and time that is a number.

The world here is plainer than the simulated car of the vehicle gateway, and independent of it: no tyres, no actuators'
limits but a lag, no occlusion. What it says about the stack is therefore not the simulated world's own opinion.
"""

from dataclasses import dataclass, field
from math import atan2, copysign, cos, hypot, inf, sin, tan
from random import Random

import msgspec

from autonomy.car_shape import car_shape
from autonomy.inputs import Inputs
from autonomy.settings import AutonomySettings
from autonomy.stack import step
from autonomy.state import Setup, StackState, setup_of
from tests.messages import gateway_status
from wire.configuration import read_sections, shipped
from wire.messages.automation import AutonomyStatus, Scene
from wire.messages.sensing import DetectedObject, Gnss, Imu, ObjectList, WheelSpeeds
from wire.messages.vehicle import GatewayStatus, Mode, VehicleDescription
from wire.road import Road
from wire.scenario import Person, Scenario, Start, read_map, read_scenario

CONFIG = shipped("simulated.toml")
TICK_NS = 10_000_000
START_NS = 5_000_000_000  # a clock does not start at 0
PERSON_M = 0.3


@dataclass
class Walker:
    person: Person
    station: float
    offset: float
    towards: int = 1
    started: bool = False

    def walk(self, car_distance_m: float, dt: float) -> None:
        self.started = self.started or car_distance_m <= self.person.starts_when_car_within_m
        if not self.started or self.towards >= len(self.person.way):
            return
        station, offset = self.person.way[self.towards]
        left = hypot(station - self.station, offset - self.offset)
        share = min(self.person.speed_m_s * dt / max(left, 1e-9), 1.0)
        self.station += share * (station - self.station)
        self.offset += share * (offset - self.offset)
        if share == 1.0:
            self.towards += 1
            if self.towards == len(self.person.way) and self.person.returns:
                self.person = msgspec.structs.replace(self.person, way=self.person.way[::-1])
                self.towards = 1


@dataclass
class World:
    """The truth, and what sensors make of it."""

    scenario: Scenario
    road: Road
    seed: int
    false_per_list: float = 0.2
    misses: float = 0.08
    slope_rad: float = 0.0  # uphill; the accelerometer does not feel it
    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    speed: float = 0.0
    angle: float = 0.0
    acceleration: float = 0.0  # of drive and brakes
    felt: float = 0.0  # by the accelerometer
    now_ns: int = START_NS
    walkers: list[Walker] = field(default_factory=list)
    static: list[tuple[str, float, float, float]] = field(default_factory=list)
    closest_m: float = inf
    inputs: Inputs = Inputs()

    def __post_init__(self) -> None:
        self.random = Random(self.seed)
        lane = self.road.own_lane_offset_m
        self.x, self.y, self.heading = self.road.to_world(self.scenario.start.station_m, lane)
        self.speed = self.scenario.start.speed_m_s
        self.walkers = [Walker(person, *person.way[0]) for person in self.scenario.people]
        site, side = self.scenario.site, self.road.own_side
        if site is not None:
            places = [(site.station_m - 8 + 2.7 * i, side * (3.15 - 0.9 * i), "cone") for i in range(3)]
            places += [(site.station_m + 1.5 + 3 * i, side * 0.35, "cone") for i in range(int(site.length_m // 3))]
            places += [(site.station_m + end, side * (0.55 + 0.8 * i), "barrier") for end in (0.0, site.length_m) for i in range(4)]
            self.static = [(kind, *self.road.to_world(s, d)[:2], 0.2 if kind == "cone" else 0.4) for s, d, kind in places]

    @property
    def place(self) -> tuple[float, float]:
        at = self.road.to_road(self.x, self.y)
        return at.station_m, at.offset_m

    def move(self, angle: float, acceleration: float, dt: float) -> None:
        """Steering lag 0.15 s, drive and brake lag 0.1 s, 0.12 m/s2 of rolling resistance, the slope, then the bicycle."""
        self.angle += (angle - self.angle) * dt / 0.15
        self.acceleration += (acceleration - self.acceleration) * dt / 0.1
        before, pull = self.speed, 9.81 * sin(self.slope_rad)
        rolls = before + (max(self.acceleration, 0.0) - pull) * dt
        stopping = (max(-self.acceleration, 0.0) + 0.12) * dt  # brakes and rolling take speed, in whichever direction it is
        self.speed = copysign(max(abs(rolls) - stopping, 0.0), rolls)
        self.felt = (self.speed - before) / dt + pull
        turn = self.speed * tan(self.angle) / 2.7 * dt
        self.x += self.speed * dt * cos(self.heading + turn / 2)
        self.y += self.speed * dt * sin(self.heading + turn / 2)
        self.heading += turn
        self.now_ns += TICK_NS
        if self.now_ns % (4 * TICK_NS) == 0:  # people walk, and contacts are looked for, at 25 Hz: 0.28 m at the limit
            for walker in self.walkers:
                x, y, _ = self.road.to_world(walker.station, walker.offset)
                walker.walk(hypot(x - self.x, y - self.y), 4 * dt)
            self.closest_m = min([self.closest_m, *(self.gap(x, y) - r for _, x, y, r in self.things())])

    def things(self) -> list[tuple[str, float, float, float]]:
        people = [("person", *self.road.to_world(w.station, w.offset)[:2], PERSON_M) for w in self.walkers]
        return [*self.static, *people]

    def in_car(self, x: float, y: float) -> tuple[float, float]:
        c, s, dx, dy = cos(self.heading), sin(self.heading), x - self.x, y - self.y
        return c * dx + s * dy, c * dy - s * dx

    def gap(self, x: float, y: float) -> float:
        """From the car's rectangle (3.6 m ahead, 0.9 m behind the rear axle, 1.76 m wide)."""
        ahead, left = self.in_car(x, y)
        return hypot(max(ahead - 3.6, -0.9 - ahead, 0.0), max(abs(left) - 0.88, 0.0))

    def sense(self, mode: Mode, tick: int) -> Inputs:
        gauss, now = self.random.gauss, self.now_ns
        rate = self.speed * tan(self.angle) / 2.7 + 0.002
        new: dict[str, object] = {
            "imu": Imu(
                stamp_ns=now,
                acceleration_x_m_s2=self.felt + gauss(0.05, 0.05),
                acceleration_y_m_s2=0.0,
                acceleration_z_m_s2=9.81,
                roll_rate_rad_s=0.0,
                pitch_rate_rad_s=0.0,
                yaw_rate_rad_s=gauss(rate, 0.003),
            )
        }
        if tick % 2 == 0:
            new["wheels"] = self._wheels()
            new["gateway"] = status(mode, now)
        if tick % 10 == 0:
            new["gnss"] = Gnss(
                stamp_ns=now,
                x_m=gauss(self.x, 0.06),
                y_m=gauss(self.y, 0.06),
                deviation_m=0.06,
                heading_rad=wrapped(gauss(self.heading, 0.006)),
                heading_deviation_rad=0.006,
            )
        if tick % 10 == 5:
            new["objects"] = self._objects()
        fields = {name: getattr(self.inputs, name) for name in ("imu", "gnss", "wheels", "objects", "gateway")}
        self.inputs = Inputs(**{**fields, **new})
        return self.inputs

    def _wheels(self) -> WheelSpeeds:
        speed = 0.0 if self.speed == 0.0 else self.speed * 1.003 + self.random.gauss(0, 0.03)
        return WheelSpeeds(
            stamp_ns=self.now_ns,
            front_left_m_s=speed,
            front_right_m_s=speed,
            rear_left_m_s=speed,
            rear_right_m_s=speed,
            road_wheel_angle_rad=self.angle,
        )

    def _objects(self) -> ObjectList:
        gauss, found = self.random.gauss, []
        for kind, x, y, radius in self.things():
            ahead, left = self.in_car(x, y)
            distance = hypot(ahead, left)
            if distance < 50.0 and self.random.random() > self.misses:
                sigma = 0.08 + 0.002 * distance
                name = kind if self.random.random() > 0.02 else "unknown"
                found.append(DetectedObject(x_m=gauss(ahead, sigma), y_m=gauss(left, sigma), radius_m=radius, kind=name))
        if self.random.random() < self.false_per_list:
            kind = self.random.choice(("unknown", "person", "cone"))
            found.append(
                DetectedObject(x_m=self.random.uniform(-50, 50), y_m=self.random.uniform(-50, 50), radius_m=0.3, kind=kind)
            )
        self.random.shuffle(found)
        return ObjectList(stamp_ns=self.now_ns, range_m=50.0, objects=tuple(found))


def wrapped(angle: float) -> float:
    return atan2(sin(angle), cos(angle))


def status(mode: Mode, now_ns: int) -> GatewayStatus:
    return gateway_status(stamp_ns=now_ns, mode=mode)


def setup_for(road: Road, planner: str) -> Setup:
    sections = read_sections(CONFIG, {"vehicle": VehicleDescription})
    return setup_of(road, car_shape(sections["vehicle"]), AutonomySettings(planner=planner))


def default_scenario(with_site: bool, map_name: str = "bend.toml") -> tuple[Scenario, Road]:
    """The shipped scenario; on a left-driving map everything stands and walks in the mirror."""
    scenario, _ = read_scenario(shipped("scenarios", "closed_road.toml"))
    road = Road(read_map(shipped("maps", map_name)))
    mirror = -road.own_side
    people = tuple(msgspec.structs.replace(person, way=tuple((s, mirror * d) for s, d in person.way)) for person in scenario.people)
    site = scenario.site if with_site else None
    return msgspec.structs.replace(scenario, site=site, people=people), road


@dataclass
class Drive:
    """What a drive left."""

    time_s: float
    requests: set[int]
    reasons: set[str]
    statuses: list[AutonomyStatus]
    scenes: list[Scene]
    trace: list[tuple[float, float, float, float, float]]  # time, station, offset, speed, commanded acceleration


def drive(world: World, seconds: float, operator: "Operator | HandsBack | None" = None, planner: str = "braking") -> Drive:
    """The automation drives, until the operator (if there is one) takes over."""
    setup, state = setup_for(world.road, planner), StackState()
    made = Drive(0.0, set(), set(), [], [], [])
    angle = acceleration = 0.0
    for tick in range(round(seconds * 100)):
        mode = Mode.AUTONOMOUS if operator is None else operator.mode
        state, outputs = step(state, world.sense(mode, tick), world.now_ns, setup)
        if operator is not None:
            operator.look(outputs.status, world)
        if operator is not None and operator.mode is Mode.REMOTE:
            angle, acceleration = operator.steer(world)
        elif outputs.command is not None:
            angle, acceleration = outputs.command.road_wheel_angle_rad, outputs.command.acceleration_m_s2
        world.move(angle, acceleration, 0.01)
        made.time_s = tick / 100
        if outputs.scene is not None:
            made.scenes.append(outputs.scene)
            made.trace.append((made.time_s, *world.place, world.speed, acceleration))
        if outputs.status is not None:
            made.statuses.append(outputs.status)
            if outputs.status.request is not None:
                made.requests.add(outputs.status.request.number)
                made.reasons |= {reason.channel for reason in outputs.status.request.reasons}
            if outputs.status.goal_reached:
                break
    return made


@dataclass
class Operator:
    """Takes over `answers_s` after the request, drives past the site in the oncoming lane, hands back when offered."""

    answers_s: float
    speed: float = 3.5
    mode: Mode = Mode.AUTONOMOUS
    asked_at: int | None = None
    remote: list[AutonomyStatus] = field(default_factory=list)
    handed_back_at: float | None = None

    def look(self, status: AutonomyStatus | None, world: World) -> None:
        if status is None:
            return
        if self.mode is Mode.REMOTE:
            self.remote.append(status)
            ready = status.healthy and status.state_matched and status.clear_s >= 3.0 and status.drivable_s >= 10.0
            if ready and status.request is None and world.place[0] > 150.0:
                self.mode, self.handed_back_at = Mode.AUTONOMOUS, world.place[0]
        elif status.request is not None and self.handed_back_at is None:
            self.asked_at = self.asked_at or world.now_ns
            if world.now_ns - self.asked_at >= self.answers_s * 1e9:
                self.mode = Mode.REMOTE

    def steer(self, world: World) -> tuple[float, float]:
        """Pure pursuit, 4 m ahead, of a line that leaves the lane before the site and comes back behind it."""
        station, _ = world.place
        ahead = station + 4.0
        beside = min(max((ahead - 132.0) / 8.0, 0.0), 1.0) - min(max((ahead - 174.0) / 10.0, 0.0), 1.0)
        x, y, _ = world.road.to_world(ahead, world.road.own_lane_offset_m * (1.0 - 2.0 * beside))
        along, left = world.in_car(x, y)
        return atan2(2 * 2.7 * left, along**2 + left**2), min(max(self.speed - world.speed, -2.0), 1.0)


@dataclass
class HandsBack:
    """Drives for 0.3 s, wheel and speed held."""

    mode: Mode = Mode.REMOTE

    def look(self, _: AutonomyStatus | None, world: World) -> None:
        self.mode = Mode.REMOTE if world.now_ns < START_NS + 300_000_000 else Mode.AUTONOMOUS

    def steer(self, world: World) -> tuple[float, float]:
        return world.angle, 0.0


def alone_with(people: tuple[Person, ...], seed: int, speed: float = 6.5) -> World:
    scenario, road = default_scenario(with_site=False)
    return World(msgspec.structs.replace(scenario, people=people, start=Start(station_m=20.0, speed_m_s=speed)), road, seed)
