"""The recorder between a link (a double written here) and a file, a full disk, and once for real against a hub."""

import io
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest
from mcap.reader import NonSeekingReader

import recordings
from recordings.errors import RecordingError
from recordings.read import open_recording
from recordings.recorder import Recorder, keep_writing, prepare, session_folder
from recordings.recover import examine
from recordings.writer import DriveWriter
from wire import certificates
from wire.clock import Clock
from wire.link import open_link
from wire.messages.base import Message, encode
from wire.messages.health import LoopHealth
from wire.messages.operating import TowerStop
from wire.pace import Pace
from wire.settings import LinkSettings
from wire.topics import TOPICS, Role

ROOT = Path(recordings.__file__).resolve().parents[1]


class OneLink:
    """A link that hands over what a test puts in, on the test's thread."""

    def __init__(self) -> None:
        self.dropped: dict[str, int] = {}
        self.callbacks: dict[str, Callable[[str, bytes, int], None]] = {}
        self.published: list[tuple[str, Message | bytes]] = []

    def on_raw(self, name: str, callback: Callable[[str, bytes, int], None]) -> None:
        self.callbacks[name] = callback

    def publish(self, name: str, message: Message | bytes) -> None:
        self.published.append((name, message))

    def arrive(self, name: str, message: Message, received_ns: int) -> None:
        self.callbacks[name](name, encode(message), received_ns)


class FullDisk(io.BytesIO):
    """Takes `room` bytes, then fails as a full disk does."""

    def __init__(self, room: int) -> None:
        super().__init__()
        self.room = room

    def write(self, data: Any) -> int:
        if self.tell() + len(data) > self.room:
            raise OSError(28, "No space left on device")
        return super().write(data)


def finish(recorder: Recorder, link: OneLink) -> None:
    """The recorder's loop when it is asked to stop: it writes what is left."""
    stop = threading.Event()
    stop.set()
    with Pace(0.1, Clock(), stop) as pace:
        keep_writing(recorder, link, pace)


def arrived(path: Path, topic: str, count: int) -> bool:
    """Wait until that many messages of a topic stand in the growing file, at most 20 s."""
    pause, clock = threading.Event(), Clock()
    end_ns = clock.now_ns() + 20_000_000_000
    while clock.now_ns() < end_ns:
        with suppress(RecordingError):  # nothing complete in it yet
            part = examine(path)
            if count == sum(found for number, found in part.counts.items() if part.channels[number].topic == topic):
                return True
        pause.wait(0.02)
    return False


def test_everything_that_the_table_says_is_recorded_is_subscribed_and_nothing_else(build: Any) -> None:
    link = OneLink()
    Recorder(link, DriveWriter(io.BytesIO(), build.provenance()), 100)
    assert set(link.callbacks) == set(TOPICS) - {"operator_input", "clock_ping", "clock_pong", "world_state", "played_video"}


def test_what_arrived_before_the_stop_is_written_in_the_order_of_arrival(build: Any, tmp_path: Path) -> None:
    link, path = OneLink(), tmp_path / "drive.mcap"
    drive = DriveWriter(path.open("xb"), build.provenance())
    recorder = Recorder(link, drive, 4096)
    for number in (2, 1, 4, 3, 6, 5):  # two library threads, the later one first
        link.arrive("imu", build.imu(number), number)
    finish(recorder, link)
    drive.close()
    with path.open("rb") as stream:
        in_file_order = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert [message.log_time - build.utc_ns for _, _, message in in_file_order] == [1, 2, 3, 4, 5, 6]


def test_what_does_not_fit_the_queue_is_counted_and_told(build: Any) -> None:
    link = OneLink()
    recorder = Recorder(link, DriveWriter(io.BytesIO(), build.provenance()), 100)
    for number in range(130):
        link.arrive("imu", build.imu(number), number)
    recorder.write()
    link.dropped["video too large"] = 2
    assert recorder.dropped() == {"recorder queue full": 30, "video too large": 2}


def test_a_full_disk_ends_the_recording_and_says_how_much_is_lost(build: Any) -> None:
    link = OneLink()
    recorder = Recorder(link, DriveWriter(FullDisk(2000), build.provenance()), 4096)
    for number in range(300):
        link.arrive("imu", build.imu(number * 7919), number)
    with pytest.raises(OSError, match="No space left"):
        finish(recorder, link)
    ((name, told),) = link.published
    assert name == "car_health" and isinstance(told, LoopHealth)
    assert (told.process, told.dropped) == ("recordings record", {"not written": 300})


def test_what_was_written_before_the_disk_was_full_can_be_recovered(build: Any, tmp_path: Path) -> None:
    link, disk = OneLink(), FullDisk(20_000)
    recorder = Recorder(link, DriveWriter(disk, build.provenance()), 4096)
    flushed = 0
    with pytest.raises(OSError, match="No space left"):
        while True:
            link.arrive("imu", build.imu(flushed), flushed)
            recorder.write()
            flushed += 1
    (tmp_path / "drive.mcap").write_bytes(disk.getvalue())
    assert examine(tmp_path / "drive.mcap").messages == flushed > 10


def test_a_session_without_a_folder_is_named_by_its_utc_time() -> None:
    now = datetime(2025, 3, 1, 12, 30, 5, tzinfo=UTC)
    assert session_folder("", now) == Path("sessions/2025-03-01T123005Z")
    assert session_folder("/data/drive 7", now) == Path("/data/drive 7")


def test_an_unusable_folder_is_told_before_anything_starts(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(RecordingError, match="choose another folder"):
        prepare(tmp_path / "file" / "sessions")


def test_a_real_recorder_at_a_real_hub_finishes_its_file_when_asked_to_stop(build: Any, tmp_path: Path) -> None:
    certificates.make(tmp_path / "certificates")
    (tmp_path / "test.toml").write_text(
        f'[wire.link]\ncertificates = "{tmp_path / "certificates"}"\ncar_hub = "127.0.0.1:7493"\n'
        f'[wire.session]\nfolder = "{tmp_path / "session"}"\n'
        '[vehicle_gateway.simulation]\nscenario = "closed_road.toml"\n[autonomy]\nmap = "bend.toml"\n'
    )
    settings = LinkSettings(certificates=str(tmp_path / "certificates"), car_hub="127.0.0.1:7493")
    clock, heard = Clock(), threading.Event()
    with open_link(settings, Role.VEHICLE_HUB, clock, threading.Event(), hub=True) as link:
        link.on("car_health", lambda message, _: heard.set())  # the recorder speaks: it has subscribed
        program = subprocess.Popen(
            [sys.executable, "-m", "recordings.program", "record", "--config", str(tmp_path / "test.toml")],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
        )
        try:
            assert heard.wait(20)
            for number in range(1, 51):
                link.publish("tower_stop", TowerStop(number=number, sent_ns=clock.now_ns(), operator="anna"))
            assert arrived(tmp_path / "session" / "drive.mcap", "tower_stop", 50)
            program.send_signal(signal.SIGTERM)
            assert program.wait(20) == 0
        finally:
            program.kill()
            program.wait()
    assert sorted(path.name for path in (tmp_path / "session").iterdir()) == ["drive.mcap", "summary.json"]
    with open_recording(tmp_path / "session" / "drive.mcap") as recording:
        assert [message.number for _, message in recording.messages("tower_stop")] == list(range(1, 51))
        assert {message.process for _, message in recording.messages("car_health")} == {"recordings record"}
        assert set(recording.attachments()) == {"configuration.toml", "scenario/closed_road.toml", "map/bend.toml"}
        assert {"python", "mcap", "msgspec"} <= set(recording.versions)
