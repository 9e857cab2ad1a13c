"""A link that looks on: connects on a thread of its own, so that whoever waits for a car's hub can do other things meanwhile."""

import threading
from contextlib import suppress
from functools import partial
from typing import TypeVar

from wire.clock import Clock
from wire.latest import Latest, Received
from wire.link import LinkError, Stopped, open_link
from wire.messages.sensing import CameraStatus, Referee
from wire.messages.vehicle import GatewayStatus
from wire.settings import LinkSettings
from wire.topics import Role

T = TypeVar("T")


class Observer:
    """Who drives, and what the referee says; None before the first. `error` says why nothing can be seen. A context manager."""

    def __init__(self, settings: LinkSettings, role: Role = Role.CAR_OBSERVER, clock: Clock | None = None) -> None:
        """role: on which site it looks on; what does not cross the link is not heard at the tower."""
        self._settings, self._role, self._clock = settings, role, clock or Clock()
        self._stop = threading.Event()
        self.error = ""
        self._thread = threading.Thread(target=self._run, name="observer", daemon=True)
        self._status: Latest[GatewayStatus] = Latest()
        self._referee: Latest[Referee] = Latest()
        self._cameras: dict[str, CameraStatus] = {}
        self.news = threading.Event()  # set by every message; whoever waits for it clears it

    def __enter__(self) -> "Observer":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(timeout=3.0)

    def _run(self) -> None:
        try:
            with suppress(Stopped), open_link(self._settings, self._role, self._clock, self._stop) as link:
                link.on("gateway_status", partial(self._heard, self._status))
                link.on("referee", partial(self._heard, self._referee))
                link.on("camera_status", self._heard_camera)
                self._stop.wait()
        except LinkError as error:
            self.error = str(error)

    def _heard_camera(self, status: CameraStatus, received_ns: int) -> None:
        self._cameras[status.camera] = status

    def _heard(self, slot: Latest[T], message: T, received_ns: int) -> None:
        slot.put(message, received_ns)
        self.news.set()

    @property
    def heard(self) -> Received[GatewayStatus] | None:
        """The newest status with the time of its arrival."""
        return self._status.get()

    @property
    def cameras(self) -> tuple[CameraStatus, ...]:
        """What each last said of itself; in the car only."""
        return tuple(self._cameras.values())

    @property
    def status(self) -> GatewayStatus | None:
        return self.heard.message if self.heard else None

    @property
    def referee(self) -> Referee | None:
        received = self._referee.get()
        return received.message if received else None
