"""The audit records of a recording or of the car's append-only file, as they lie there. Judges nothing, refuses nothing.

What cannot be read as a record is one line with the reason: whoever verifies has to name it.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

from recordings.errors import RecordingError
from recordings.read import MAGIC, open_recording
from wire.messages.audit import AuditEntry, AuditRecord
from wire.messages.base import UNDECODABLE, decoder

_RECORD, _ENTRY = decoder(AuditRecord), decoder(AuditEntry)


class Line(NamedTuple):
    place: str  # "line 17" of the car's file, "message 17" of a recording
    record: AuditRecord | None
    entry: AuditEntry | None
    error: str  # why one of them is None


class Read(NamedTuple):
    """A record that could be read."""

    place: str
    record: AuditRecord
    entry: AuditEntry


def read_lines(path: Path) -> tuple[Line, ...]:
    """Raises RecordingError when there is no such file, or nothing of an audit trail in it."""
    try:
        with path.open("rb") as stream:
            is_recording = stream.read(len(MAGIC)) == MAGIC
        found = _of_recording(path) if is_recording else _of_file(path)
    except OSError as error:
        raise RecordingError(
            f"{path}: {error.strerror}; name a recording (drive.mcap) or a car's audit file (NAME.audit.jsonl)"
        ) from None
    if not any(line.record for line in found):
        raise RecordingError(f"{path}: no audit records in it; name a recording or a car's audit file (NAME.audit.jsonl)")
    return found


def readable(lines: Iterable[Line]) -> tuple[Read, ...]:
    return tuple(Read(line.place, line.record, line.entry) for line in lines if line.record and line.entry)


def _of_recording(path: Path) -> tuple[Line, ...]:
    with open_recording(path) as recording:
        return tuple(line_of(f"message {number}", data) for number, (_, data) in enumerate(recording.raw("audit"), start=1))


def _of_file(path: Path) -> tuple[Line, ...]:
    whole, _, rest = path.read_bytes().rpartition(b"\n")
    lines = [line_of(f"line {number}", data) for number, data in enumerate(whole.split(b"\n") if whole else [], start=1)]
    if rest:
        lines.append(Line(f"line {len(lines) + 1}", None, None, "it ends in the middle of a record: cut off"))
    return tuple(lines)


def line_of(place: str, data: bytes) -> Line:
    try:
        record = _RECORD.decode(data)
    except UNDECODABLE as error:
        return Line(place, None, None, f"no audit record: {error}")
    try:
        return Line(place, record, _ENTRY.decode(record.entry), "")
    except UNDECODABLE as error:
        return Line(place, record, None, f"its entry does not fit this version, or was changed: {error}")
