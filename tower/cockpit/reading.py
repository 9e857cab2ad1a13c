"""What the cockpit reads from the link: one `Latest` per level, gathered into a View once per tick. Owns the subscriptions."""

from collections.abc import Mapping
from typing import Any, Protocol

from haptics.alignment import Phase
from tower.cockpit.devices import View
from wire.latest import Latest, Received
from wire.messages.base import Message
from wire.messages.operating import ClockPong


class CockpitLink(Protocol):
    """What the cockpit needs of wire.link.Link."""

    @property
    def dropped(self) -> Mapping[str, int]: ...

    def level(self, name: str) -> Latest[Any]: ...

    def publish(self, name: str, message: Message) -> None: ...

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None: ...


VIEWED = ("vehicle_state", "gateway_status", "scene", "road_map", "window_status", "operator_input")


class Inbox:
    def __init__(self, link: CockpitLink) -> None:
        self._levels = {name: link.level(name) for name in VIEWED}
        self._description = link.level("vehicle_description")
        self._pong = link.level("clock_pong")
        self._pong_seen: ClockPong | None = None

    def view(self, phase: Phase) -> View:
        newest = {name: level.get() for name, level in self._levels.items()}
        return View(description=self._description.get(), wheel_phase=phase, **newest)

    def new_pong(self) -> Received[ClockPong] | None:
        """The pong that arrived since the last call, if one did."""
        received: Received[ClockPong] | None = self._pong.get()
        if received is None or received.message is self._pong_seen:
            return None
        self._pong_seen = received.message
        return received
