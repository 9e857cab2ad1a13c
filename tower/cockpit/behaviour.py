"""What the scripted operator does when: watches, reacts, takes the wheel, drives, hands back, lets go. Pure.

Takes over at a request of the automation, or a car that stands stopped in the middle of its drive, or from another operator when a
supervisor names this one; passes the car on when one names another. A keen one takes it whenever it may and keeps it. Never
presses STOP.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

from haptics.alignment import Phase
from tower.cockpit.devices import Presses
from wire.messages.vehicle import Mode

AGAIN_NS = 1_000_000_000  # a press that came to nothing is tried again after this
SETTLE_NS = 1_000_000_000  # after letting go, until what is seen is the time after it
TAKES_MAX = 3  # the first and two more after safe stops; then a supervisor


class Doing(StrEnum):
    WATCH = "watch"
    REACT = "react"
    TAKE = "take"
    DRIVE = "drive"


@dataclass(frozen=True, slots=True, kw_only=True)
class Situation:
    """As seen on screen, and felt in the hands (phase)."""

    mode: Mode | None  # None: nothing on screen yet
    request_open: bool
    hand_back_ready: bool
    home: bool  # past the trouble, in the own lane
    picture_live: bool
    picture_steady: bool  # live, and without a stutter for a while
    phase: Phase
    reaction_ns: int  # how long it would take now to understand and reach for the wheel
    keen: bool = False  # wants to drive, asked or not
    is_next: bool = False  # a supervisor lets this operator take over from the one who drives
    passes_on: bool = False  # a supervisor lets another one, who is there, take over from this operator, who has not agreed yet
    another_drives: bool = False

    @property
    def tempting(self) -> bool:
        return self.keen and self.mode in (Mode.STANDBY, Mode.AUTONOMOUS, Mode.STOPPED)


@dataclass(frozen=True, slots=True, kw_only=True)
class Behaviour:
    doing: Doing = Doing.WATCH
    since_ns: int = 0
    react_until_ns: int = 0
    pressed_ns: int = 0  # last press of any button
    engaged: bool = False  # the car has driven itself
    requested: bool = False  # the automation asked since it drove undisturbed
    takes: int = 0
    presses: Presses = Presses()

    @property
    def grips(self) -> bool:
        """Whether the dead-man control is held."""
        return self.doing in (Doing.TAKE, Doing.DRIVE)


def step(state: Behaviour, seen: Situation, now_ns: int) -> Behaviour:
    return _TABLE[state.doing](_remembering(state, seen), seen, now_ns)


def _remembering(state: Behaviour, seen: Situation) -> Behaviour:
    if seen.request_open or seen.mode is Mode.TAKEOVER_REQUESTED:
        return replace(state, requested=True)
    if seen.mode is Mode.AUTONOMOUS and state.doing is Doing.WATCH:
        return replace(state, engaged=True, requested=False, takes=0)
    return state


def _go(state: Behaviour, doing: Doing, now_ns: int) -> Behaviour:
    return replace(state, doing=doing, since_ns=now_ns)


def _watch(state: Behaviour, seen: Situation, now_ns: int) -> Behaviour:
    if now_ns - state.since_ns < SETTLE_NS or not seen.picture_live:
        return state
    if seen.mode is Mode.STANDBY and not (state.engaged or seen.keen) and _may_press(state, now_ns):
        return replace(state, presses=replace(state.presses, engage=state.presses.engage + 1), pressed_ns=now_ns)
    stranded = seen.mode is Mode.STOPPED and (state.engaged or state.requested)
    asked = seen.mode is Mode.TAKEOVER_REQUESTED or stranded or seen.is_next
    if seen.tempting or (asked and state.takes < TAKES_MAX):
        return replace(_go(state, Doing.REACT, now_ns), react_until_ns=now_ns + seen.reaction_ns)
    return state


def _react(state: Behaviour, seen: Situation, now_ns: int) -> Behaviour:
    if _is_over(seen):
        return _go(state, Doing.WATCH, now_ns)
    return _go(state, Doing.TAKE, now_ns) if now_ns >= state.react_until_ns else state


def _take(state: Behaviour, seen: Situation, now_ns: int) -> Behaviour:
    if seen.phase is Phase.ACTIVE:
        return replace(_go(state, Doing.DRIVE, now_ns), takes=state.takes + 1)
    if _is_over(seen):
        return _go(state, Doing.WATCH, now_ns)
    # a car that stands can wait for a good picture, one that drives cannot
    good_enough = seen.picture_steady if seen.mode is Mode.STOPPED else seen.picture_live
    if seen.phase is Phase.READY and good_enough and _may_press(state, now_ns):
        return replace(state, presses=replace(state.presses, accept=state.presses.accept + 1), pressed_ns=now_ns)
    return state


def _drive(state: Behaviour, seen: Situation, now_ns: int) -> Behaviour:
    if seen.phase is not Phase.ACTIVE:
        return _go(state, Doing.WATCH, now_ns)  # the wheel lets go: somebody else drives, or nobody
    if seen.passes_on and _may_press(state, now_ns):
        return replace(state, presses=replace(state.presses, accept=state.presses.accept + 1), pressed_ns=now_ns)
    wants_back = seen.hand_back_ready and seen.home and seen.mode is Mode.REMOTE and not seen.keen
    if wants_back and seen.picture_live and _may_press(state, now_ns):
        return replace(state, presses=replace(state.presses, hand_back=state.presses.hand_back + 1), pressed_ns=now_ns)
    return state


_TABLE: dict[Doing, Callable[[Behaviour, Situation, int], Behaviour]] = {
    Doing.WATCH: _watch,
    Doing.REACT: _react,
    Doing.TAKE: _take,
    Doing.DRIVE: _drive,
}


def _may_press(state: Behaviour, now_ns: int) -> bool:
    return state.pressed_ns == 0 or now_ns - state.pressed_ns >= AGAIN_NS


def _is_over(seen: Situation) -> bool:
    """The reason to take over is gone, or taking over is no longer the operator's business."""
    recovered = seen.mode is Mode.AUTONOMOUS and not (seen.request_open or seen.keen)
    given_up = seen.another_drives and not seen.is_next
    return recovered or given_up or seen.mode in (Mode.SAFE_STOP, Mode.EMERGENCY_STOP, Mode.LOCAL_DRIVER)
