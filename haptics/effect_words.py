"""Effects as the numbers of Linux' `struct ff_effect`, and which of them to upload now: what changed, the newest, not too often.

Every upload waits for the wheel's answer in an unbounded queue of the kernel (73,180 commands are on record), so at most one
upload per call and `uploads_max_1_s` in total; what changed in between is never sent. Pure; haptics.force_feedback decides what.
Source: linux/input.h: coefficients and centre are s16, saturations u16; a constant force's level is s16 along `direction`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from haptics.force_feedback import Abilities, Effects

CONSTANT, SPRING, DAMPER = "constant", "spring", "damper"
LEFT = 0x4000  # direction: level * sin(direction), so that a positive level turns left; 0 would be no torque at all
STEPS = 0x7FFF
# An upload is worth it from this change on; half a per cent of the wheel's torque is not felt.
_WORTH = {CONSTANT: (160,), SPRING: (320, 320, 64), DAMPER: (320,)}
Words = tuple[int, ...]


def words(wanted: Effects, can: Abilities, sign: int) -> dict[str, Words]:
    """Numbers by effect, of those the wheel has: constant (level), spring (coefficient, saturation, centre), damper (coefficient).

    sign  of the wheel: -1 for one whose constant force pulls the other way
    """
    found: dict[str, Words] = {}
    if can.constant:
        found[CONSTANT] = (_word(wanted.constant * sign, STEPS),)
    if can.spring:
        # the wheel's own position grows to the right
        found[SPRING] = (_word(wanted.spring, STEPS), _word(wanted.spring_max, 0xFFFF), _word(-wanted.centre, STEPS))
    if can.damper:
        found[DAMPER] = (_word(wanted.damper, STEPS),)
    return found


def _word(value: float, full: int) -> int:
    return min(max(round(value * full), -STEPS), full)


@dataclass(frozen=True, slots=True)
class Uploads:
    sent: Mapping[str, Words] = field(default_factory=dict)  # what the wheel renders now
    at_ns: Mapping[str, int] = field(default_factory=dict)  # when each was uploaded
    last_ns: int | None = None  # the last upload of any


def due(state: Uploads, wanted: Mapping[str, Words], now_ns: int, uploads_max_1_s: float) -> tuple[Uploads, str | None]:
    """(state, the one effect to upload now or None). Of several that changed, the one that has waited longest."""
    if state.last_ns is not None and now_ns - state.last_ns < 1e9 / uploads_max_1_s:
        return state, None
    changed = [name for name, value in wanted.items() if _is_worth_it(name, state.sent.get(name), value)]
    if not changed:
        return state, None
    name = min(changed, key=lambda each: (state.at_ns.get(each, -1), each))
    return Uploads({**state.sent, name: wanted[name]}, {**state.at_ns, name: now_ns}, now_ns), name


def _is_worth_it(name: str, sent: Words | None, wanted: Words) -> bool:
    if sent is None:
        return True
    if sent == wanted:
        return False
    ends = not any(wanted) or any((before == 0) != (after == 0) for before, after in zip(sent, wanted, strict=True))
    steps = zip(sent, wanted, _WORTH[name], strict=True)
    return ends or any(abs(before - after) >= worth for before, after, worth in steps)
