"""Hand-over, from the tower's side: a press becomes a wish, a wish waits for its conditions, then the car is asked once. Pure.

The car answers granted (with a new epoch) or refused (with the rule); what becomes of a grant is told by its GatewayStatus. Never
believes that the operator drives before the car has said so, but for the moment between a grant and its commit.
"""

from dataclasses import dataclass, replace

from haptics.alignment import Phase
from wire.messages.session import Action, HandOverReply, HandOverRequest, Outcome
from wire.messages.vehicle import GatewayStatus, Mode

COMMIT_NS = 1_000_000_000  # a grant is committed in the car within 300 ms; the rest is the way of the status back to us
BUTTONS = {
    "accept": Action.TAKE,
    "hand_back": Action.HAND_BACK,
    "return_": Action.RETURN,
    "engage": Action.ENGAGE,
    "clear": Action.CLEAR,
}
PATIENCE_NS = {Action.TAKE: 15_000_000_000, Action.RETURN: 5_000_000_000}  # how long a wish waits; aligning takes about 2 s
PATIENCE_ELSE_NS = 2_000_000_000
TAKES_WHEEL = frozenset({Action.TAKE, Action.RETURN})
DRIVING = frozenset({Mode.REMOTE, Mode.HANDING_BACK})
ALIGNING = frozenset({Mode.STANDBY, Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER, Mode.STOPPED})


@dataclass(frozen=True, slots=True, kw_only=True)
class HandOverState:
    wish: Action | None = None
    wished_ns: int = 0
    asked: Action | None = None  # in flight
    number: int = 0  # of the last question
    note: str = ""
    commit_until_ns: int = 0  # a grant of the wheel is waited for; 0: none
    seen: tuple[int, str] | None = None  # number and state of the car's hand-over, to notice changes


@dataclass(frozen=True, slots=True, kw_only=True)
class HandOverInputs:
    pressed: frozenset[str]
    phase: Phase
    dead_man: bool
    lease_epoch: int  # 0: none
    status: GatewayStatus | None
    asker_busy: bool


def step(state: HandOverState, seen: HandOverInputs, now_ns: int) -> tuple[HandOverState, HandOverRequest | None]:
    """(state, the unsigned question to ask now or None)."""
    state = _told(state, seen.status)
    state = _wished(state, seen, now_ns)
    if state.wish is None or state.asked is not None:
        return state, None
    wish, missing = state.wish, _missing(state.wish, seen)
    if missing:
        return _waited(state, wish, missing, now_ns), None
    if seen.asker_busy:
        return state, None
    number = state.number + 1
    asked = replace(state, wish=None, asked=wish, number=number, note=f"{_words(wish)}: asked")
    heard = (seen.status.stamp_ns, seen.status.boot_id) if seen.status else (0, "")
    return asked, HandOverRequest(
        lease_epoch=seen.lease_epoch,
        number=number,
        action=wish,
        sent_ns=now_ns,
        echoed_vehicle_ns=heard[0],
        echoed_boot_id=heard[1],
    )


def answered(state: HandOverState, reply: HandOverReply | None, now_ns: int) -> HandOverState:
    """With the answer to the question in flight; None: nobody answered. An answer to another question is none."""
    if state.asked is None:
        return state
    action, state = state.asked, replace(state, asked=None)
    if reply is None or reply.number != state.number:
        return replace(state, note=f"{_words(action)}: no answer")
    if reply.outcome is Outcome.REFUSED:
        return replace(state, note=f"{_words(action)} refused: {reply.rule}")
    commit_until = now_ns + COMMIT_NS if action in TAKES_WHEEL else state.commit_until_ns
    return replace(state, note=f"{_words(action)}: granted", commit_until_ns=commit_until)


def is_driving(state: HandOverState, status: GatewayStatus | None, operator: str, now_ns: int) -> bool:
    """Whether the wheel is the operator's: the car says so, or has just granted it."""
    if now_ns < state.commit_until_ns:
        return True
    return status is not None and status.mode in DRIVING and status.lease_holder == operator


def wheel_wanted(state: HandOverState, status: GatewayStatus | None, dead_man: bool) -> bool:
    """Whether the wheel should turn to the car's angle: a take-over is asked for, wished, or one press away."""
    if status is None or status.mode not in ALIGNING:
        return False
    wished = state.wish in TAKES_WHEEL or state.asked in TAKES_WHEEL
    return dead_man or wished or status.request is not None or status.guard_remaining_s > 0.0


def _told(state: HandOverState, status: GatewayStatus | None) -> HandOverState:
    """What the car says about a grant ends our waiting for it."""
    if status is None:
        return state
    told = (status.hand_over.number, status.hand_over.state)
    news, state = state.seen is not None and told != state.seen, replace(state, seen=told)
    if status.mode is Mode.REMOTE:
        return replace(state, commit_until_ns=0)
    if news and status.hand_over.state in ("expired", "aborted"):
        rule = f": {status.hand_over.rule}" if status.hand_over.rule else ""
        return replace(state, commit_until_ns=0, note=f"{status.hand_over.action} {status.hand_over.state}{rule}")
    return state


def _wished(state: HandOverState, seen: HandOverInputs, now_ns: int) -> HandOverState:
    for button, action in BUTTONS.items():
        if button in seen.pressed:
            state = replace(state, wish=action, wished_ns=now_ns)
    if state.wish in TAKES_WHEEL and seen.status is not None and seen.status.mode in DRIVING:
        return replace(state, wish=None)  # it is ours already
    return state


def _missing(wish: Action, seen: HandOverInputs) -> str:
    """What the wish still waits for, in words; "" when nothing."""
    if seen.lease_epoch == 0:
        return "no lease"
    if wish not in TAKES_WHEEL:
        return ""
    if not seen.dead_man:
        return "hold the dead-man control"
    if wish is Action.RETURN:  # one press: the wheel follows the car all through the guard time, the rest is blended out
        return ""
    return "" if seen.phase is Phase.READY else "the wheel is turning to the car's angle"


def _waited(state: HandOverState, wish: Action, missing: str, now_ns: int) -> HandOverState:
    if now_ns - state.wished_ns <= PATIENCE_NS.get(wish, PATIENCE_ELSE_NS):
        return replace(state, note=f"{_words(wish)}: {missing}")
    return replace(state, wish=None, note=f"{_words(wish)} given up: {missing}")


def _words(action: Action) -> str:
    return action.value.replace("_", " ")
