"""Who gives way when the machine cannot keep up: cameras, the sides first, the required ones last. Pure.

Once a second it is asked whether pictures of a required camera came late or not at all, or a control loop missed deadlines.
After two such seconds all other cameras take fewer pictures, a step for each bad second, down to a third; then the required
ones, down to two thirds; then the others once more, and the required ones to a half. After eight good seconds one step is taken
back. Control loops give nothing: they run at a better priority besides.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from wire.messages.health import LoopHealth
from wire.topics import PROGRAMS, Role

LADDER = (
    (1.0, 1.0),
    (2 / 3, 1.0),
    (1 / 2, 1.0),
    (1 / 3, 1.0),
    (1 / 3, 2 / 3),
    (1 / 6, 2 / 3),
    (1 / 6, 1 / 2),
)  # share of the rate: others, required
CONTROL = frozenset({PROGRAMS[Role.VEHICLE_HUB], PROGRAMS[Role.AUTONOMY]})  # processes whose loops must not wait for a picture
DOWN_AFTER_S, UP_AFTER_S = 2, 8  # down: the first step, then one a second; up: a step that is too much costs late pictures
LATE_NS = 100_000_000  # ours: half of what the car allows between two pictures; a picture ready so long after its capture is late
LATE_SHARE = 0.2  # of the pictures of one second
CONTROL_LATE_SHARE, CONTROL_LATE_LEAST = 0.02, 2  # of the cycles of one second


@dataclass(frozen=True, slots=True)
class Load:
    level: int = 0  # of LADDER
    pressed_s: int = 0
    calm_s: int = 0


def after_a_second(load: Load, pressed: bool) -> Load:
    """pressed: the second that has passed was too much."""
    if pressed:
        pressed_s = load.pressed_s + 1
        return Load(min(load.level + (pressed_s >= DOWN_AFTER_S), len(LADDER) - 1), pressed_s)
    up = load.calm_s + 1 >= UP_AFTER_S
    return Load(max(load.level - 1, 0)) if up else Load(load.level, 0, load.calm_s + 1)


def permitted_hz(nominal_hz: float, required: bool, load: Load) -> float:
    """How many pictures a second a camera may take now."""
    return nominal_hz * LADDER[load.level][1 if required else 0]


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
