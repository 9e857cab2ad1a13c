"""When to ask the car for a new video session. Pure.

Ask at once when there is none, when its connection has failed, or when no picture came for 1.5 s although it was given
that long; after every failure wait longer, from 0.5 s to 2 s. A restart of either side heals by this alone.
"""

from dataclasses import dataclass, replace
from enum import Enum, auto

SILENCE_NS = 1_500_000_000  # without a picture for this long the session is given up
_BACK_OFF_FIRST_NS = 500_000_000
_BACK_OFF_MAX_NS = 2_000_000_000


class Step(Enum):
    WAIT = auto()
    ASK = auto()  # drop what there is and ask for a new session


@dataclass(frozen=True, slots=True, kw_only=True)
class Session:
    open: bool = False  # asked and answered
    opened_ns: int = 0
    next_ask_ns: int = 0  # not before
    back_off_ns: int = _BACK_OFF_FIRST_NS


def next_step(session: Session, now_ns: int, newest_picture_ns: int | None, has_failed: bool) -> Step:
    """newest_picture_ns: when the newest picture of any camera was decoded, None: never. The caller's clock."""
    alive_ns = max(session.opened_ns, newest_picture_ns or 0)
    is_lost = not session.open or has_failed or now_ns - alive_ns > SILENCE_NS
    return Step.ASK if is_lost and now_ns >= session.next_ask_ns else Step.WAIT


def asked(session: Session, now_ns: int, answered: bool) -> Session:
    """After an attempt: the next one waits, twice as long each time until a picture comes (see `delivered`)."""
    return replace(
        session,
        open=answered,
        opened_ns=now_ns,
        next_ask_ns=now_ns + session.back_off_ns,
        back_off_ns=min(2 * session.back_off_ns, _BACK_OFF_MAX_NS),
    )


def delivered(session: Session) -> Session:
    """A picture came: the next loss is answered quickly again."""
    return replace(session, back_off_ns=_BACK_OFF_FIRST_NS) if session.back_off_ns != _BACK_OFF_FIRST_NS else session
