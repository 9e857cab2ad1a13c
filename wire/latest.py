"""Where library threads leave what they received: one slot for a level, a counted queue for an event."""

from collections import deque
from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Received(Generic[T]):
    message: T
    received_ns: int  # receiver's clock


class Latest(Generic[T]):
    """One slot; the newest wins. Safe between threads: a reference assignment is atomic."""

    __slots__ = ("_slot",)

    def __init__(self) -> None:
        self._slot: Received[T] | None = None

    def put(self, message: T, received_ns: int) -> None:
        self._slot = Received(message, received_ns)

    def get(self) -> Received[T] | None:
        return self._slot

    def age_ns(self, now_ns: int) -> int | None:
        """How long ago the newest arrived; None before the first."""
        slot = self._slot
        return None if slot is None else now_ns - slot.received_ns


class EventQueue(Generic[T]):
    """Every one counts. Bounded: what does not fit is refused and counted, never the older ones replaced."""

    __slots__ = ("_items", "_limit", "refused")

    def __init__(self, limit: int = 1024) -> None:
        self._items: deque[Received[T]] = deque()
        self._limit = limit
        self.refused = 0

    def put(self, message: T, received_ns: int) -> None:
        if len(self._items) >= self._limit:
            self.refused += 1
            return
        self._items.append(Received(message, received_ns))

    def drain(self) -> list[Received[T]]:
        """Everything that arrived since the last call, oldest first."""
        items = []
        while self._items:
            items.append(self._items.popleft())
        return items
