"""Who gives way when the machine cannot keep up: cameras, the sides first, the required ones last. Pure.

Once a second it is asked whether pictures of a required camera came late or not at all (as long as only the others would pay
for it, also of another one), a control loop missed deadlines, or a process without a priority waited long for the processor: what
shows pictures has one (SCHED_FIFO), and would not notice that a recorder, say, gets nothing any more. After two such seconds all
other cameras take fewer pictures, a step for each bad second, down to a third; then the required ones, down to two thirds; then
the others once more; and when that is not enough, the required ones have half the width and height, which costs a driver less
than half the rate would, and at the last half the rate, too. After eight good seconds one step is taken back; a step that then
proves too much is tried again after twice as long. Programs that start cost much and not for long: what was given to them is taken
back after two good seconds a step, until one step proves too much. Control loops give nothing.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

from wire.messages.health import LoopHealth
from wire.topics import PROGRAMS, Role


class Rung(NamedTuple):
    others: float  # share of the rate
    required: float
    halved: bool = False  # the required ones, width and height


Ladder = tuple[Rung, ...]
LADDER: Ladder = (
    Rung(1.0, 1.0),
    Rung(2 / 3, 1.0),
    Rung(1 / 2, 1.0),
    Rung(1 / 3, 1.0),
    Rung(1 / 3, 2 / 3),
    Rung(1 / 6, 2 / 3),
    Rung(1 / 6, 2 / 3, halved=True),
    Rung(1 / 6, 1 / 2, halved=True),
)
# Of a car whose cameras are all required: no step that gives up what there is not.
ALONE = tuple(rung for rung, before in zip(LADDER, (None, *LADDER), strict=False) if before is None or rung[1:] != before[1:])
CONTROL = frozenset({PROGRAMS[Role.VEHICLE_HUB], PROGRAMS[Role.AUTONOMY]})  # processes whose loops must not wait for a picture
DOWN_AFTER_S, UP_AFTER_S = 2, 8  # down: the first step, then one a second; up: a step that is too much costs late pictures
UP_AFTER_START_S = 2  # as long as no step back was too much
START_S = 20  # from our own start: too much in this time says nothing of the steps
UP_AFTER_MAX_S = 64  # of a step that was too much three times
LATE_NS = 70_000_000  # ours: a picture ready so long after its capture is late; a third of what the car allows between two
STARVED_NS = 100_000_000  # ours: a process without a priority (vehicle_gateway.video.bystander) waited for so long
LATE_SHARE = 0.2  # of the pictures of one second
CONTROL_LATE_SHARE, CONTROL_LATE_LEAST = 0.02, 2  # of the cycles of one second


@dataclass(frozen=True, slots=True)
class Load:
    level: int = 0  # of LADDER
    pressed_s: int = 0
    calm_s: int = 0
    patience_s: int = UP_AFTER_START_S  # calm that the next step back takes
    since_back_s: int = UP_AFTER_S  # the last step back was so long ago, or longer: then it holds
    runs_s: int = 0  # since our own start, START_S at most


class Allowance(NamedTuple):
    """What a camera may give now."""

    rate_hz: float
    halved: bool = False  # in width and height


def after_a_second(load: Load, pressed: bool, ladder: Ladder = LADDER) -> Load:
    """pressed: the second that has passed was too much."""
    later = replace(load, since_back_s=min(load.since_back_s + 1, UP_AFTER_S), runs_s=min(load.runs_s + 1, START_S))
    return _pressed(later, len(ladder) - 1) if pressed else _calm(later, load.since_back_s < UP_AFTER_S == later.since_back_s)


def _pressed(load: Load, lowest: int) -> Load:
    load = replace(load, pressed_s=load.pressed_s + 1, calm_s=0)
    if load.pressed_s < DOWN_AFTER_S:
        return load
    load = replace(load, level=min(load.level + 1, lowest))
    if load.since_back_s == UP_AFTER_S or load.runs_s < START_S:
        return load
    return replace(load, patience_s=min(max(2 * load.patience_s, UP_AFTER_S), UP_AFTER_MAX_S), since_back_s=UP_AFTER_S)


def _calm(load: Load, held: bool) -> Load:
    """held: a step back has just proved not to be too much."""
    patience_s = min(load.patience_s, UP_AFTER_S) if held else load.patience_s
    load = replace(load, pressed_s=0, calm_s=load.calm_s + 1, patience_s=patience_s)
    if load.level == 0 or load.calm_s < load.patience_s:
        return load
    return replace(load, level=load.level - 1, calm_s=0, since_back_s=0)


def allowance(nominal_hz: float, required: bool, load: Load, ladder: Ladder = LADDER) -> Allowance:
    """Of a camera with so many pictures a second of its own."""
    rung = ladder[load.level]
    return Allowance(nominal_hz * rung.required, rung.halved) if required else Allowance(nominal_hz * rung.others)


def others_may_give(load: Load, ladder: Ladder = LADDER) -> bool:
    """Whether the next step takes from the other cameras alone: only then do their own late pictures count."""
    here, lower = ladder[load.level], ladder[min(load.level + 1, len(ladder) - 1)]
    return lower.others < here.others and lower[1:] == here[1:]


def is_late(pictures: int, late: int, skipped: int) -> bool:
    """Of one camera and second: whether too many pictures came late or not at all."""
    return late + skipped > LATE_SHARE * max(pictures + skipped, 1)


@dataclass(frozen=True, slots=True)
class ControlLoops:
    """What the control loops have said of themselves: (cycles, late cycles) since their start."""

    told: Mapping[tuple[str, str], tuple[int, int]] = field(default_factory=dict)
    were_late: bool = False  # one of them, in what it told last


def hear(state: ControlLoops, health: LoopHealth) -> ControlLoops:
    """The state after one more report."""
    if health.process not in CONTROL:
        return state
    name = (health.process, health.loop)
    cycles, late = state.told.get(name, (health.cycles, health.late_cycles))
    more, more_late = health.cycles - cycles, health.late_cycles - late
    missed = more_late >= CONTROL_LATE_LEAST and more_late > CONTROL_LATE_SHARE * more
    return ControlLoops({**state.told, name: (health.cycles, health.late_cycles)}, state.were_late or missed)
