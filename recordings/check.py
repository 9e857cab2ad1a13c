"""Recorded steps run again and compared bit for bit: what `recordings replay --check` counts. Pure but for reading.

How a step is run stands in its room (`wire.replay`); the rooms are found by their packaging entry points. A step can be
checked when the one before it was, or when the record says what it started from; what cannot is counted, never passed over.
"""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib.metadata import entry_points
from typing import Any, Protocol

import msgspec

from recordings.differences import difference
from recordings.errors import RecordingError
from wire.replay import GROUP, Compared, Replay

SHOWN = 10  # mismatches of one kind that are told; all are counted


class StepSource(Protocol):
    """What is needed of `recordings.read.Recording`."""

    @property
    def path(self) -> object: ...
    @property
    def topics(self) -> Mapping[str, int]: ...
    def rows(self, *topics: str) -> Iterable[tuple[str, int, Any]]: ...


@dataclass(slots=True)
class Tally:
    """What became of the steps of one kind."""

    kind: str
    checked: int = 0
    differing: int = 0  # of them
    unchecked: int = 0  # recorded, but what they started from is not
    missing: int = 0  # numbers left out between two records of one run
    runs: int = 0  # times the check began from a recorded start
    mismatches: list[str] = field(default_factory=list)
    memory: Any = None  # what the next step starts from; None: not known
    after: int | None = None  # number of the last step recorded

    @property
    def holds(self) -> bool:
        return self.checked > 0 and self.differing == 0


def installed_replays() -> dict[str, Replay]:
    """The replayable steps that the installed rooms declare, by topic. Raises RecordingError when there are none."""
    found = {replay.topic: replay for replay in (entry.load() for entry in entry_points(group=GROUP))}
    if not found:
        raise RecordingError(f"no room declares replayable steps ({GROUP}); install the package again: make setup")
    return found


def check(source: StepSource, replays: Mapping[str, Replay]) -> list[Tally]:
    """Every recorded step run again. Raises RecordingError when the recording holds none."""
    topics = [topic for topic in replays if source.topics.get(topic)]
    if not topics:
        raise RecordingError(f"{source.path}: holds no recorded steps ({', '.join(replays)}); record the drive with this version")
    tallies = {topic: Tally(replays[topic].kind) for topic in topics}
    for topic, _, message in source.rows(*topics):
        follow(tallies[topic], replays[topic], message)
    return list(tallies.values())


def follow(tally: Tally, replay: Replay, message: Any) -> None:
    """One message: run its steps from where the last one ended, or from the start it carries."""
    numbers = replay.numbers(message)
    try:
        if tally.after != numbers.start - 1 or tally.memory is None:
            _begin(tally, replay, message, numbers)
        tally.after = numbers.stop - 1
        if tally.memory is None:
            tally.unchecked += len(numbers)
            return
        tally.memory, compared = replay.run(tally.memory, message)
        lines = list(_mismatches(tally.kind, compared))
    except msgspec.DecodeError as error:
        lines = [f"{tally.kind} {numbers.start}: cannot be replayed: {error}"]
        tally.memory = None
    tally.checked += len(numbers)
    if lines:
        tally.differing += len(lines)
        tally.mismatches += lines[: SHOWN - len(tally.mismatches)]
        tally.memory = None  # the record is believed again from its next start on


def _begin(tally: Tally, replay: Replay, message: Any, numbers: range) -> None:
    if tally.after is not None and numbers.start > tally.after + 1:
        tally.missing += numbers.start - tally.after - 1
    tally.memory = replay.begin(message)
    tally.runs += tally.memory is not None


def _mismatches(kind: str, compared: Iterable[Compared]) -> Iterator[str]:
    """One line per step that differs: its first field."""
    told = 0
    for number, name, recorded, replayed in compared:
        found = difference(recorded, replayed)
        if found is not None and number != told:
            told = number
            path = ".".join(part for part in (name, found.path) if part)
            yield f"{kind} {number}: {path} recorded {found.recorded}, replayed {found.replayed}"
