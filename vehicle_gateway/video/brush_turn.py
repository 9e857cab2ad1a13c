"""Whose turn it is to draw: one renderer at a time, and the camera the operator drives by before those that only wait beside it."""

import threading
from collections.abc import Iterator
from contextlib import contextmanager


class Brush:
    """A lock with two ranks. Never fair: while an urgent one waits or draws again and again, the others wait."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._taken = False
        self._urgent = 0  # how many of them wait

    @contextmanager
    def held(self, urgent: bool) -> Iterator[None]:
        with self._changed:
            self._urgent += urgent
            try:
                self._changed.wait_for(lambda: not self._taken and (urgent or not self._urgent))
            finally:
                self._urgent -= urgent
            self._taken = True
        try:
            yield
        finally:
            with self._changed:
                self._taken = False
                self._changed.notify_all()
