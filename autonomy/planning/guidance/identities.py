"""Which class of this cycle is which of the last: equivalent for everybody known to both, though people come and go. Pure.

Three things change the code of one and the same intention, and none of them makes it another. The car passes somebody: a
code counts from where the car is, so what was left becomes non-passing for every class. The horizon reaches someone who
was beyond it, or loses them: non-passing becomes a side, or a side non-passing. And people come and go.
"""

from dataclasses import replace

from autonomy.planning.guidance.line import wrapped
from autonomy.planning.guidance.state import Code, KnownClass
from autonomy.planning.guidance.winding import Side, half_turns

REMEMBERED = 10  # cycles: chance may miss a class for a while
Phases = tuple[tuple[int, float], ...]


def known_now(classes: tuple[KnownClass, ...], before: Phases, now: Phases) -> tuple[KnownClass, ...]:
    """The classes of the last cycle with the codes that they have seen from where the car is now."""
    seen = dict(before)
    passed = {number: turns for number, phase in now if number in seen and (turns := _passed(seen[number], phase))}
    if not passed:
        return classes
    return tuple(
        replace(each, code=tuple((number, _less(side, passed[number]) if number in passed else side) for number, side in each.code))
        for each in classes
    )


def _passed(before_rad: float, now_rad: float) -> int:
    """Half turns that the bearing has gone since, clockwise positive as a code counts."""
    return half_turns(before_rad) - half_turns(before_rad + wrapped(now_rad - before_rad))


def _less(side: Side, passed: int) -> Side:
    return Side(min(max(side - passed, -1), 1))


def name(codes: tuple[Code, ...], known: tuple[KnownClass, ...], next_identity: int) -> tuple[tuple[int, ...], int]:
    """Identities for the codes (best first), and the next new one.

    First to those that agree with a known class; then to those that only do not contradict one of the last cycle.
    """
    names: dict[int, int] = {}
    fresh = tuple(each for each in known if each.missed == 0)
    for candidates, most in ((known, 0), (fresh, len(max(codes, key=len, default=())))):
        for place, code in enumerate(codes):
            free = [each for each in candidates if each.identity not in names.values()]
            fits = [(unlike, each.identity) for each in free if (unlike := _unlike(code, each.code)) is not None and unlike <= most]
            if place not in names and fits:
                names[place] = min(fits, key=lambda fit: fit[0])[1]  # of equals the better one of the last cycle
    for place in range(len(codes)):
        if place not in names:
            names[place], next_identity = next_identity, next_identity + 1
    return tuple(names[place] for place in range(len(codes))), next_identity


def remembered(now: tuple[KnownClass, ...], known: tuple[KnownClass, ...]) -> tuple[KnownClass, ...]:
    """The classes of this cycle, and of the known ones those that were not found but may be again."""
    found = {each.identity for each in now}
    lost = (replace(each, missed=each.missed + 1) for each in known if each.identity not in found)
    return now + tuple(each for each in lost if each.missed <= REMEMBERED)


def _unlike(code: Code, known: Code) -> int | None:
    """For how many of those known to both one passes and the other does not; None when they pass somebody on different sides."""
    sides = dict(known)
    both = [(side, sides[number]) for number, side in code if number in sides]
    if any(one * other < 0 for one, other in both):
        return None
    return sum(one != other for one, other in both)
