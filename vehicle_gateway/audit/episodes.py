"""What lasts over many cycles is told twice: when it begins, at once, and when it has been quiet for a while. Pure.

A rule that limits the steering for a second acts in two hundred cycles; the audit trail gets a begin and an end with the number of
cycles, the time from the first to the last, and the command that was changed most. The same serves causes of the failsafe and
questions that are asked and refused again and again.
"""

from typing import NamedTuple

import msgspec

from wire.messages.audit import AuditKind
from wire.messages.base import Count, Message, Name, Text, TimeNs
from wire.messages.vehicle import Actuation

QUIET_NS = 500_000_000  # ours: two episodes closer than this are one, so that what flutters does not fill the disk
ASKED_AGAIN_NS = 3_000_000_000  # ours: a cockpit without a lease asks once a second
OPEN_MAX = 64  # ours: at once; there are a dozen rules and causes, and nobody asks under so many names
END_OF = {
    AuditKind.INTERVENTION: AuditKind.INTERVENTION_END,
    AuditKind.FAILSAFE: AuditKind.FAILSAFE_END,
    AuditKind.REFUSAL: AuditKind.REFUSAL_END,
}
ANGLE_AS_MUCH_AS_1_M_S2_RAD = 0.1  # ours: to compare changes of steering with changes of acceleration


class Seen(NamedTuple):
    """One of these was there in this cycle."""

    kind: AuditKind  # a key of END_OF
    subject: str
    text: str = ""
    operator: str = ""
    question: int = 0
    requested: Actuation | None = None
    applied: Actuation | None = None


class Episode(Message):
    kind: AuditKind
    subject: Name
    text: Text
    operator: Name
    question: Count  # of the first
    first_ns: TimeNs
    last_ns: TimeNs
    times: Count
    requested: Actuation | None  # where they differed most
    applied: Actuation | None

    @property
    def lasted_s(self) -> float:
        return (self.last_ns - self.first_ns) / 1e9


Episodes = tuple[Episode, ...]  # open ones, oldest first


def follow_up(open_: Episodes, seen: tuple[Seen, ...], now_ns: int) -> tuple[Episodes, Episodes, Episodes]:
    """Those that are open after this cycle, those that began in it, those that are over."""
    over = tuple(each for each in open_ if now_ns - each.last_ns > quiet_ns(each.kind) and not _is_among(each, seen))
    kept = {_key(each): each for each in open_ if each not in over}
    begun = []
    for one in seen:
        known = kept.get(_key(one))
        if known is not None:
            kept[_key(one)] = _again(known, one, now_ns)
        elif len(kept) < OPEN_MAX:
            kept[_key(one)] = _first(one, now_ns)
            begun.append(kept[_key(one)])
    return tuple(kept.values()), tuple(begun), over


def quiet_ns(kind: AuditKind) -> int:
    return ASKED_AGAIN_NS if kind is AuditKind.REFUSAL else QUIET_NS


def _key(each: Seen | Episode) -> tuple[str, ...]:
    return (each.kind, each.subject, each.operator, each.text if each.kind is AuditKind.REFUSAL else "")


def _is_among(episode: Episode, seen: tuple[Seen, ...]) -> bool:
    return any(_key(one) == _key(episode) for one in seen)


def _first(one: Seen, now_ns: int) -> Episode:
    return Episode(**one._asdict(), first_ns=now_ns, last_ns=now_ns, times=1)


def _again(known: Episode, one: Seen, now_ns: int) -> Episode:
    worse = _change(one.requested, one.applied) > _change(known.requested, known.applied)
    worst = one if worse else known
    return msgspec.structs.replace(known, last_ns=now_ns, times=known.times + 1, requested=worst.requested, applied=worst.applied)


def _change(requested: Actuation | None, applied: Actuation | None) -> float:
    """How much was changed, steering and acceleration on one scale."""
    if requested is None or applied is None:
        return 0.0
    angle = abs(requested.road_wheel_angle_rad - applied.road_wheel_angle_rad) / ANGLE_AS_MUCH_AS_1_M_S2_RAD
    return max(angle, abs(requested.acceleration_m_s2 - applied.acceleration_m_s2))
