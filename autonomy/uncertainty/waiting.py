"""For how long the automation has not got on: it stands for a person, or finds no way among the people. Pure, at every plan.

A loss is over when a way has been there for a second on end: one that is found in every third plan leads nobody out, and what is
told of the loss does not flicker. Only a car that drives itself waits; whoever takes over ends it.
"""

from dataclasses import dataclass

OVER_NS = 1_000_000_000  # ours: ten plans


@dataclass(frozen=True, slots=True, kw_only=True)
class Waiting:
    """None: it does not."""

    stands_since_ns: int | None = None  # for a person, or without a way
    lost_since_ns: int | None = None  # first plan of this loss without a way, standing or not
    lost_at_ns: int | None = None  # last plan without one

    @property
    def is_lost(self) -> bool:
        return self.lost_at_ns is not None

    def stood_s(self, now_ns: int) -> float:
        return _passed_s(self.stands_since_ns, now_ns)

    @property
    def lost_s(self) -> float:
        """From its first to its last plan without a way: it does not grow while a way is there."""
        return 0.0 if self.lost_at_ns is None else _passed_s(self.lost_since_ns, self.lost_at_ns)


def wait_on(before: Waiting, now_ns: int, *, driving: bool, stands: bool, for_person: bool, lost: bool) -> Waiting:
    """After a plan. for_person: one closes the lane. lost: this plan found no way among the people."""
    if not driving:
        return Waiting()
    at = now_ns if lost else before.lost_at_ns
    if at is None or now_ns - at >= OVER_NS:
        at = None
    is_lost = at is not None
    return Waiting(
        stands_since_ns=_since(before.stands_since_ns, stands and (for_person or is_lost), now_ns),
        lost_since_ns=_since(before.lost_since_ns, is_lost, now_ns),
        lost_at_ns=at,
    )


def _since(since_ns: int | None, holds: bool, now_ns: int) -> int | None:
    if not holds:
        return None
    return now_ns if since_ns is None else since_ns


def _passed_s(since_ns: int | None, now_ns: int) -> float:
    return 0.0 if since_ns is None else (now_ns - since_ns) * 1e-9
