"""Linux input events as named readings. Pure. Source: linux/input-event-codes.h, Documentation/input/event-codes.rst.

After SYN_DROPPED the kernel has thrown events away: the batch is worthless, and the state has to be asked for instead.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf

EV_SYN, EV_KEY, EV_ABS = 0, 1, 3
SYN_DROPPED = 3
HAT_FIRST, HAT_LAST = 16, 23  # ABS_HAT0X .. ABS_HAT3Y
FF_SPRING, FF_CONSTANT, FF_DAMPER = 0x53, 0x52, 0x55
_SIDES = (("left", "right"), ("up", "down"))  # of a hat's X and Y axis: negative, positive

Event = tuple[int, int, int]  # type, code, value


@dataclass(frozen=True, slots=True)
class Batch:
    readings: tuple[tuple[str, float], ...]
    dropped: bool  # ask the device for its state


def named(events: Iterable[Event]) -> Batch:
    readings: list[tuple[str, float]] = []
    for kind, code, value in events:
        if kind == EV_SYN and code == SYN_DROPPED:
            return Batch((), True)
        if kind == EV_ABS:
            readings += axis(code, value)
        elif kind == EV_KEY and value != 2:  # 2: the kernel repeats a held key
            readings.append((f"button {code}", float(value)))
    return Batch(tuple(readings), False)


def axis(code: int, value: int) -> tuple[tuple[str, float], ...]:
    """The readings of one axis: a hat's axis is two buttons."""
    if not HAT_FIRST <= code <= HAT_LAST:
        return ((f"axis {code}", float(value)),)
    hat, upright = divmod(code - HAT_FIRST, 2)
    negative, positive = _SIDES[upright]
    return (f"hat {hat} {negative}", float(value < 0)), (f"hat {hat} {positive}", float(value > 0))


def resynced(levels: Mapping[str, float], axes: Mapping[int, int], keys: Iterable[int]) -> tuple[tuple[str, float], ...]:
    """Readings that bring `levels` up to the device's state after dropped events.

    axes, keys  the state as the device says. Of an axis that never reported it is not believed: it may be the kernel's first 0.
    """
    down = set(keys)
    found = [reading for code, value in axes.items() for reading in axis(code, value)]
    found = [(name, value) for name, value in found if name in levels]
    buttons = [name for name in levels if name.startswith("button")]
    return (
        *found,
        *((name, float(int(name.removeprefix("button ")) in down)) for name in buttons),
        *((f"button {code}", 1.0) for code in sorted(down) if f"button {code}" not in levels),
    )


def newest_ns(stamps: Iterable[tuple[int, int]]) -> int | None:
    """The newest of (seconds, microseconds) in ns; None of none."""
    newest = max((seconds * 10**9 + micro * 1000 for seconds, micro in stamps), default=-inf)
    return None if newest == -inf else int(newest)
