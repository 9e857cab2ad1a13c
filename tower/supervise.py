"""`tower supervise`: who holds which car; take a lease away, let an operator in again, release a car that stopped too often.

It comes with a certificate of its own, to every car directly - or, where cars dial the tower, through the tower's running hub -
and signs what it asks. The car decides: what it refuses is said with its rule. It drives nothing and holds no lease.
"""

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from tower.cockpit.one_car import SILENT_S
from tower.fleet import Fleet, Seen, choices, towards_all, wait_for_all
from wire import certificates
from wire.clock import Clock, tower_clock
from wire.configuration import ConfigurationError, read_sections
from wire.identity import Signer, signer_of
from wire.link import Link, open_link
from wire.messages.session import Supervision, SupervisionReply, SupervisionRequest
from wire.messages.vehicle import GatewayStatus
from wire.settings import LinkSettings, WireSettings
from wire.topics import Role

PATIENCE_S = 5.0
ANSWER_S = 1.0
COLUMNS = ("vehicle", "mode", "operator", "certificate", "stops", "why")


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """What the command line asks for."""

    action: Supervision
    vehicle_id: str
    operator: str = ""
    reason: str = ""
    stop: bool = False


def request_of(order: Order, status: GatewayStatus, now_ns: int) -> SupervisionRequest:
    """The unsigned question, about the lease that the car speaks of now."""
    return SupervisionRequest(
        action=order.action,
        lease_epoch=status.lease_epoch,
        operator=order.operator,
        reason=order.reason,
        stop=order.stop,
        sent_ns=now_ns,
        echoed_vehicle_ns=status.stamp_ns,
        echoed_boot_id=status.boot_id,
    )


def cells(seen: Seen, now_ns: int) -> tuple[str, ...]:
    """One line of the table. now_ns: the clock of the receive stamps."""
    if seen.status is None or not seen.is_here(now_ns):
        return (seen.vehicle_id, "not there", "", "", "", "")
    status = seen.status.message
    return (
        seen.vehicle_id,
        status.mode.replace("_", " "),
        _holder(status),
        f"{status.lease_certificate} {status.lease_fingerprint[:16]}".strip(),
        str(status.stops_in_ten_minutes),
        "; ".join(text for text in (status.cause if status.lease_holder else "", status.lease_note) if text) or status.cause,
    )


def _holder(status: GatewayStatus) -> str:
    """Whoever is silent for so long keeps the lease until another asks for it."""
    after = f", {status.succession.operator} is next" if status.succession.operator else ""
    silent = f", silent {status.lease_silent_s:.0f} s" if status.lease_silent_s >= SILENT_S else ""
    return f"{status.lease_holder}{silent}{after}" if status.lease_holder else "nobody"


def table(cars: list[Seen], now_ns: int) -> Table:
    drawn = Table(*COLUMNS, box=None, pad_edge=False)
    for car in cars:
        drawn.add_row(*cells(car, now_ns))
    return drawn


@contextmanager
def supervising(settings: LinkSettings, clock: Clock, stop: threading.Event) -> Iterator[Link]:
    """A link to every car: dialled by ourselves, or as a guest of the hub that the cars dial."""
    if settings.listen:
        with open_link(settings, Role.TOWER_SUPERVISOR, clock, stop) as link:
            yield link
    else:
        with open_link(towards_all(settings), Role.TOWER_SUPERVISOR, clock, stop, hub=True, waits=False) as link:
            yield link


def look(config: Path, stop: threading.Event) -> int:
    """The cars and who holds them. 0 when one is there."""
    settings, clock = _read(config)
    with supervising(settings, clock, stop) as link:
        cars, now_ns = wait_for_all(Fleet(link, choices(settings)), clock, stop, PATIENCE_S), clock.now_ns()
        Console(highlight=False, soft_wrap=True).print(table(cars, now_ns))
        return 0 if any(car.is_here(now_ns) for car in cars) else 1


def give(config: Path, stop: threading.Event, order: Order) -> int:
    """Ask the car for what the supervisor orders, and say what came of it. 0 when the car obeyed."""
    settings, clock = _read(config)
    if order.vehicle_id not in choices(settings):
        raise ConfigurationError(f"no car {order.vehicle_id} in [[wire.link.fleet]]; there are: {', '.join(choices(settings))}")
    signer = signer_of(certificates.folder_of(settings.certificates), Role.TOWER_SUPERVISOR)
    say = Console(highlight=False, soft_wrap=True).print
    with supervising(settings, clock, stop) as link:
        reply = asked(link, order, signer, clock, stop)
    if reply is None:
        say(f"{order.vehicle_id} does not answer")
    else:
        say(f"{order.vehicle_id}: {'done' if reply.done else f'refused: {reply.rule}'}")
    return 0 if reply is not None and reply.done else 1


def asked(link: Link, order: Order, signer: Signer, clock: Clock, stop: threading.Event) -> SupervisionReply | None:
    """The car's answer; None when it was not heard, or gave none. Asked once: whoever got no answer looks first."""
    car = Fleet(link, (order.vehicle_id,))
    seen = wait_for_all(car, clock, stop, PATIENCE_S)[0]
    if seen.status is None or not seen.is_here(clock.now_ns()):
        return None
    question = signer.sign(request_of(order, seen.status.message, clock.now_ns()))
    reply = link.of(order.vehicle_id).ask("supervision", question, ANSWER_S)
    return reply if isinstance(reply, SupervisionReply) else None


def _read(config: Path) -> tuple[LinkSettings, Clock]:
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    certificates.ensure(certificates.folder_of(wire.link.certificates))
    return wire.link, tower_clock(wire.clock)
