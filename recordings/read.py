"""Read a recording: messages by topic in the types of `wire`, pictures by camera, what it says about itself.

Only whole files are read; a truncated one is refused with the command that repairs it. Never writes. Messages come in
the order of their log_time; log_ns is Unix time, the stamps inside the messages stay on their senders' clocks.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import msgspec
from mcap.reader import make_reader

from recordings import planner_scene
from recordings.compressed_video import decode_video
from recordings.errors import DAMAGE, RecordingError
from recordings.writer import UNDECODABLE, VIDEO, Undecodable
from wire.messages.base import Message, decoder
from wire.picture import EncodedPicture, pack_picture
from wire.software import PACKAGE
from wire.topics import TOPICS

MAGIC = bytes((0x89, 0x4D, 0x43, 0x41, 0x50, 0x30, 0x0D, 0x0A))  # mcap.dev/spec: first and last of every file


class Recording:
    """One whole recording. Every iterator goes through the file once; open it with `open_recording`."""

    def __init__(self, path: Path, stream: IO[bytes]) -> None:
        self.path = path
        self._reader: Any = make_reader(stream, validate_crcs=True)
        summary = self._reader.get_summary()
        if summary is None or summary.statistics is None:
            raise RecordingError(f"{path}: has no index; run: recordings recover {path}")
        self._summary: Any = summary
        self.metadata: dict[str, dict[str, str]] = {record.name: record.metadata for record in self._reader.iter_metadata()}

    @property
    def versions(self) -> dict[str, str]:
        return self.metadata.get("versions", {})

    @property
    def topics(self) -> dict[str, int]:
        """Messages per channel name ("video/front" for a camera), in the order of the names."""
        counts: dict[str, int] = {}
        for number, channel in self._summary.channels.items():
            found = self._summary.statistics.channel_message_counts.get(number, 0)
            counts[channel.topic] = counts.get(channel.topic, 0) + found
        return {name: count for name, count in sorted(counts.items()) if count}

    @property
    def cameras(self) -> tuple[str, ...]:
        return tuple(name.removeprefix(f"{VIDEO}/") for name in self.topics if name.startswith(f"{VIDEO}/"))

    @property
    def span_ns(self) -> tuple[int, int] | None:
        """log_time of the first and the last message; None when there is none."""
        found = self._summary.statistics
        return (found.message_start_time, found.message_end_time) if found.message_count else None

    def attachments(self) -> dict[str, bytes]:
        """Files stored beside the messages: configuration.toml, scenario/..., map/..."""
        return {record.name: record.data for record in self._reader.iter_attachments()}

    def messages(self, topic: str) -> Iterator[tuple[int, Any]]:
        """(log_ns, message) of one topic. Raises RecordingError where one does not decode as this version's type."""
        return ((log_ns, message) for _, log_ns, message in self.rows(topic))

    def rows(self, *topics: str, from_ns: int | None = None, until_ns: int | None = None) -> Iterator[tuple[str, int, Any]]:
        """(topic, log_ns, message) of several topics in one pass through the file, in the order of log_time.

        from_ns, until_ns  log_time of the first and beyond the last that are wanted; the rest of the file is not read
        """
        decode = {topic: _decoder(topic) for topic in topics}
        for _, channel, record in self._records(*topics, from_ns=from_ns, until_ns=until_ns):
            try:
                yield channel.topic, record.log_time, decode[channel.topic](record.data)
            except msgspec.DecodeError as error:
                raise RecordingError(
                    f"{self.path}: a {channel.topic} message does not fit this version: {error}; "
                    f"read it with the version that recorded it ({self._made_by()})"
                ) from None

    def raw(self, topic: str) -> Iterator[tuple[int, bytes]]:
        """(log_ns, payload) of one topic, not decoded: for whoever has to say what is wrong with it."""
        return ((record.log_time, record.data) for _, _, record in self._records(topic))

    def pictures(
        self, camera: str, from_ns: int | None = None, until_ns: int | None = None
    ) -> Iterator[tuple[int, EncodedPicture]]:
        """(log_ns, picture) of one camera, capture_ns on the vehicle clock. A decoder starts at the first IDR."""
        for _, channel, record in self._records(f"{VIDEO}/{camera}", from_ns=from_ns, until_ns=until_ns):
            yield record.log_time, _picture(channel, record)

    def payloads(self, from_ns: int = 0) -> Iterator[tuple[str, int, bytes]]:
        """(topic, log_ns, payload as the recorder received it) of everything from `from_ns` on, in the order of log_time."""
        try:
            for _, channel, record in self._reader.iter_messages(starting_at=from_ns):
                if channel.topic in (UNDECODABLE, planner_scene.TOPIC):  # ours, of no sender
                    continue
                if channel.topic.startswith(f"{VIDEO}/"):
                    yield VIDEO, record.log_time, pack_picture(_picture(channel, record))
                else:
                    yield channel.topic, record.log_time, record.data
        except DAMAGE as error:
            raise _damaged(self.path, error) from None

    def _made_by(self) -> str:
        return self.versions.get("commit") or self.versions.get(PACKAGE) or "not told"

    def _records(self, *topics: str, from_ns: int | None = None, until_ns: int | None = None) -> Iterator[tuple[Any, Any, Any]]:
        try:
            yield from self._reader.iter_messages(topics=topics, starting_at=from_ns, ending_before=until_ns)
        except DAMAGE as error:
            raise _damaged(self.path, error) from None


def _picture(channel: Any, record: Any) -> EncodedPicture:
    return decode_video(record.data, record.sequence, int(channel.metadata["utc_minus_vehicle_ns"]))


def _decoder(topic: str) -> Callable[[bytes], Message]:
    message_type: type[Message] | None = Undecodable if topic == UNDECODABLE else TOPICS[topic].type
    if message_type is None:
        raise ValueError(f"{topic} holds pictures: use pictures(camera)")
    return decoder(message_type).decode


@contextmanager
def open_recording(path: Path) -> Iterator[Recording]:
    """A recording to read; leaving the context closes it. Raises RecordingError, with the command that helps."""
    try:
        stream = path.open("rb")
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}; name a recording, like sessions/.../drive.mcap") from None
    with stream:
        _check_whole(path, stream)
        try:
            recording = Recording(path, stream)
        except DAMAGE as error:
            raise _damaged(path, error) from None
        yield recording


def _damaged(path: Path, error: Exception) -> RecordingError:
    return RecordingError(f"{path}: damaged ({type(error).__name__}: {error}); run: recordings recover {path}")


def _check_whole(path: Path, stream: IO[bytes]) -> None:
    """A whole file begins and ends with the magic of the format."""
    if stream.read(len(MAGIC)) != MAGIC:
        raise RecordingError(f"{path}: not an MCAP recording; name a file that `recordings record` wrote")
    size = stream.seek(0, 2)
    stream.seek(max(size - len(MAGIC), len(MAGIC)))
    if stream.read(len(MAGIC)) != MAGIC:
        raise RecordingError(f"{path}: truncated, its recorder did not finish it; run: recordings recover {path}")
    stream.seek(0)
