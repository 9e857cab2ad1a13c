"""The [recordings] section: how often the file is flushed, how much may wait to be written."""

from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message


class RecordingsSettings(Message):
    # What arrived within a period is written and flushed at its end: a killed recorder loses a period and a wake-up.
    # The promise is 0.2 s; half of it leaves room for a late wake-up. Measured: benchmarks/recorder.py.
    flush_period_ms: Annotated[int, Meta(ge=10, le=200)] = 100
    # Messages that may wait while the disk stalls: 4096 are about 6 s of a whole drive (about 700 messages per second).
    queue_limit: Annotated[int, Meta(ge=100, le=100_000)] = 4096
