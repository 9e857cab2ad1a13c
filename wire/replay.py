"""What a room says about its replayable steps, so that `recordings replay --check` can run them without importing the room.

A room declares one `Replay` per recorded topic in the packaging entry-point group GROUP. Its functions are pure: they take a
recorded message, run the room's own step on the recorded inputs and give back, as JSON, what was recorded and what came out.
Nothing here reads files, compares or decides.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import msgspec

GROUP = "remote_operation_tower.replay"


class Compared(NamedTuple):
    """One thing that was recorded, and the same thing computed again. Equal bytes are equal values."""

    number: int  # of the step
    name: str  # stands before the path of a field: "" for the outputs, "state" for the state the step started from
    recorded: bytes  # JSON
    replayed: bytes  # JSON


def compared(number: int, name: str, recorded: bytes, replayed: bytes, decode: Callable[[bytes], Any]) -> Compared:
    """What was recorded beside what came out, both with the fields of today: one that came after the recording is at its default.

    decode  of the type that both texts hold; raises msgspec.DecodeError where it does not
    """
    if recorded != replayed:
        recorded = msgspec.json.encode(decode(recorded))
    return Compared(number, name, recorded, replayed)


Step = tuple[Any, tuple[Compared, ...]]  # what the next message goes on from, and what there is to compare


@dataclass(frozen=True, slots=True, kw_only=True)
class Replay:
    """How the steps of one topic are run again. Functions raise msgspec.DecodeError on a message they cannot use."""

    kind: str  # "gateway cycle", in words for the user
    topic: str
    numbers: Callable[[Any], range]  # of the steps in a message, counted without a gap by whoever recorded them
    begin: Callable[[Any], Any | None]  # what the first of them starts from, as the message has it; None: it does not say
    run: Callable[[Any, Any], Step]  # (what the steps start from, message)
