"""The seam between a wheel and whoever reads it: evdev in the cockpit, a list of readings in the tests."""

from collections.abc import Mapping
from typing import Protocol

Readings = tuple[tuple[str, float], ...]


class Unplugged(Exception):
    """The device is gone."""


class Source(Protocol):
    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        """(readings since the last call, age of the newest in ns or None when there is none). Never waits. Raises Unplugged.

        levels  what has been read so far: needed when the kernel has dropped events
        """
        ...

    def close(self) -> None: ...
