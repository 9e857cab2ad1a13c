"""One slot between the thread that captures and the one that encodes: the newest wins, what was replaced is counted."""

import threading
from typing import Generic, TypeVar

T = TypeVar("T")


class NewestSlot(Generic[T]):
    """Never a queue: a picture that was not fetched in time is gone."""

    def __init__(self) -> None:
        self._filled = threading.Condition()
        self._item: T | None = None
        self.replaced = 0

    def put(self, item: T) -> None:
        with self._filled:
            self.replaced += self._item is not None
            self._item = item
            self._filled.notify()

    def take(self, timeout_s: float) -> T | None:
        """The newest item not fetched before; waits for one up to `timeout_s`, then None."""
        with self._filled:
            if self._item is None:
                self._filled.wait(timeout_s)
            item, self._item = self._item, None
            return item
