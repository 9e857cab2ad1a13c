"""`tower vehicles`: the cars that this tower may see, each with its state, to choose one. It asks nothing and changes nothing."""

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from socket import AF_INET, AF_INET6, SOCK_DGRAM, socket

import msgspec
from rich.console import Console
from rich.live import Live
from rich.table import Table

from wire.clock import Clock
from wire.endpoint import Endpoint
from wire.latest import Latest, Received
from wire.link import Link, LinkError, open_link
from wire.messages.vehicle import GatewayStatus, VehicleState
from wire.settings import LinkSettings
from wire.site import dialled, listened
from wire.topics import Role

FRESH_NS = 1_500_000_000  # the state is told at 20 Hz; older than this the car is not there now
LOOK_S = 0.1
FREE_NS = 3_000_000_000
REFRESH_S = 0.5
COLUMNS = ("vehicle", "mode", "speed", "operator", "asks for")


@dataclass(frozen=True, slots=True)
class Seen:
    """What was last heard of one car."""

    vehicle_id: str
    status: Received[GatewayStatus] | None
    state: Received[VehicleState] | None

    def is_here(self, now_ns: int) -> bool:
        return self.status is not None and now_ns - self.status.received_ns < FRESH_NS


def choices(settings: LinkSettings) -> tuple[str, ...]:
    """The cars to choose from: the fleet, or the one car that is configured."""
    return tuple(car.vehicle_id for car in settings.fleet) or (settings.vehicle_id,)


def towards_all(settings: LinkSettings) -> LinkSettings:
    """Settings of a hub that dials every car there is to choose from."""
    every = [msgspec.structs.replace(settings, vehicle_id=vehicle_id) for vehicle_id in choices(settings)]
    places = dict.fromkeys(str(place) for one in every for place in dialled(one, "tower"))
    return msgspec.structs.replace(settings, connect=tuple(places), dials="car")


def towards_one(settings: LinkSettings) -> LinkSettings:
    """Settings of a hub that dials the chosen car alone."""
    places = tuple(str(place) for place in dialled(settings, "tower"))
    return msgspec.structs.replace(settings, connect=places, dials="car", fleet=())


def cells(seen: Seen, now_ns: int) -> tuple[str, ...]:
    """One line of the table, a text per column. now_ns: the clock of the receive stamps."""
    if seen.status is None or not seen.is_here(now_ns):
        return (seen.vehicle_id, "not there", "", "", "")
    status = seen.status.message
    speed = f"{abs(seen.state.message.speed_m_s) * 3.6:.0f} km/h" if seen.state is not None else ""
    reasons = "; ".join(reason.text for reason in status.request.reasons) if status.request is not None else ""
    asks = f"an operator within {status.budget_remaining_s:.0f} s: {reasons}" if status.request is not None else ""
    return (seen.vehicle_id, status.mode.replace("_", " "), speed, status.lease_holder or "nobody", asks)


def table(cars: list[Seen], now_ns: int) -> Table:
    drawn = Table(*COLUMNS, box=None, pad_edge=False)
    for car in cars:
        drawn.add_row(*cells(car, now_ns))
    return drawn


class Fleet:
    """The newest state of every car; `link` must be one whose hub knows them all."""

    def __init__(self, link: Link, vehicle_ids: tuple[str, ...]) -> None:
        views = {vehicle_id: link.of(vehicle_id) for vehicle_id in vehicle_ids}
        self._statuses: dict[str, Latest[GatewayStatus]] = {name: view.level("gateway_status") for name, view in views.items()}
        self._states: dict[str, Latest[VehicleState]] = {name: view.level("vehicle_state") for name, view in views.items()}
        self._views = views  # kept: Zenoh undeclares what is no longer referenced

    def look(self) -> list[Seen]:
        return [Seen(name, status.get(), self._states[name].get()) for name, status in self._statuses.items()]


@contextmanager
def looking(settings: LinkSettings, clock: Clock, stop: threading.Event) -> Iterator[Link]:
    """A link that sees every car: dialling them all; or where cars dial us, as their hub or as a guest of the running one."""
    everyone = towards_all(settings)
    takes_ports = bool(settings.listen)
    with ExitStack() as stack:
        try:
            link = stack.enter_context(open_link(everyone, Role.TOWER_HUB, clock, stop, hub=True, waits=takes_ports))
        except LinkError:
            if not takes_ports:
                raise
            takes_ports = False
            link = stack.enter_context(open_link(settings, Role.WINDOW, clock, stop))  # a drive is running: its hub knows the cars
        yield link
    if takes_ports:
        _wait_until_free(listened(settings, "tower"), clock)


def _wait_until_free(places: tuple[Endpoint, ...], clock: Clock) -> None:
    """Zenoh holds a port a little longer than its session: whoever listens there next, in another process, would be refused."""
    until_ns = clock.now_ns() + FREE_NS
    for place in places:
        family = AF_INET6 if place.host.startswith("[") else AF_INET
        while clock.now_ns() < until_ns:
            with socket(family, SOCK_DGRAM) as probe, suppress(OSError):
                probe.bind((place.host.strip("[]"), place.port))
                break
            threading.Event().wait(LOOK_S)


def show(link_settings: LinkSettings, clock: Clock, stop: threading.Event, patience_s: float, watch: bool) -> int:
    """Look for `patience_s` (less when all are there), or until stopped, and show the table. 0 when a car is there."""
    console = Console(highlight=False, soft_wrap=True)
    with looking(link_settings, clock, stop) as link:
        fleet = Fleet(link, choices(link_settings))
        if watch:
            with Live(console=console, auto_refresh=False) as live:
                while not stop.wait(REFRESH_S):
                    live.update(table(fleet.look(), clock.now_ns()), refresh=True)
            return 0
        cars = wait_for_all(fleet, clock, stop, patience_s)
        console.print(table(cars, clock.now_ns()))
        return 0 if any(car.is_here(clock.now_ns()) for car in cars) else 1


def wait_for_all(fleet: Fleet, clock: Clock, stop: threading.Event, patience_s: float) -> list[Seen]:
    """What is known when every car was heard, or after `patience_s`."""
    until_ns = clock.now_ns() + round(patience_s * 1e9)
    while True:
        cars, now_ns = fleet.look(), clock.now_ns()
        whole = all(car.is_here(now_ns) and car.state is not None for car in cars)
        if whole or now_ns > until_ns or stop.wait(LOOK_S):
            return cars
