"""Two machines on this one: two network namespaces with an address each, joined by one cable that can be pulled.

Needs root and `ip` (iproute2). Nothing of it is visible outside; leaving the context removes it. The certificates of either
side are made as a user would: exported on one machine, imported on the other.
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tomli_w

from tower.demo.crew import CAR, TOWER, core_of, usable_cores
from wire.clock import Clock, car_clock
from wire.configuration import read_sections, read_tables, shipped
from wire.settings import WireSettings

CAR_ADDRESS, TOWER_ADDRESS = "10.213.0.1", "10.213.0.2"
VEHICLE = "car-1"
HOUR_NS = 3_600_000_000_000
LOOK_S = 0.02
_BIN = Path(sys.executable).parent
_CREW = {member.name: member for member in (*CAR, *TOWER)}
_OTHER_CLOCK = Path(__file__).with_name("other_clock.py")


def missing() -> str:
    """Why there can be no namespaces here, in one line; "" when there can."""
    if shutil.which("ip") is None:
        return "no network namespaces: `ip` is missing (apt-get install iproute2)"
    if os.geteuid() != 0:
        return "no network namespaces: they need root"
    tried = subprocess.run(["ip", "netns", "exec", "none-such", "true"], capture_output=True, text=True, check=False)
    return "no network namespaces: not permitted here" if "not permitted" in tried.stderr else ""


def kept_to_its_core(name: str) -> list[str]:
    """What goes before the command of a program of that name."""
    core = core_of(_CREW[name], usable_cores()) if name in _CREW else ""
    return ["taskset", "-c", core] if core else []


@dataclass(slots=True)
class Program:
    """A running program; its output goes to a file."""

    process: subprocess.Popen[bytes]
    log: Path

    def kill(self) -> None:
        self.process.kill()
        self.process.wait()

    def said(self) -> str:
        return self.log.read_text(errors="replace")


@dataclass(slots=True)
class Machine:
    """One side: its namespace, its folder, its configuration and what runs there."""

    name: str
    address: str
    cable: str
    folder: Path
    config: Path
    running: dict[str, Program] = field(default_factory=dict)
    clock_s: int = 0  # how far its monotonic clock is ahead of ours, for what is started from now on

    def clock(self) -> Clock:
        """Of what is started here, as fast as this; whose hour it is does not matter to anybody outside."""
        wire: WireSettings = read_sections(self.config, {"wire": WireSettings})["wire"]
        return car_clock(wire.clock)

    def command(self, program: str, *arguments: str) -> list[str]:
        clock = [sys.executable, str(_OTHER_CLOCK), str(self.clock_s)] if self.clock_s else []
        return ["ip", "netns", "exec", self.name, *clock, str(_BIN / program), *arguments]

    def ask(self, program: str, *arguments: str, patience_s: float = 30.0) -> subprocess.CompletedProcess[str]:
        """Run a program to its end."""
        configured = (*arguments, "--config", str(self.config))
        return subprocess.run(
            self.command(program, *configured),
            capture_output=True,
            text=True,
            check=False,
            timeout=patience_s,
            stdin=subprocess.DEVNULL,
            cwd=self.folder,
        )

    def start(self, name: str, program: str, *arguments: str, config: Path | None = None) -> Program:
        """config: in place of the machine's. A program of a demo keeps to the core that it has there."""
        log = self.folder / f"{name}.log"
        with log.open("ab") as stream:
            process = subprocess.Popen(
                kept_to_its_core(name) + self.command(program, *arguments, "--config", str(config or self.config)),
                stdout=stream,
                stderr=stream,
                stdin=subprocess.DEVNULL,
                cwd=self.folder,
                env=os.environ | {"SDL_VIDEODRIVER": "dummy", "SDL_AUDIODRIVER": "dummy"},
            )
        self.running[name] = Program(process, log)
        return self.running[name]

    def pull(self) -> None:
        """Pull the cable; the address stays."""
        subprocess.run(["ip", "-n", self.name, "link", "set", self.cable, "down"], check=True)

    def plug(self) -> None:
        subprocess.run(["ip", "-n", self.name, "link", "set", self.cable, "up"], check=True)

    def end_all(self) -> None:
        for program in reversed(self.running.values()):
            program.process.terminate()
        for program in self.running.values():
            with suppress(subprocess.TimeoutExpired):
                program.process.wait(10.0)
            program.process.kill()
            program.process.wait()
        self.running.clear()


@dataclass(frozen=True, slots=True)
class Sites:
    car: Machine
    tower: Machine
    cable: object = None  # what joins them, where it can be told something


Cable = Callable[[Machine, Machine], AbstractContextManager[object]]


@contextmanager
def two_machines(folder: Path, scenario: str = "short.toml", cable: Cable | None = None) -> Iterator[Sites]:
    """Both machines with their certificates, nothing running. The tower's clock is an hour off.

    cable  joins the two; by default a pair of interfaces that can be pulled
    """
    car, tower = (_machine(folder, site, address) for site, address in (("car", CAR_ADDRESS), ("tower", TOWER_ADDRESS)))
    with ExitStack() as stack:
        for machine in (car, tower):
            subprocess.run(["ip", "netns", "add", machine.name], check=True)
            stack.callback(subprocess.run, ["ip", "netns", "del", machine.name], check=False)
        joined = stack.enter_context((cable or _pair)(car, tower))
        _configure(car, scenario)
        _configure(tower, scenario)
        _carry_certificates(folder, car, tower)
        for machine in (car, tower):
            stack.callback(machine.end_all)
        yield Sites(car, tower, joined)


def _machine(folder: Path, site: str, address: str) -> Machine:
    own = folder / site
    own.mkdir()
    return Machine(f"rot-{site}-{os.getpid()}", address, f"rot{site}", own, own / f"{site}.toml")


@contextmanager
def _pair(car: Machine, tower: Machine) -> Iterator[None]:
    """It goes with its namespaces."""
    subprocess.run(
        ["ip", "link", "add", car.cable, "netns", car.name, "type", "veth", "peer", "name", tower.cable, "netns", tower.name],
        check=True,
    )
    for machine in (car, tower):
        subprocess.run(["ip", "-n", machine.name, "addr", "add", f"{machine.address}/24", "dev", machine.cable], check=True)
        for link in ("lo", machine.cable):
            subprocess.run(["ip", "-n", machine.name, "link", "set", link, "up"], check=True)
    yield


def _configure(machine: Machine, scenario: str) -> None:
    tables: dict[str, Any] = read_tables(shipped("simulated.toml"))
    wire = tables["wire"]
    wire["link"].update(certificates=str(machine.folder / "certificates"))
    if machine.address == CAR_ADDRESS:
        wire["link"]["vehicle_id"] = tables["vehicle"]["vehicle_id"] = VEHICLE
        wire["session"] = {"folder": str(machine.folder), "name": machine.folder.name}
        for camera in tables["vehicle"]["cameras"]:  # small pictures: this is about the way between, and both machines are one
            wide, high, rate_hz = (640, 360, 20.0) if camera["required"] else (208, 180, 5.0)
            focal_px = camera["focal_length_px"] * wide / camera["width_px"]
            camera.update(width_px=wide, height_px=high, frame_rate_hz=rate_hz, focal_length_px=focal_px)
        tables["vehicle_gateway"]["memory"] = str(machine.folder / "memory.json")
        tables["vehicle_gateway"]["simulation"]["scenario"] = scenario
    else:
        wire["clock"] = {"tower_offset_ns": HOUR_NS}
    machine.config.write_bytes(tomli_w.dumps(tables).encode())


def _carry_certificates(folder: Path, car: Machine, tower: Machine) -> None:
    """An authority at the office; a bundle to each machine."""
    office = ("--folder", str(folder / "office"))
    for machine, whose in ((car, ("--vehicle", VEHICLE)), (tower, ("--tower",))):
        bundle = str(folder / f"{machine.folder.name}.bundle")
        steps = (
            ("certificates", "export", bundle, *office, *whose, "--host", machine.address, "--simulated"),
            ("certificates", "import", bundle),
        )
        for step in steps:
            done = machine.ask("tower", *step)
            if done.returncode:
                raise RuntimeError(done.stderr)


class Listener:
    """What arrives at a site's hub, heard from outside its namespace. A context manager.

    tower  at the tower's hub, as its observer; else at the car's, as its recorder
    tell   is told every topic, message and when it was received [ns, that site's clock] besides, on a thread
    """

    def __init__(
        self, site: Machine, *topics: str, tower: bool = False, tell: Callable[[str, Any, int], None] = lambda *_: None
    ) -> None:
        self._tell, self._clock = tell, site.clock()
        self.count: Counter[str] = Counter()
        self.newest: dict[str, Any] = {}  # by topic
        self.modes: deque[str] = deque()  # in order, without repetition
        self._heard_ns: dict[str, int] = {}
        self._process = subprocess.Popen(
            site.command("python", "-m", "benchmarks.listen", *(("--tower",) if tower else ()), str(site.config), *topics),
            stdout=subprocess.PIPE,
            cwd=Path(__file__).resolve().parents[1],
        )
        self._thread = threading.Thread(target=self._read, name="listener", daemon=True)

    def __enter__(self) -> "Listener":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.send_signal(signal.SIGTERM)
        try:
            self._process.wait(10.0)
        except subprocess.TimeoutExpired:  # seen once, in the closing of its session: the rig would have stood for ever
            self._process.kill()
            self._process.wait()
        self._thread.join()

    def _read(self) -> None:
        for line in self._process.stdout or ():
            try:
                heard = json.loads(line)
            except ValueError:
                self.count["unreadable"] += 1  # somebody sends junk, as told
                continue
            topic, message = heard["topic"], heard["message"]
            self.count[topic] += 1
            if topic == "gateway_status" and (not self.modes or self.modes[-1] != message["mode"]):
                self.modes.append(message["mode"])
            self.newest[topic] = message
            self._heard_ns[topic] = self._clock.now_ns()
            self._tell(topic, message, heard["received_ns"])

    def silence_s(self, topic: str) -> float:
        """Since something was last heard on a topic, in the time of the site's programs."""
        return (self._clock.now_ns() - self._heard_ns.get(topic, 0)) / 1e9

    @property
    def mode(self) -> str:
        return self.modes[-1] if self.modes else ""

    def wait_until(self, what: str, condition: Callable[[], object], patience_s: float) -> None:
        """Look until `condition` holds. Raises TimeoutError that says what it waited for and what was heard.

        patience_s  in the time of the site's programs
        """
        until_ns = self._clock.now_ns() + round(patience_s * 1e9)
        while not condition():
            if self._clock.now_ns() > until_ns:
                raise TimeoutError(f"{patience_s:g} s passed before: {what}; modes {list(self.modes)}, heard {dict(self.count)}")
            time.sleep(LOOK_S)
