"""A level's newest counts: what was repeated or overtaken on its way is refused, so that an old message never looks fresh. Pure.

Messages are ordered by their sender's own stamp, for each camera of a topic by itself. A stream that has been silent for a
second may begin anew with any stamp: its sender was started again, perhaps on a machine whose clock began anew.
"""

from collections.abc import Mapping
from typing import NamedTuple

from wire.messages.base import CAMERAS_MAX, Message

SILENT_NS = 1_000_000_000  # longer than any limit of silence in the gateway: by then the loss has been acted on


class Newest(NamedTuple):
    """The newest message of one stream that was let in."""

    stamp_ns: int  # its sender's clock
    received_ns: int  # receiver's clock


def is_ordered(message_type: type[Message]) -> bool:
    """Whether messages of this type carry what they are ordered by."""
    return "stamp_ns" in message_type.__struct_fields__


def stream_of(message: Message) -> str:
    """Several cameras speak on one topic; each is a stream of its own."""
    return str(getattr(message, "camera", ""))


def has_room(stream: str, newest: Mapping[str, Newest]) -> bool:
    """Whether this stream is known or may still become so: made-up cameras do not fill the memory."""
    return stream in newest or len(newest) < CAMERAS_MAX


def is_old(stamp_ns: int, received_ns: int, newest: Newest | None) -> bool:
    """Whether a message of this stamp is a repetition, or older than what was let in."""
    return newest is not None and stamp_ns <= newest.stamp_ns and received_ns - newest.received_ns < SILENT_NS
