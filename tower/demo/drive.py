"""`tower drive`: cockpit and window together, looked after, for a car that is already running - here or on another machine.

Which car and where is chosen by the command line over the configuration; the choice is written down in the session's folder
for the programs that it starts.
"""

import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import tomli_w
import typer
from rich.console import Console

from tower.demo.crew import TOWER, crew, utc_folder
from tower.demo.observer import Observer
from tower.fleet import FRESH_NS, Fleet, choices, looking, show, table, towards_one, wait_for_all
from tower.settings import TowerSettings
from tower.window.choosing import choose
from tower.window.screen import has_screen
from wire import certificates
from wire.clock import Clock, tower_clock
from wire.configuration import ConfigurationError, read_sections, read_tables
from wire.latest import Received
from wire.link import LinkError
from wire.messages.vehicle import GatewayStatus, Mode
from wire.reach import obstacle
from wire.settings import LinkSettings, WireSettings
from wire.site import dialled, override, own_hub
from wire.topics import Role
from wire.transport import tls_of

LOOK_S = 0.2
OURS = frozenset({Mode.HANDING_OVER, Mode.REMOTE, Mode.HANDING_BACK, Mode.SAFE_STOP})  # a car in these is not left
FIRST_LOOK_S = 3.0  # until the car has said how it is


@dataclass(frozen=True, slots=True)
class Choice:
    """What the command line chose; empty: as configured."""

    vehicle: str = ""
    connect: tuple[str, ...] = ()
    listen: tuple[str, ...] = ()


def run(config: Path, stop: threading.Event, sessions: Path, choice: Choice) -> int:
    """Until the window is closed or a signal comes. A process that dies is started again."""
    console = Console(highlight=False, soft_wrap=True)
    sections = read_sections(config, {"wire": WireSettings, "tower": TowerSettings})
    wire: WireSettings = sections["wire"]
    clock = tower_clock(wire.clock)
    link = override(wire.link, choice.vehicle, choice.connect, choice.listen)
    certificates.ensure(certificates.folder_of(link.certificates))
    if choice.vehicle or len(choices(link)) < 2 or not has_screen():
        return _drive(config, _take_one(link, clock, stop, console, bool(choice.vehicle)), clock, stop, sessions, console)
    while not stop.is_set():
        console.print(f"choose a car in the window: {', '.join(choices(link))}")
        joined = choose(link, sections["tower"].window, clock, stop, link.vehicle_id)
        if not joined:
            return 0
        link = msgspec.structs.replace(link, vehicle_id=joined)
        code = _drive(config, link, clock, stop, sessions, console)
        if code:
            return code
    return 0


def _drive(config: Path, link: LinkSettings, clock: Clock, stop: threading.Event, sessions: Path, console: Console) -> int:
    """One car, until the window is closed; then until the car is left as it may be left."""
    _look_first(link, clock, stop, console)
    folder = utc_folder(sessions)
    written = write_drive(read_tables(config), link, folder)
    console.print(f"driving {link.vehicle_id}; logs in {folder / 'logs'}")
    operator: str = read_sections(config, {"tower": TowerSettings})["tower"].cockpit.operator
    with Observer(link, Role.TOWER_OBSERVER, clock) as car, crew(TOWER, written, folder) as people:
        while not stop.wait(LOOK_S):
            for ended in people.look_after():
                console.print(f"{ended.name} ended ({ended.how}){': started again' if ended.started_again else ''}")
                if not ended.started_again:
                    if ended.how != "exit 0":
                        return 1
                    _wait_until_left(car, operator, clock, stop, console)
                    return 0
    return 0


def may_be_left(status: Received[GatewayStatus] | None, operator: str, now_ns: int) -> bool:
    """The car was given up by `operator`, and it stands or somebody drives it. One that cannot be heard is on its own anyway."""
    if status is None or now_ns - status.received_ns > FRESH_NS:
        return True
    return status.message.mode not in OURS or status.message.lease_holder not in ("", operator)


def _wait_until_left(car: Observer, operator: str, clock: Clock, stop: threading.Event, console: Console) -> None:
    """The cockpit goes on meanwhile: without a picture on a screen a car that was driven stops by itself."""
    if may_be_left(car.heard, operator, clock.now_ns()):
        return
    console.print("the car was being driven: waiting until it stands")
    while not (stop.wait(LOOK_S) or may_be_left(car.heard, operator, clock.now_ns())):
        pass


def look(config: Path, stop: threading.Event, choice: Choice, patience_s: float, watch: bool) -> int:
    """`tower vehicles`: the cars to choose from, or the one that the command line names."""
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    link = override(wire.link, choice.vehicle, choice.connect, choice.listen)
    certificates.ensure(certificates.folder_of(link.certificates))
    link = towards_one(link) if choice.vehicle else link
    return show(link, tower_clock(wire.clock), stop, patience_s, watch)


def write_drive(tables: dict[str, Any], link: LinkSettings, folder: Path) -> Path:
    """`folder`/drive.toml: the configuration with the chosen car, and this folder as the session's."""
    wire = tables.setdefault("wire", {})
    wire["link"] = msgspec.to_builtins(link)
    wire.setdefault("session", {}).update(folder=str(folder), name=folder.name)
    written = folder / "drive.toml"
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written


def _take_one(link: LinkSettings, clock: Clock, stop: threading.Event, console: Console, named: bool) -> LinkSettings:
    """The car to drive. Where there are several and none is named, the person at the terminal chooses."""
    cars = choices(link)
    if named or link.vehicle_id in cars:
        return link
    if len(cars) > 1:
        with looking(link, clock, stop) as seen:
            console.print(table(wait_for_all(Fleet(seen, cars), clock, stop, FIRST_LOOK_S), clock.now_ns()))
        if not sys.stdin.isatty():
            raise ConfigurationError(f"several cars: choose one with --vehicle: {', '.join(cars)}")
        named_car = typer.prompt("vehicle", type=str)
        if named_car not in cars:
            raise ConfigurationError(f"{named_car}: no such car; choose one of: {', '.join(cars)}")
        return msgspec.structs.replace(link, vehicle_id=named_car)
    return msgspec.structs.replace(link, vehicle_id=cars[0])


def _look_first(link: LinkSettings, clock: Clock, stop: threading.Event, console: Console) -> None:
    """Say how the car is before anything is started. Raises LinkError for what waiting will not mend."""
    places = dialled(link, "tower")
    if not places:
        console.print(f"waiting for {link.vehicle_id} to dial {', '.join(link.listen) or own_hub(link, 'tower')}")
        return
    obstacles = [each for each in (obstacle(tls_of(link, Role.TOWER_HUB), place) for place in places) if each is not None]
    for each in obstacles:
        if each.lasting:
            raise LinkError(each.words)
        console.print(f"{each.words} (waiting for it)")
    if obstacles:
        return
    with looking(towards_one(link), clock, stop) as seen:
        cars = wait_for_all(Fleet(seen, (link.vehicle_id,)), clock, stop, FIRST_LOOK_S)
        console.print(table(cars, clock.now_ns()))
        if not cars[0].is_here(clock.now_ns()) and seen.sites:
            console.print(f"{places[0]} answers, but not as {link.vehicle_id}: is that its vehicle id? name another with --vehicle")
