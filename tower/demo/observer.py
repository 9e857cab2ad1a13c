"""A link that looks on: connects on a thread of its own, so that whoever waits for a car's hub can do other things meanwhile."""

import threading
from contextlib import suppress

from wire.clock import Clock
from wire.latest import Latest
from wire.link import Stopped, open_link
from wire.messages.sensing import Referee
from wire.messages.vehicle import GatewayStatus
from wire.settings import LinkSettings
from wire.topics import Role


class Observer:
    """Who drives, and what the referee says; None before the first. A context manager."""

    def __init__(self, settings: LinkSettings) -> None:
        self._settings = settings
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="observer", daemon=True)
        self._status: Latest[GatewayStatus] = Latest()
        self._referee: Latest[Referee] = Latest()

    def __enter__(self) -> "Observer":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(timeout=3.0)

    def _run(self) -> None:
        with suppress(Stopped), open_link(self._settings, Role.CAR_OBSERVER, Clock(), self._stop) as link:
            link.on("gateway_status", self._status.put)
            link.on("referee", self._referee.put)
            self._stop.wait()

    @property
    def status(self) -> GatewayStatus | None:
        received = self._status.get()
        return received.message if received else None

    @property
    def referee(self) -> Referee | None:
        received = self._referee.get()
        return received.message if received else None
