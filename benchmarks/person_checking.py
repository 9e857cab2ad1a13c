"""What a person does before the drive: the checklist, item by item, by what the window says is open. Pure.

Each press goes on until the screen shows that it has come; nothing is done by a timetable. Ends when every item is passed and
the STOP, which is one of them, was cleared again.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from benchmarks.person import Finger, Hands
from wire.messages.operating import OperatorStatus

PASSED = "passed"
AGAIN_S = 2.0  # a STOP or a CLEAR that came to nothing is pressed again after this
TURNED, BACK = 0.5, 0.02  # of what a key asks for
PRESSED, RELEASED = 0.8, 0.02  # of the brake's travel


@dataclass(frozen=True, slots=True, kw_only=True)
class Checking:
    """How far the hands have come."""

    turn: int = 0  # left, let go, right, let go
    braking: bool = True
    tapped_s: float = -AGAIN_S


@dataclass(frozen=True, slots=True, kw_only=True)
class Page:
    """One look at the screen."""

    checks: Mapping[str, str]  # window_status.checks
    operator: OperatorStatus
    now_s: float


def is_ready(page: Page) -> bool:
    return bool(page.checks) and set(page.checks.values()) == {PASSED} and not page.operator.stop_state


def checked(checking: Checking, page: Page) -> tuple[Checking, Hands]:
    """What the fingers do after this look: the first item that is open and asks for hands."""
    is_open = {name for name, state in page.checks.items() if state != PASSED}
    if "wheel" in is_open:
        return _turned(checking, page.operator)
    if "brake" in is_open:
        return _braked(checking, page.operator)
    if "STOP" in is_open and page.operator.stop_state != "sent":
        return _tapped(checking, Finger.STOP, page.now_s)
    if "STOP" not in is_open and page.operator.stop_state:
        return _tapped(checking, Finger.CLEAR, page.now_s)
    return checking, Hands()


def _turned(checking: Checking, operator: OperatorStatus) -> tuple[Checking, Hands]:
    asked = operator.steer_asked
    done = (asked > TURNED, abs(asked) < BACK, asked < -TURNED, abs(asked) < BACK)[checking.turn]
    checking = replace(checking, turn=(checking.turn + 1) % 4) if done else checking
    held = ({Finger.LEFT}, set[Finger](), {Finger.RIGHT}, set[Finger]())[checking.turn]
    return checking, Hands(frozenset(held))


def _braked(checking: Checking, operator: OperatorStatus) -> tuple[Checking, Hands]:
    braking = operator.brake < PRESSED if checking.braking else operator.brake < RELEASED
    return replace(checking, braking=braking), Hands(frozenset({Finger.BRAKE} if braking else ()))


def _tapped(checking: Checking, finger: Finger, now_s: float) -> tuple[Checking, Hands]:
    if now_s - checking.tapped_s < AGAIN_S:
        return checking, Hands()
    return replace(checking, tapped_s=now_s), Hands(tapped=finger)
