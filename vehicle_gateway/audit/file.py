"""The append-only file of audit records in the car: one JSON line each, never rewritten, beside the gateway's memory.

A record is handed to the system at once, so that it outlives this process; `sync` makes it outlive a power cut. What was written in
part (a full disk, a power cut) is no record: it is taken off again, and kept beside where it was found at a start.
"""

import os
from pathlib import Path
from typing import NamedTuple

from vehicle_gateway.audit.trail import Trail
from wire.audit_chain import Chain, hash_of
from wire.configuration import ConfigurationError
from wire.messages.audit import AuditEntry, AuditRecord
from wire.messages.base import UNDECODABLE, decoder, encode

LAST_BYTES = 1 << 16  # ours: the longest record has 20 kB
_RECORD, _ENTRY = decoder(AuditRecord), decoder(AuditEntry)


class Resumed(NamedTuple):
    """Where the file of the gateway before this one ended."""

    chain: Chain
    trail: Trail
    set_aside: int  # bytes of a record that was not written whole


def audit_file(memory: Path) -> Path:
    """car.audit.jsonl beside car.json."""
    return memory.with_suffix(".audit.jsonl")


def resume(file: Path) -> Resumed:
    """What the next record follows on. Raises ConfigurationError when the file cannot be used, and never changes a whole record."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        set_aside = _set_aside_part(file)
        line = _last_line(file)
    except OSError as error:
        raise ConfigurationError(
            f"{file}: cannot be used: {error.strerror}; choose another place with [vehicle_gateway] memory"
        ) from None
    if not line:
        return Resumed(Chain(), Trail(), set_aside)
    entry, record = _read(file, line)
    trail = Trail(drive=entry.drive, remote=entry.remote, mode=entry.mode, operator=entry.operator)
    return Resumed(Chain(number=entry.number, hash=record.hash), trail, set_aside)


def _read(file: Path, line: bytes) -> tuple[AuditEntry, AuditRecord]:
    try:
        record = _RECORD.decode(line)
        entry = _ENTRY.decode(record.entry)
    except UNDECODABLE as error:
        raise _damaged(file, str(error)) from None
    if hash_of(bytes(record.entry)) != record.hash:
        raise _damaged(file, "its last record was changed")
    return entry, record


def _damaged(file: Path, why: str) -> ConfigurationError:
    return ConfigurationError(
        f"{file}: damaged ({why}); look at it with: recordings audit {file}; then keep it elsewhere: the chain begins anew"
    )


def _last_line(file: Path) -> bytes:
    if not file.exists():
        return b""
    with file.open("rb") as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.seek(max(size - LAST_BYTES, 0))
        lines = stream.read().splitlines()
    return lines[-1] if lines else b""


def _set_aside_part(file: Path) -> int:
    """Move what follows the last whole line into NAME.part. How many bytes that were."""
    if not file.exists():
        return 0
    with file.open("r+b") as stream:
        size = stream.seek(0, os.SEEK_END)
        stream.seek(max(size - LAST_BYTES, 0))
        part = stream.read().rpartition(b"\n")[2]
        if part:
            with file.with_suffix(".part").open("ab") as beside:
                beside.write(part + b"\n")
            stream.truncate(size - len(part))
    return len(part)


class AuditFile:
    """Open for appending; a context manager. Not safe between threads: one thread writes."""

    def __init__(self, file: Path) -> None:
        self._descriptor = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o600)

    def __enter__(self) -> "AuditFile":
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._descriptor)

    def append(self, record: AuditRecord) -> None:
        """The whole record, or nothing of it. Raises OSError."""
        line, before = encode(record) + b"\n", os.fstat(self._descriptor).st_size
        try:
            written = os.write(self._descriptor, line)
            while written < len(line):
                written += os.write(self._descriptor, line[written:])
        except OSError:
            os.ftruncate(self._descriptor, before)
            raise

    def sync(self) -> None:
        """Raises OSError."""
        os.fsync(self._descriptor)
