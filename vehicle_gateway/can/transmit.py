"""What this car's gateway may put on its bus: identifier, length, protection and least period of every frame. Pure.

The list is made of the very layouts that the codec packs with, read from the car's DBC; there is no second table. Whatever
else asks to be sent - a foreign identifier, a wrong length, a CRC that does not fit, a flood - is refused and told why.

The period holds in the mean, two frames of slack apart. A cycle that was late in sending may be followed at once by the
next one: that is jitter, and refusing the newest command for it would make the car wait. Every frame beyond that is a
program gone wrong: it would fill the bus, and limits that hold per frame would no longer hold per second.
Source of the rule: the real-time check of opendbc's safety/lateral.h, which counts frames in windows of 250 ms (1.2 times the
cycle's share, and one). Ours has no windows (generic cell rate algorithm, ITU-T I.371): it also bounds a burst at their seam.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple, Protocol

from msgspec.structs import replace

from vehicle_gateway.can.frame import Frame
from wire.messages.base import Message

SLACK = 2  # periods: one for a late cycle, one for a frame sent on the early side of its slot (vehicle_gateway.can.cyclic)
NOT_LISTED, LENGTH, PROTECTION, TOO_SOON = "not on the list", "wrong length", "wrong protection", "too soon"


class Permit(NamedTuple):
    """One frame that may be sent."""

    name: str
    size: int  # bytes
    protection: str
    least_period_ns: int
    is_intact: Callable[[Frame], bool]


class Sendable(Protocol):
    """A layout of either kind (vehicle_gateway.can.layout, toyota_layout)."""

    @property
    def name(self) -> str: ...
    @property
    def arbitration_id(self) -> int: ...
    @property
    def size(self) -> int: ...
    @property
    def protection(self) -> str: ...
    @property
    def least_period_ms(self) -> int: ...
    def is_intact(self, frame: Frame) -> bool: ...


class Sending(Message):
    """What has been sent so far."""

    earliest_ns: dict[int, int] = {}  # the next frame's slot, by identifier


def permits_of(layouts: Iterable[Sendable]) -> dict[int, Permit]:
    """The list, by identifier."""
    return {
        each.arbitration_id: Permit(each.name, each.size, each.protection, each.least_period_ms * 1_000_000, each.is_intact)
        for each in layouts
    }


def admit(state: Sending, frame: Frame, now_ns: int, permits: Mapping[int, Permit]) -> tuple[Sending, str]:
    """The state after asking to send a frame, and why it must not be sent ("" when it may). What is refused takes no slot."""
    permit = permits.get(frame.arbitration_id)
    if permit is None:
        return state, NOT_LISTED
    if len(frame.data) != permit.size:
        return state, LENGTH
    if not permit.is_intact(frame):
        return state, PROTECTION
    slot_ns = max(state.earliest_ns.get(frame.arbitration_id, now_ns), now_ns)
    if slot_ns - now_ns > SLACK * permit.least_period_ns:
        return state, TOO_SOON
    return replace(state, earliest_ns={**state.earliest_ns, frame.arbitration_id: slot_ns + permit.least_period_ns}), ""
