"""Repair a truncated or damaged recording, or join the parts of one drive: every complete message into a new file.

Reads record by record until the file breaks off; a damaged chunk inside is left out and counted. The originals are
never changed. Joined are parts of one vehicle, in the order of their first message. Source: mcap.dev/spec and our
measurements of killed recorders (what was flushed survives: benchmarks/recorder.py).
"""

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any

from mcap.records import Attachment, Channel, Chunk, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import CompressionType, Writer

from recordings.errors import DAMAGE, RecordingError
from wire.software import PACKAGE

_RECORD_MAX_BYTES = 1 << 28  # 256 MB: a length beyond it is damage (some writers leave 2^64-1 behind)


@dataclass(slots=True)
class Part:
    """What was found in one file."""

    path: Path
    broken: str = ""  # why it ends early; "" when it has its end
    damaged_chunks: int = 0
    vehicle_id: str = ""
    first_log_ns: int | None = None
    schemas: dict[int, Schema] = field(default_factory=dict)
    channels: dict[int, Channel] = field(default_factory=dict)
    counts: Counter[int] = field(default_factory=Counter)  # complete messages by number of the channel

    @property
    def whole(self) -> bool:
        return not self.broken and not self.damaged_chunks

    @property
    def messages(self) -> int:
        """Complete messages of channels that are known (a damaged chunk may have held a channel's description)."""
        return sum(count for number, count in self.counts.items() if number in self.channels)

    def take(self, record: Any) -> None:
        if isinstance(record, Schema):
            self.schemas[record.id] = record
        elif isinstance(record, Channel):
            self.channels[record.id] = record
        elif isinstance(record, Message):
            self.counts[record.channel_id] += 1
            self.first_log_ns = record.log_time if self.first_log_ns is None else self.first_log_ns
        elif isinstance(record, Metadata) and record.name == "drive":
            self.vehicle_id = record.metadata.get("vehicle_id", "")


@dataclass(slots=True)
class _Copy:
    """The new file: numbers of schemas and channels are its own."""

    mcap: Any
    schemas: dict[tuple[str, str, bytes], int] = field(default_factory=dict)
    channels: dict[tuple[Any, ...], int] = field(default_factory=dict)
    notes: set[tuple[Any, ...]] = field(default_factory=set)  # metadata and attachments that are there already

    def schema(self, schema: Schema | None) -> int:
        if schema is None:
            return 0
        key = (schema.name, schema.encoding, schema.data)
        if key not in self.schemas:
            self.schemas[key] = self.mcap.register_schema(*key)
        return self.schemas[key]

    def channel(self, channel: Channel, schema: Schema | None) -> int:
        number = self.schema(schema)
        key = (channel.topic, channel.message_encoding, number, *sorted(channel.metadata.items()))
        if key not in self.channels:
            self.channels[key] = self.mcap.register_channel(channel.topic, channel.message_encoding, number, channel.metadata)
        return self.channels[key]

    def note(self, record: Metadata | Attachment) -> None:
        """Metadata or an attachment, unless an earlier part brought the same."""
        if isinstance(record, Metadata):
            key: tuple[Any, ...] = (record.name, *sorted(record.metadata.items()))
        else:
            key = (record.name, record.data)
        if key in self.notes:
            return
        self.notes.add(key)
        if isinstance(record, Metadata):
            self.mcap.add_metadata(record.name, record.metadata)
        else:
            self.mcap.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)


def examine(path: Path) -> Part:
    """Read a file from end to end without writing anything. Raises RecordingError when it is no recording at all."""
    part = Part(path)
    for record in _records(part):
        part.take(record)
    if not part.messages and part.broken:
        raise RecordingError(f"{path}: holds no complete message, nothing can be saved: {part.broken}")
    return part


def recover(parts: Sequence[Part], output: Path) -> int:
    """Write every complete message of `parts` into `output`, in the order of their first message. How many that were.

    Raises RecordingError when the parts are of different vehicles or `output` exists or cannot be written.
    """
    vehicles = sorted({part.vehicle_id for part in parts})
    if len(vehicles) > 1:
        raise RecordingError(f"parts of different vehicles ({', '.join(vehicles)}) are not one drive; recover each by itself")
    if output.exists():
        raise RecordingError(f"{output}: exists; name another file with --output")
    unfinished = output.with_name(output.name + ".unfinished")
    try:
        with unfinished.open("wb") as stream:
            messages = _write(sorted(parts, key=lambda part: part.first_log_ns or 0), stream)
        os.replace(unfinished, output)
    except OSError as error:
        with suppress(OSError):
            unfinished.unlink()
        raise RecordingError(f"{output}: cannot be written: {error.strerror}; choose another place with --output") from None
    return messages


def default_output(first: Path) -> Path:
    return first.with_name(f"{first.stem}.recovered.mcap")


def _write(parts: Sequence[Part], stream: IO[bytes]) -> int:
    mcap: Any = Writer(stream, compression=CompressionType.ZSTD)
    mcap.start(profile="", library=PACKAGE)
    copy = _Copy(mcap)
    messages = sum(_copy_part(part, copy) for part in parts)
    mcap.finish()
    return messages


def _copy_part(part: Part, copy: _Copy) -> int:
    """One file into the copy. The channels were found before: those of a damaged chunk may stand at the file's end."""
    numbers = {
        number: copy.channel(channel, part.schemas.get(channel.schema_id)) for number, channel in sorted(part.channels.items())
    }
    for record in _records(Part(part.path)):
        if isinstance(record, Metadata | Attachment):
            copy.note(record)
        elif isinstance(record, Message) and record.channel_id in numbers:
            copy.mcap.add_message(numbers[record.channel_id], record.log_time, record.data, record.publish_time, record.sequence)
    return part.messages


def _records(part: Part) -> Iterator[Any]:
    """Every complete record, chunks opened, until the file ends or breaks off; what went wrong is noted in `part`."""
    try:
        stream = part.path.open("rb")
    except OSError as error:
        raise RecordingError(f"{part.path}: {error.strerror}; name a recording") from None
    with stream:
        reader = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=_RECORD_MAX_BYTES)
        try:
            for record in reader.records:
                yield from _opened(record, part) if isinstance(record, Chunk) else (record,)
        except DAMAGE as error:
            part.broken = f"it breaks off at byte {stream.tell()} ({type(error).__name__})"


def _opened(chunk: Chunk, part: Part) -> list[Any]:
    """The records of a chunk; none when its bytes are not those that were written."""
    try:
        return list(breakup_chunk(chunk, validate_crc=True))
    except DAMAGE:
        part.damaged_chunks += 1
        return []
