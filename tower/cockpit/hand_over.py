"""Hand-over, from the tower's side: a press becomes a wish, a wish waits for its conditions, then the car is asked once. Pure.

The car answers granted (with a new epoch) or refused (with the rule); what becomes of a grant is told by its GatewayStatus. The
last question is kept with its number and what became of it, as the car keeps the hand-over that it granted. Never believes that
the operator drives before the car has said so, but for the moment between a grant and its commit.
"""

from dataclasses import dataclass, replace

from msgspec.structs import replace as changed

from haptics.alignment import Phase
from wire.messages.operating import Question
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
ENDED = ("committed", "expired", "aborted")
DRIVING = frozenset({Mode.REMOTE, Mode.HANDING_BACK})
ALIGNING = frozenset({Mode.STANDBY, Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.HANDING_OVER, Mode.STOPPED})


@dataclass(frozen=True, slots=True, kw_only=True)
class HandOverState:
    wish: Action | None = None
    wished_ns: int = 0
    question: Question = Question()
    boot_id: str = ""  # of the car's gateway when it was asked
    note: str = ""
    commit_until_ns: int = 0  # a grant of the wheel is waited for; 0: none

    @property
    def asked(self) -> Action | None:
        """What is in flight."""
        return Action(self.question.action) if self.question.state == "requested" else None


@dataclass(frozen=True, slots=True, kw_only=True)
class HandOverInputs:
    pressed: frozenset[str]
    phase: Phase
    dead_man: bool
    lease_epoch: int  # 0: none
    status: GatewayStatus | None
    asker_busy: bool
    operator: str
    guard_holds: bool = False  # the car, for something in its way: "accept" then means to pass that


def step(state: HandOverState, seen: HandOverInputs, now_ns: int) -> tuple[HandOverState, HandOverRequest | None]:
    """(state, the unsigned question to ask now or None)."""
    state = _told(state, seen.status, seen.operator)
    state = _wished(state, seen, now_ns)
    if state.wish is None or state.asked is not None:
        return state, None
    wish, missing = state.wish, _missing(state.wish, seen)
    if missing:
        return _waited(state, wish, missing, now_ns), None
    if seen.asker_busy:
        return state, None
    question = Question(number=state.question.number + 1, action=wish, state="requested")
    heard = (seen.status.stamp_ns, seen.status.boot_id) if seen.status else (0, "")
    asked = replace(state, wish=None, question=question, boot_id=heard[1], note=f"{_words(wish)}: asked")
    return asked, HandOverRequest(
        lease_epoch=seen.lease_epoch,
        number=question.number,
        action=wish,
        sent_ns=now_ns,
        echoed_vehicle_ns=heard[0],
        echoed_boot_id=heard[1],
    )


def answered(state: HandOverState, reply: HandOverReply | None, now_ns: int) -> HandOverState:
    """With the answer to the question in flight; None: nobody answered. An answer to another question is none."""
    action = state.asked
    if action is None:
        return state
    if reply is None or reply.number != state.question.number:
        return replace(
            state, question=changed(state.question, state="expired", rule="no answer"), note=f"{_words(action)}: no answer"
        )
    if reply.outcome is Outcome.REFUSED:
        refused = changed(state.question, state="refused", rule=reply.rule)
        return replace(state, question=refused, note=f"{_words(action)} refused: {reply.rule}")
    commit_until = now_ns + COMMIT_NS if action in TAKES_WHEEL else state.commit_until_ns
    at_once = action not in (*TAKES_WHEEL, Action.HAND_BACK)
    granted = changed(state.question, state="committed" if at_once else "granted", hand_over=reply.hand_over)
    return replace(state, question=granted, note=f"{_words(action)}: granted", commit_until_ns=commit_until)


def is_driving(state: HandOverState, status: GatewayStatus | None, operator: str, now_ns: int) -> bool:
    """Whether the wheel is the operator's: the car says so, or has just granted it."""
    if now_ns < state.commit_until_ns:
        return True
    return status is not None and status.mode in DRIVING and status.lease_holder == operator


def is_next(status: GatewayStatus | None, operator: str) -> bool:
    """Whether a supervisor lets this operator take over from the one who drives."""
    return status is not None and status.mode is Mode.REMOTE and bool(operator) and status.succession.operator == operator


def wheel_wanted(state: HandOverState, status: GatewayStatus | None, operator: str, dead_man: bool) -> bool:
    """Whether the wheel should turn to the car's angle: a take-over is asked for, wished, or one press away."""
    if status is None or not (status.mode in ALIGNING or is_next(status, operator)):
        return False
    wished = state.wish in TAKES_WHEEL or state.asked in TAKES_WHEEL
    return dead_man or wished or status.request is not None or status.guard_remaining_s > 0.0


def _told(state: HandOverState, status: GatewayStatus | None, operator: str) -> HandOverState:
    """What the car says about our grant ends our waiting for it."""
    if status is None:
        return state
    if status.mode is Mode.REMOTE and status.lease_holder == operator:
        state = replace(state, commit_until_ns=0)
    ended = _end(state, status)
    if ended is None:
        return state
    how, rule = ended
    words = state.question.action.replace("_", " ")
    note = state.note if how == "committed" else f"{words} {how}: {rule}" if rule else f"{words} {how}"
    until_ns = state.commit_until_ns if how == "committed" else 0
    return replace(state, question=changed(state.question, state=how, rule=rule), note=note, commit_until_ns=until_ns)


def _end(state: HandOverState, status: GatewayStatus) -> tuple[str, str] | None:
    """(committed, expired or aborted; the rule) when the car says that of what it granted us, or has forgotten it."""
    if state.question.state != "granted":
        return None
    if status.boot_id != state.boot_id:
        return "aborted", "the car's gateway has started anew"
    told = status.hand_over
    if told.number == state.question.hand_over and told.state in ENDED:
        return told.state, told.rule
    return None


def _wished(state: HandOverState, seen: HandOverInputs, now_ns: int) -> HandOverState:
    for button, action in BUTTONS.items():
        if button in seen.pressed:
            state = replace(state, wish=_meant(action, seen, now_ns, state), wished_ns=now_ns)
    if state.wish in TAKES_WHEEL and is_driving(state, seen.status, seen.operator, now_ns):
        return replace(state, wish=None)  # it is ours already
    return state


def _meant(action: Action, seen: HandOverInputs, now_ns: int, state: HandOverState) -> Action:
    """Whoever drives and accepts that another one is named passes the car on to him."""
    named = seen.status is not None and bool(seen.status.succession.operator) and not seen.guard_holds
    passes = action is Action.TAKE and named and is_driving(state, seen.status, seen.operator, now_ns)
    return Action.PASS_ON if passes else action


def _missing(wish: Action, seen: HandOverInputs) -> str:
    """What the wish still waits for, in words; "" when nothing."""
    if seen.lease_epoch == 0:
        return "no lease"
    if wish not in TAKES_WHEEL:
        return ""
    if not seen.dead_man:
        return "hold the dead-man control"
    if is_next(seen.status, seen.operator) and seen.status is not None and seen.status.succession.refused:
        return seen.status.succession.refused
    if wish is Action.RETURN:  # one press: the wheel follows the car all through the guard time, the rest is blended out
        return ""
    return "" if seen.phase is Phase.READY else "the wheel is turning to the car's angle"


def _waited(state: HandOverState, wish: Action, missing: str, now_ns: int) -> HandOverState:
    if now_ns - state.wished_ns <= PATIENCE_NS.get(wish, PATIENCE_ELSE_NS):
        return replace(state, note=f"{_words(wish)}: {missing}")
    return replace(state, wish=None, note=f"{_words(wish)} given up: {missing}")


def _words(action: Action) -> str:
    return action.value.replace("_", " ")
