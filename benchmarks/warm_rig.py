"""A car and a tower that stay up while they are hurt again and again: two namespaces, a bad way between them, real programs.

The scripted operator is keen: he takes the car whenever he may and keeps it, on a straight road without a site. After each fault
what was killed is started again, what was stopped goes on, the way is perfect, and the rig waits until he drives at speed. All
cameras and window, half as wide and high: this is about faults, not about how fast this machine draws and encodes.
Needs root, `ip` and /dev/net/tun. The truth is the referee's own log.
"""

import os
import select
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w

from benchmarks.bad_way import BadWay, bad_way
from benchmarks.fault_commands import Arrivals
from benchmarks.rig import RefereeLog, RigError, halved, real_time_factor
from benchmarks.slow_disk import Disk, slow_disk
from benchmarks.two_machines import CAR_ADDRESS, Listener, Machine, Sites, two_machines
from wire.clock import Clock
from wire.configuration import read_tables
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

ZONE_M = 20.0  # length of a no-stop zone
PLACE = f"{CAR_ADDRESS}:7450"
DRIVEN_S = 1.0  # and the operator has had it for so long
STANDSTILL_M_S = 0.05
RECORDER, DISK, MOUNTED = "recorder.toml", "disk", "recorded"  # in the car's folder: its configuration, and where its files lie
NOT_KEEN = "not_keen.toml"  # in the tower's folder: of an operator who lets the car drive itself
STOPS_MAX = 20  # the most that may be configured: of ten minutes; then a rig is made anew
CAR = {
    "simulate": ("vehicle-gateway", "simulate"),
    "ecu": ("vehicle-gateway", "ecu"),
    "watchdog": ("vehicle-gateway", "watchdog"),
    "gateway": ("vehicle-gateway", "run", "--listen", PLACE),
    "recorder": ("recordings", "record"),
    "video": ("vehicle-gateway", "video"),
    "autonomy": ("autonomy", "run"),
}
TOWER = {"cockpit": ("tower", "cockpit"), "window": ("tower", "window")}
SILENT_S = 0.5
TELLS = {"gateway_status": "silent since", "window_status": "no window"}  # at the tower: what its silence means
MAP: dict[str, Any] = {
    "name": "long",
    "start": [0.0, 0.0],
    "start_heading_rad": 0.0,
    "lane_width_m": 3.5,
    "sidewalk_width_m": 2.5,
    "drives_on": "right",
}
START = {"station_m": 10.0}
PATIENT = {"take_reaction_min_s": 0.5, "take_reaction_max_s": 1.0}  # takes the car when it asks him
SCENARIO: dict[str, Any] = {"name": "long road", "map": "long.toml", "seed": 5, "time_limit_s": 3600.0, "start": START}


class Ride(NamedTuple):
    """What a rig drives on, and how."""

    road_m: float
    limit_m_s: float  # of the map
    speed_min_m_s: float  # the fault comes while the car drives at least so fast
    gets_there_s: float = 0.0  # how much longer than to drive at all that takes: 15 km/h for ten seconds, then 0.5 m/s2
    likes: dict[str, float] = {}  # [tower.cockpit.scripted.speed]
    car_max_m_s: float | None = None  # under remote control; None: as it is shipped
    front_alone: bool = False  # no other camera
    zones_m: tuple[float, ...] = ()  # stations at which a no-stop zone begins, in the gateway's map


WARM = Ride(road_m=1500.0, limit_m_s=6.9, speed_min_m_s=2.5)  # some forty faults of 30 m each
# From 30 km/h on, which is the most that the shipped car allows its operator: here a little more, or he would only come near it.
# With the front camera alone: above 200 ms from picture to command the car is slower than that.
ZONED = WARM._replace(zones_m=tuple(range(90, 1400, 90)))
FAST = Ride(4000.0, 9.0, 30.0 / 3.6, 60.0, {"speed_max_m_s": 9.0, "below_cap_m_s": 0.0}, car_max_m_s=8.7, front_alone=True)


@dataclass(slots=True)
class WarmRig:
    sites: Sites
    clock: Clock  # of the drive: its faults last as long as they say on it
    ride: Ride
    way: BadWay
    car: Listener
    tower: Listener  # what the operator's window is told
    disk: Disk  # of the recorder
    log: RefereeLog
    commands: Arrivals  # the operator's, as they came to the car
    hurt_names: set[str] = field(default_factory=set)

    def machine(self, name: str) -> Machine:
        return self.sites.car if name in CAR else self.sites.tower

    def pid(self, name: str) -> int:
        return self.machine(name).running[name].process.pid

    def send(self, name: str, how: signal.Signals) -> None:
        self.hurt_names.add(name)
        os.kill(self.pid(name), how)

    def start(self, name: str, config: str = "") -> None:
        """config: a file in its site's folder in place of the usual one."""
        _start(self.machine(name), name, config)

    def heal(self) -> None:
        """Everything runs, the way is perfect and the disk is quick."""
        self.way.be()
        self.disk.delay_s = 0.0
        for name in self.hurt_names:
            program = self.machine(name).running[name]
            if program.process.poll() is None:
                os.kill(program.process.pid, signal.SIGCONT)
            else:
                self.start(name)
        self.hurt_names.clear()

    def referee(self) -> list[Referee]:
        return self.log.entries()

    def drives(self, speed_min_m_s: float = WARM.speed_min_m_s, mode: Mode = Mode.REMOTE) -> bool:
        """The operator, or who drives in that mode, has been driving for a while, at speed."""
        status, log = self.car.newest.get("gateway_status"), self.referee()
        if status is None or status["mode"] != mode or not log:
            return False
        fresh = self.car.silence_s("gateway_status") < 0.5
        return fresh and status["stamp_ns"] - status["mode_since_ns"] > DRIVEN_S * 1e9 and log[-1].speed_m_s > speed_min_m_s

    def stands(self) -> bool:
        log = self.referee()
        return bool(log) and abs(log[-1].speed_m_s) < STANDSTILL_M_S

    def wait_until(self, what: str, condition: Callable[[], object], patience_s: float) -> None:
        """patience_s: on the drive's clock. Raises RigError."""
        try:
            self.car.wait_until(what, condition, patience_s)
        except TimeoutError as error:
            status = self.car.newest.get("gateway_status") or {}
            raise RigError(f"{error}; cause {status.get('cause')!r}, refused {status.get('take_refused')!r}") from None

    @property
    def left_m(self) -> float:
        log = self.referee()
        return self.ride.road_m - (log[-1].station_m if log else 0.0)

    def worn(self) -> bool:
        """The road or the stops of ten minutes come to their end."""
        status = self.car.newest.get("gateway_status") or {}
        return self.left_m < 120.0 or int(status.get("stops_in_ten_minutes", 0)) >= STOPS_MAX - 1


@contextmanager
def warm_rig(folder: Path, ride: Ride = WARM) -> Iterator[WarmRig]:
    """The rig with everything started; leaving the context ends it."""
    clock = Clock(0, real_time_factor(), time.monotonic_ns())
    cable = partial(_cable, clock=clock)
    with two_machines(folder, str(_world(folder, ride)), cable=cable) as sites, ExitStack() as stack:
        way = sites.cable
        if not isinstance(way, BadWay):
            raise RigError("the rig has no bad way")
        _configure(sites, ride, clock)
        try:
            disk = stack.enter_context(slow_disk(sites.car.folder / DISK, sites.car.folder / MOUNTED))
        except OSError as error:
            raise RigError(f"no slow disk: {error}") from None
        stack.callback(sites.car.end_all)  # the recorder, before its disk goes
        for name in CAR:
            _start(sites.car, name)
        commands = Arrivals()
        car = stack.enter_context(Listener(sites.car, "gateway_status", "vehicle_state", "drive_command", tell=commands.take))
        for name in TOWER:
            _start(sites.tower, name)
        tower = stack.enter_context(Listener(sites.tower, "gateway_status", "window_status", tower=True))
        yield WarmRig(sites, clock, ride, way, car, tower, disk, RefereeLog(sites.car.folder), commands)


def _start(machine: Machine, name: str, config: str = "") -> None:
    own = config or (RECORDER if name == "recorder" else "")
    machine.start(name, *(CAR | TOWER)[name], config=machine.folder / own if own else None)


@contextmanager
def _cable(car: Machine, tower: Machine, clock: Clock) -> Iterator[BadWay]:
    with bad_way((tower.name, f"{tower.address}/24"), (car.name, f"{car.address}/24"), clock) as way:
        yield way


def _world(folder: Path, ride: Ride) -> Path:
    """Map and scenario files."""
    road = {"segments": [{"length_m": ride.road_m}], "speed_limit_m_s": ride.limit_m_s, "goal_station_m": ride.road_m - 10.0}
    zones = [zone_from(station) for station in ride.zones_m]
    for name, content in (("long.toml", MAP | road | {"zones": zones}), ("long_road.toml", SCENARIO)):
        (folder / name).write_bytes(tomli_w.dumps(content).encode())
    return folder / "long_road.toml"


def zone_from(station_m: float) -> dict[str, Any]:
    """A no-stop zone of the gateway's map, from kerb to kerb and both sidewalks (3.5 and 2.5 m a side)."""
    both_lanes = {"right_m": -6.0, "left_m": 6.0}
    return {
        "kind": "no_stop",
        "name": "level crossing",
        "from_station_m": station_m,
        "to_station_m": station_m + ZONE_M,
        **both_lanes,
    }


def _configure(sites: Sites, ride: Ride, clock: Clock) -> None:
    pace = {"real_time_factor": clock.real_time_factor, "slowed_since_ns": clock.slowed_since_ns}
    for machine in (sites.car, sites.tower):
        tables: dict[str, Any] = read_tables(machine.config)
        tables["wire"].setdefault("clock", {}).update(pace)
        if machine is sites.car:
            tables["autonomy"]["map"] = tables["vehicle_gateway"]["map"] = str(machine.folder.parent / "long.toml")
            limits = tables["vehicle_gateway"].setdefault("limits", {})
            limits.setdefault("hand_over", {}).update(stops_max=STOPS_MAX, certificate_left_s=0.0)  # short ones are a kind of fault
            tables["vehicle"]["speed_max_remote_m_s"] = ride.car_max_m_s or tables["vehicle"]["speed_max_remote_m_s"]
            cameras = [each for each in tables["vehicle"]["cameras"] if each["name"] == "front" or not ride.front_alone]
            tables["vehicle"]["cameras"] = [halved(camera) for camera in cameras]
            own = {"folder": str(machine.folder / MOUNTED), "name": machine.folder.name}
            recorder = tables | {"wire": tables["wire"] | {"session": own}}
            (machine.folder / RECORDER).write_bytes(tomli_w.dumps(recorder).encode())
        else:
            tables["wire"]["link"].update(vehicle_id="car-1", connect=[PLACE])
            tables["tower"].setdefault("window", {}).update(width_px=640, height_px=360)
            tables["wire"]["session"] = {"folder": str(machine.folder), "name": machine.folder.name}
            tables["tower"]["cockpit"]["scripted"] = PATIENT | {"speed": ride.likes}
            (machine.folder / NOT_KEEN).write_bytes(tomli_w.dumps(tables).encode())
            tables["tower"]["cockpit"]["scripted"]["keen"] = True
        machine.config.write_bytes(tomli_w.dumps(tables).encode())


def said(rig: WarmRig) -> str:
    """What the tower's hub last told the operator's window, for a table; and whether there was a window, and a hub, at all."""
    status = rig.tower.newest.get("gateway_status") or {}
    gone = [text for topic, text in TELLS.items() if rig.tower.silence_s(topic) > SILENT_S]
    return ", ".join((f"{status.get('mode', 'nothing')}: {status.get('cause', '')}", *gone))


def log_in(machine: Machine, module: str) -> Path:
    """What a module of ours says on standard error."""
    return machine.folder / f"{module}.log"


def run_in(machine: Machine, module: str, *arguments: str, niceness: int = 0) -> "subprocess.Popen[bytes]":
    """A module of ours in a namespace; what it says can be read."""
    return subprocess.Popen(
        ["nice", "-n", str(niceness)] + machine.command("python", "-m", module, *arguments),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=log_in(machine, module).open("ab"),
        cwd=Path(__file__).resolve().parents[1],
    )


def wait_for_line(process: "subprocess.Popen[bytes]", line: str, patience_s: float) -> None:
    """Until it has said this. Raises RigError."""
    says = process.stdout
    if says is None or not select.select([says], [], [], patience_s)[0] or says.readline().decode().strip() != line:
        raise RigError(f"a program of the rig did not say {line!r}")


def pause(rig: WarmRig, seconds: float) -> None:
    """Let the drive go on for a while; looked at, not slept through."""
    until_ns = rig.clock.now_ns() + round(seconds * 1e9)
    rig.wait_until("time passed", lambda: rig.clock.now_ns() >= until_ns, seconds + 5.0)
