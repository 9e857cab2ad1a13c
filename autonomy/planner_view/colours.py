"""Which colour a guidance class has: its own, for as long as it is there, and never one that another class beside it has. Pure."""

from collections.abc import Iterable

from autonomy.planning.topology import BRAKING, UNGUIDED
from wire import planner_colours
from wire.planner_colours import CLASSES, Rgb

OTHERS: dict[int, Rgb] = {UNGUIDED: planner_colours.UNGUIDED, BRAKING: planner_colours.BRAKING}
REMEMBERED = 50  # classes that are gone; a drive has no end of them
Given = dict[int, int]  # identity of a class, its place in CLASSES; the one shown longest ago first


def give(before: Given, shown: Iterable[int]) -> dict[int, int]:
    """With a colour for every class that is shown now; who is new gets the one that was used longest ago."""
    there = list(dict.fromkeys(identity for identity in shown if identity >= 0))
    now: dict[int, int] = {}
    for identity in (each for each in reversed(before) if each in there):  # who was there before comes before who comes back
        if before[identity] not in now.values():
            now[identity] = before[identity]
    for identity in (each for each in there if each not in now):
        now[identity] = _least_used(before, set(now.values()))
    gone = [(identity, place) for identity, place in before.items() if identity not in now]
    return dict(gone[-REMEMBERED:]) | now


def _least_used(before: Given, taken: set[int]) -> int:
    used = list(before.values())
    free = [place for place in range(len(CLASSES)) if place not in taken]
    return min(free, key=lambda place: max((k for k, each in enumerate(used) if each == place), default=-1))


def colour(given: Given, identity: int) -> Rgb:
    return OTHERS[identity] if identity in OTHERS else CLASSES[given[identity]]
