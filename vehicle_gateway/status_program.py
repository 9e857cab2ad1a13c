"""`vehicle-gateway status`: look on at the running gateway's hub for a moment and tell what was heard. Changes nothing."""

import sys
import threading
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from vehicle_gateway.status import Heard, Status, rows_of, status_from
from wire.clock import Clock, car_clock
from wire.configuration import read_sections
from wire.latest import EventQueue, Latest
from wire.link import Link, Stopped, open_link
from wire.messages.base import encode
from wire.messages.health import LoopHealth
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import GatewayStatus, VehicleState
from wire.settings import WireSettings
from wire.topics import Role

SILENT = 1  # exit code when no gateway answers
LISTEN_S = 1.3  # every loop tells its health once a second


def run(config: Path, stop: threading.Event, as_json: bool, wait_s: float) -> int:
    """0 when a gateway answered, 1 when none did within `wait_s`. Raises ConfigurationError, LinkError, Stopped."""
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    heard = _hear(wire, stop, wait_s)
    if heard is None:
        print(
            f"no gateway of {wire.link.vehicle_id} answers at {wire.link.car_hub} within {wait_s:g} s; "
            f"start it: vehicle-gateway run --config {config}, or name its configuration with --config",
            file=sys.stderr,
        )
        return SILENT
    status = status_from(heard)
    if as_json:
        sys.stdout.write(encode(status).decode() + "\n")
    else:
        Console(highlight=False, width=None if sys.stdout.isatty() else 200).print(table_of(status))
    return 0


class Ears:
    """What the link's threads leave here."""

    def __init__(self, link: Link) -> None:
        self.answered = threading.Event()
        self.status: Latest[GatewayStatus] = Latest()
        self.state: Latest[VehicleState] = link.level("vehicle_state")
        self.cameras: EventQueue[CameraStatus] = link.events("camera_status")
        self.health: tuple[EventQueue[LoopHealth], ...] = (link.events("car_health"), link.events("tower_health"))
        link.on("gateway_status", self._on_status)

    def _on_status(self, status: GatewayStatus, received_ns: int) -> None:
        self.status.put(status, received_ns)
        self.answered.set()


def _hear(wire: WireSettings, stop: threading.Event, wait_s: float) -> Heard | None:
    """What was heard; None when nobody answered in time. Raises Stopped when a person did not want to wait."""
    clock = car_clock(wire.clock)
    over = threading.Event()

    def patience() -> None:
        stop.wait(wait_s)
        over.set()

    threading.Thread(target=patience, daemon=True).start()
    try:
        with open_link(wire.link, Role.CAR_OBSERVER, clock, over) as link:
            ears = Ears(link)
            while not (ears.answered.wait(0.02) or over.is_set()):
                pass
            return _told(ears, wire.link.vehicle_id, clock, stop) if ears.answered.is_set() else None
    except Stopped:
        if stop.is_set():
            raise
        return None


def _told(ears: Ears, vehicle_id: str, clock: Clock, stop: threading.Event) -> Heard | None:
    stop.wait(LISTEN_S)
    status, state = ears.status.get(), ears.state.get()
    return (
        None
        if status is None
        else Heard(
            vehicle_id=vehicle_id,
            now_ns=clock.now_ns(),
            status=status.message,
            state=state.message if state else None,
            cameras=[each.message for each in ears.cameras.drain()],
            health=[each.message for queue in ears.health for each in queue.drain()],
        )
    )


def table_of(status: Status) -> Table:
    table = Table(title=status.vehicle_id, title_justify="left", show_header=False, box=None, pad_edge=False)
    for name, text, is_well in rows_of(status):
        table.add_row(Text(name), Text(text, "" if is_well else "yellow"))
    return table
