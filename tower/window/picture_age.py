"""Is the picture alive? Pure. A picture is FROZEN by the tower's own clock alone: no NEW capture stamp for 200 ms.

The age in milliseconds uses the clock offset that the cockpit measured; it is a figure for the screen and for LATE, and it
never lifts FROZEN. Limits: architecture.md, "Failsafe".
"""

from dataclasses import dataclass
from enum import StrEnum

FROZEN_AFTER_NS = 200_000_000
SIDE_FROZEN_AFTER_NS = 500_000_000  # ours: of a camera that may lose frame rate, down to 5 Hz, before the driving loop does
LATE_AFTER_NS = 500_000_000  # the car stops by itself beyond it
_RESTART_NS = 10_000_000_000  # ours: a stamp that falls back farther comes from a restarted car, whose clock began anew


class PictureState(StrEnum):
    NONE = "none"  # no picture yet
    LIVE = "live"
    LATE = "late"  # it moves, but what it shows is long past
    FROZEN = "frozen"


@dataclass(frozen=True, slots=True)
class PictureSeen:
    """The newest capture stamp (vehicle clock), and since when the window knows it (tower clock)."""

    capture_ns: int
    new_since_ns: int


def see(previous: PictureSeen | None, capture_ns: int | None, now_ns: int) -> PictureSeen | None:
    """A stamp that is not newer than the last is no new picture, unless the car's clock began anew."""
    if capture_ns is None:
        return previous
    if previous is not None and previous.capture_ns - _RESTART_NS <= capture_ns <= previous.capture_ns:
        return previous
    return PictureSeen(capture_ns, now_ns)


def age_ns(seen: PictureSeen | None, now_ns: int, clock_offset_ns: int | None) -> int | None:
    """Now minus capture, on the vehicle's clock; without a known offset, the time since it arrived. None: no picture."""
    if seen is None:
        return None
    since_arrival = now_ns - seen.new_since_ns
    if clock_offset_ns is None:
        return since_arrival
    return max(now_ns + clock_offset_ns - seen.capture_ns, since_arrival)


def picture_state(
    seen: PictureSeen | None, now_ns: int, clock_offset_ns: int | None, frozen_after_ns: int = FROZEN_AFTER_NS
) -> PictureState:
    age = age_ns(seen, now_ns, clock_offset_ns)
    if seen is None or age is None:
        return PictureState.NONE
    if now_ns - seen.new_since_ns > frozen_after_ns:
        return PictureState.FROZEN
    return PictureState.LATE if clock_offset_ns is not None and age > LATE_AFTER_NS else PictureState.LIVE
