"""What the gateway must not forget when it dies: the epoch, a latched stop, that it was engaged, its recent stops, whom a
supervisor keeps out.

Epochs are reserved in blocks before the first one of a block is used, so that no grant waits for a disk. A latch is written
by a thread of its own, for the same reason, and synced by another: one that follows another closely must not wait for the disk.
Both have the priority of whatever stands beside the gateway's loop: a latch must not wait for a busy machine either.
"""

import os
import queue
import threading
from collections.abc import Callable
from pathlib import Path

import msgspec

from wire.configuration import ConfigurationError
from wire.messages.base import UNDECODABLE, Count, Message, Name, TimeNs, encode

EPOCH_BLOCK = 1_000_000  # epochs reserved at each start: more grants than a lifetime of one process


class Remembered(Message):
    epoch_reserved: Count = 0  # no epoch above this was ever used
    emergency_latched: bool = False
    stop_pressed: bool = False  # in the tower, and not cleared since
    stop_latched: bool = False  # SAFE_STOP or STOPPED: a restarted gateway does not drive off by itself
    engaged: bool = False
    local_driver: bool = False
    stops_utc_ns: tuple[TimeNs, ...] = ()
    barred_utc_ns: dict[Name, TimeNs] = {}  # operators whom a supervisor took the lease from: until when they get none


def default_file(vehicle_id: str) -> Path:
    base = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    return Path(base) / "remote-operation-tower" / f"{vehicle_id}.json"


def recall(file: Path) -> Remembered:
    """What was remembered, with a new block of epochs already reserved on disk. Raises ConfigurationError."""
    try:
        known = msgspec.json.decode(file.read_bytes(), type=Remembered) if file.exists() else Remembered()
        write(file, msgspec.structs.replace(known, epoch_reserved=known.epoch_reserved + EPOCH_BLOCK))
    except UNDECODABLE as error:
        raise ConfigurationError(
            f"{file}: damaged ({error}); the car's epochs are not known: have a supervisor look at "
            "the recordings, then delete the file"
        ) from None
    except OSError as error:
        raise ConfigurationError(f"{file}: cannot be used: {error}; choose another with [vehicle_gateway] memory") from None
    return known


def write(file: Path, remembered: Remembered) -> None:
    """Whole or not at all, also over a power cut: on disk under another name before it takes the old one's place."""
    new = _written(file, remembered)
    _sync(new)
    new.replace(file)
    _sync(file.parent)


def put(file: Path, remembered: Remembered) -> None:
    """Whole or not at all should this process die, which takes microseconds; a power cut needs `sync` after it."""
    _written(file, remembered).replace(file)


def _written(file: Path, remembered: Remembered) -> Path:
    file.parent.mkdir(parents=True, exist_ok=True)
    new = file.with_suffix(".new")
    new.write_bytes(encode(remembered))
    return new


def sync(file: Path) -> None:
    for place in (file, file.parent):
        _sync(place)


def _sync(place: Path) -> None:
    descriptor = os.open(place, os.O_RDONLY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


class Memory:
    """Keeps the newest thing to remember; a context manager that leaves when the last is on disk."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self._queue: queue.SimpleQueue[Remembered | None] = queue.SimpleQueue()
        self._put: queue.SimpleQueue[bool] = queue.SimpleQueue()  # True: something to sync; False: that was all
        self._threads = [threading.Thread(target=run, name="memory", daemon=True) for run in (self._write, self._sync)]
        self.failed = 0

    def __enter__(self) -> "Memory":
        for thread in self._threads:
            thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._queue.put(None)
        for thread in self._threads:
            thread.join(timeout=2.0)

    def keep(self, remembered: Remembered) -> None:
        self._queue.put(remembered)

    def _write(self) -> None:
        while (remembered := self._queue.get()) is not None:
            self._tried(put, self._file, remembered)
            self._put.put(True)
        self._put.put(False)

    def _sync(self) -> None:
        while self._put.get():
            self._tried(sync, self._file)

    def _tried(self, work: Callable[..., None], *arguments: object) -> None:
        try:
            work(*arguments)
        except OSError:
            self.failed += 1
