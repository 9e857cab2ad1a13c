"""What the gateway must not forget when it dies: the epoch, a latched stop, that it was engaged, its recent stops.

Epochs are reserved in blocks before the first one of a block is used, so that no grant waits for a disk. A latch is written
by a thread of its own, for the same reason.
"""

import os
import queue
import threading
from pathlib import Path

import msgspec

from wire.configuration import ConfigurationError
from wire.messages.base import Count, Message, TimeNs, encode

EPOCH_BLOCK = 1_000_000  # epochs reserved at each start: more grants than a lifetime of one process


class Remembered(Message):
    epoch_reserved: Count = 0  # no epoch above this was ever used
    emergency_latched: bool = False
    stop_pressed: bool = False  # in the tower, and not cleared since
    stop_latched: bool = False  # SAFE_STOP or STOPPED: a restarted gateway does not drive off by itself
    engaged: bool = False
    local_driver: bool = False
    stops_utc_ns: tuple[TimeNs, ...] = ()


def default_file(vehicle_id: str) -> Path:
    base = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Path(base) / "remote-operation-tower" / f"{vehicle_id}.json"


def recall(file: Path) -> Remembered:
    """What was remembered, with a new block of epochs already reserved on disk. Raises ConfigurationError."""
    try:
        known = msgspec.json.decode(file.read_bytes(), type=Remembered) if file.exists() else Remembered()
        write(file, msgspec.structs.replace(known, epoch_reserved=known.epoch_reserved + EPOCH_BLOCK))
    except (msgspec.DecodeError, UnicodeDecodeError) as error:
        raise ConfigurationError(
            f"{file}: damaged ({error}); the car's epochs are not known: have a supervisor look at "
            "the recordings, then delete the file"
        ) from None
    except OSError as error:
        raise ConfigurationError(f"{file}: cannot be used: {error}; choose another with [vehicle_gateway] memory") from None
    return known


def write(file: Path, remembered: Remembered) -> None:
    """Whole or not at all. First so that it outlives this process, which takes microseconds; then, synced, a power cut."""
    file.parent.mkdir(parents=True, exist_ok=True)
    new = file.with_suffix(".new")
    new.write_bytes(encode(remembered))
    new.replace(file)
    for place in (file, file.parent):
        _sync(place)


def _sync(place: Path) -> None:
    descriptor = os.open(place, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class Memory:
    """Writes the newest thing to remember on a thread of its own; a context manager that writes the last before it leaves."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._queue: queue.SimpleQueue[Remembered | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._run, name="memory", daemon=True)
        self.failed = 0

    def __enter__(self) -> "Memory":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._queue.put(None)
        self._thread.join(timeout=2.0)

    def keep(self, remembered: Remembered) -> None:
        self._queue.put(remembered)

    def _run(self) -> None:
        while (remembered := self._queue.get()) is not None:
            try:
                write(self._file, remembered)
            except OSError:
                self.failed += 1
