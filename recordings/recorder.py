"""The recorder: every recorded topic at the car's hub, into one file, until it is asked to stop.

Callbacks on the link's threads only queue (topic, payload, time of arrival); one thread writes what is queued, and
flushes, once per period. It takes part in nothing: when it dies the drive goes on. A disk that fails ends it with one
clear line.
"""

import logging
import tempfile
import threading
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Protocol

from recordings.provenance import gather
from recordings.settings import RecordingsSettings
from recordings.writer import DriveWriter, open_drive_file, unusable
from wire.clock import car_clock, utc_minus_monotonic_ns
from wire.configuration import read_sections
from wire.latest import EventQueue
from wire.link import open_link
from wire.logs import fields
from wire.messages.base import Message
from wire.notify import NOBODY, Notifier, notifier
from wire.pace import Pace
from wire.settings import WireSettings
from wire.topics import PROGRAMS, TOPICS, Role

_LOG = logging.getLogger(__name__)
_HEALTH_PERIOD_NS = 1_000_000_000  # of car_health, 1 Hz by the topic table
PROCESS = PROGRAMS[Role.RECORDER]
Arrived = tuple[str, bytes]  # topic, payload


class RecordedLink(Protocol):
    """What the recorder needs of the link."""

    @property
    def dropped(self) -> dict[str, int]: ...
    def on_raw(self, name: str, callback: Callable[[str, bytes, int], None]) -> None: ...
    def publish(self, name: str, message: Message | bytes) -> None: ...


class Recorder:
    """Between the link and the file: `write` empties the queue into the file, `health` says what was lost."""

    def __init__(self, link: RecordedLink, drive: DriveWriter, queue_limit: int) -> None:
        self._link = link
        self._drive = drive
        self._arrived: EventQueue[Arrived] = EventQueue(queue_limit)
        self._taken = 0  # of the queue, since the last flush that succeeded
        for topic in TOPICS.values():
            if topic.recorded:
                link.on_raw(topic.name, self._keep)

    def _keep(self, name: str, payload: bytes, received_ns: int) -> None:
        self._arrived.put((name, payload), received_ns)

    def write(self) -> None:
        """Write and flush everything that has arrived, in the order of arrival. Raises OSError."""
        batch = sorted(self._arrived.drain(), key=lambda item: item.received_ns)
        self._taken = len(batch)
        for item in batch:
            self._drive.add(*item.message, item.received_ns)
        self._drive.flush()
        self._taken = 0

    def dropped(self) -> dict[str, int]:
        """Messages that are not in the file as what they should be, by reason, since start."""
        counts = {
            **self._link.dropped,
            "recorder queue full": self._arrived.refused,
            "not written": self._taken,
            **{f"{topic} undecodable": count for topic, count in self._drive.undecodable.items()},
        }
        return {reason[:64]: count for reason, count in counts.items() if count}


def keep_writing(recorder: Recorder, link: RecordedLink, pace: Pace, manager: Notifier = NOBODY) -> None:
    """Write once per period until asked to stop, then what is left. Raises OSError after saying what was lost.

    manager  of services: told once a second that what came was written
    """
    told_ns: int | None = None
    try:
        for now_ns in pace:
            recorder.write()
            if told_ns is None or now_ns - told_ns >= _HEALTH_PERIOD_NS:
                told_ns = now_ns
                link.publish("car_health", pace.health(PROCESS, "write", recorder.dropped()))
                manager.tell("READY=1", "WATCHDOG=1")
        recorder.write()
    except OSError:
        link.publish("car_health", pace.health(PROCESS, "write", recorder.dropped()))
        raise


def session_folder(folder: str, now: datetime) -> Path:
    """Where a drive leaves its files: as configured, else sessions/<utc time> under the working folder."""
    return Path(folder).expanduser() if folder else Path("sessions") / now.strftime("%Y-%m-%dT%H%M%SZ")


def prepare(folder: Path) -> None:
    """Make the folder and try to write into it, before anything starts. Raises RecordingError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder) as probe:
            probe.write(b"0")
    except OSError as error:
        raise unusable(folder, error) from None


def record(config: Path, stop: threading.Event, finished: Callable[[Path], None]) -> bool:
    """Record until `stop` is set, then call `finished` with the whole file. False when the disk failed (it is logged).

    `finished` runs before the link is closed, because closing it takes seconds when the hub has gone.
    Raises RecordingError for a folder that cannot be written, ConfigurationError, LinkError, Stopped.
    """
    sections: dict[str, Any] = read_sections(config, {"wire": WireSettings, "recordings": RecordingsSettings})
    wire: WireSettings = sections["wire"]
    settings: RecordingsSettings = sections["recordings"]
    folder = session_folder(wire.session.folder, datetime.now(UTC))
    prepare(folder)
    clock = car_clock(wire.clock)
    provenance = gather(config, wire.link.vehicle_id, utc_minus_monotonic_ns())
    with open_link(wire.link, Role.RECORDER, clock, stop) as link:
        path, stream = open_drive_file(folder)
        try:
            drive = DriveWriter(stream, provenance)
            recorder = Recorder(link, drive, settings.queue_limit)
            _LOG.info("recording", extra=fields(file=path, vehicle=wire.link.vehicle_id))
            with notifier() as manager, Pace(settings.flush_period_ms / 1e3, clock, stop) as pace:
                keep_writing(recorder, link, pace, manager)
            drive.close()
        except OSError as error:
            with suppress(OSError):
                stream.close()
            _LOG.error("%s: recording ended: %s; free some space, then: recordings recover %s", path, error.strerror, path)
            return False
        finished(path)
    return True
