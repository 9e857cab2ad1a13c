"""What a kind of fault is made of: what has to be there before the instant, what begins it, and what ends it."""

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from enum import StrEnum
from typing import NamedTuple

from benchmarks.warm_rig import WarmRig
from wire.messages.vehicle import Mode


class Fate(StrEnum):
    """What has to become of the car, or of the hand-over."""

    STANDS = "stands"
    GOES_ON = "goes on"
    SAFE = "safe"
    COMMITS = "commits"
    LAPSES = "lapses"


End = Callable[[], None]
Hurt = Callable[[WarmRig], End]


def nothing() -> None:
    """Healed by the rig."""


def always() -> bool:
    return True


class Finding(NamedTuple):
    """What was looked at besides the car's way."""

    holds: bool = True
    text: str = ""


class Armed(NamedTuple):
    hurt: Hurt  # begins it, and gives what ends it
    is_due: Callable[[], bool] = always  # the instant is here
    patience_s: float = 40.0  # until it is, and the operator drives
    mode: Mode = Mode.REMOTE  # who drives then
    found: Callable[[], Finding] = Finding  # asked when the car stands, or the kind's time is over


Arm = Callable[[WarmRig], AbstractContextManager[Armed]]  # what has to be there beforehand; leaving it ends it


def at_once(hurt: Hurt) -> Arm:
    """Nothing has to be there beforehand."""
    return lambda rig: nullcontext(Armed(hurt))
