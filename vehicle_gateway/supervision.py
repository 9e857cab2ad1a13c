"""What takes a lease away from its holder: a supervisor, or the end of his
certificate. And what else a supervisor may. Pure.

A supervisor never drives and never holds a lease. To take the lease of a driving operator is a SAFE_STOP (the authority makes it
one: the driving source is lost), and he has to say that he means it; or he names the next operator, and the car changes hands
when both are ready (`succession`). Who receives only is no driver yet: the hand-over is aborted.
"""

from msgspec.structs import replace

from vehicle_gateway.authority import Event
from vehicle_gateway.identity import Identity
from vehicle_gateway.lease import ECHO_AGE_MAX_NS, EXPIRY_MARGIN_NS, without_holder
from vehicle_gateway.state import Inputs, State, Successor
from wire.messages.session import Supervision, SupervisionReply, SupervisionRequest
from wire.messages.vehicle import Mode

BARRED_NS = 600_000_000_000  # ours: as long as stops are counted; a supervisor may let him in earlier
OFFERED_NS = 30_000_000_000  # ours: the named operator's tower asks once a second
SUCCESSION_NS = 60_000_000_000  # ours: sit down, see the road, align the wheel, agree by voice
BARRED_MAX = 100  # names; the one that ends first makes room
DRIVES = (Mode.REMOTE, Mode.HANDING_BACK)
Told = tuple[State, tuple[Event, ...]]


def supervise(state: State, inputs: Inputs, now_ns: int) -> tuple[State, tuple[Event, ...], tuple[SupervisionReply, ...]]:
    """The state, the events of what was ordered, and a reply for each question in order."""
    events: tuple[Event, ...] = ()
    replies = []
    for request, identity in zip(inputs.supervision_requests, inputs.supervisors, strict=True):
        rule = _refuse(state, request, identity, now_ns)
        if not rule:
            state, happened = _obey(replace(state, supervised_ns=request.echoed_vehicle_ns), request, identity, now_ns)
            events += happened
        replies.append(SupervisionReply(done=not rule, rule=rule))
    return state, events, tuple(replies)


def end_with_certificate(state: State, revoked: bool, now_ns: int) -> Told:
    """A lease ends shortly before the certificate that it was granted to, or as soon as that is revoked."""
    lease = state.lease
    if lease.holder and revoked:
        return withdraw(state, f"the certificate of {lease.holder} was revoked")
    if lease.holder and lease.ends_ns and now_ns >= lease.ends_ns - EXPIRY_MARGIN_NS:
        return withdraw(state, f"the certificate of {lease.holder} expires, or the car's")
    return state, ()


def withdraw(state: State, note: str) -> Told:
    """Nobody holds the lease any more; whoever drove with it is lost."""
    lost = replace(state, command=None, command_ns=0, dead_man_ns=0, pictures={}, question_number=0, lease_note=note[:2000])
    return replace(lost, lease=without_holder(state.lease), successor=Successor()), (Event.OPERATOR_LOST,)


def refuse_barred(state: State, operator: str, now_ns: int) -> str:
    """Why a supervisor's order keeps this operator from the lease now; "" when none does."""
    left_ns = state.barred.get(operator, 0) - now_ns
    if left_ns > 0:
        return f"a supervisor took the lease away; not before {left_ns / 1e9:.0f} s, or until he lets you in"
    if state.offered_to not in ("", operator) and now_ns < state.offered_until_ns:
        return f"a supervisor gives the lease to {state.offered_to}"
    return ""


def _refuse(state: State, request: SupervisionRequest, identity: Identity, now_ns: int) -> str:
    age_ns = now_ns - request.echoed_vehicle_ns
    if identity.rule or not identity.name:
        return identity.rule or "the question is not signed"
    if request.echoed_boot_id != state.boot_id or not 0 <= age_ns <= ECHO_AGE_MAX_NS:
        return "the question is too old: ask again"
    if request.echoed_vehicle_ns <= state.supervised_ns:
        return "this question was answered before"
    match request.action:
        case Supervision.REVOKE:
            return _refuse_revoke(state, request)
        case Supervision.ADMIT:
            return "" if request.operator in state.barred else f"{request.operator or 'nobody'} is not kept out"
        case Supervision.RELEASE:
            return "" if state.authority.mode in (Mode.STOPPED, Mode.STANDBY) else "only a standing car is released"


def _refuse_revoke(state: State, request: SupervisionRequest) -> str:
    rules = (
        (not state.lease.holder, "nobody holds the lease"),
        (request.lease_epoch != state.lease.epoch, f"the lease has changed: {state.lease.holder} holds it now; look again"),
        (not request.reason, "give the operator a reason"),
        (request.operator == state.lease.holder, f"{request.operator} holds it already"),
        (
            state.authority.mode in DRIVES and not request.stop and not _may_succeed(state, request),
            f"{state.lease.holder} drives: this would be a safe stop; add --stop, or name the next operator with --to"
            + (" when the hand-back is over" if state.authority.mode is Mode.HANDING_BACK else ""),
        ),
    )
    return next((text for refused, text in rules if refused), "")


def _may_succeed(state: State, request: SupervisionRequest) -> bool:
    return state.authority.mode is Mode.REMOTE and bool(request.operator) and not request.stop


def _obey(state: State, request: SupervisionRequest, identity: Identity, now_ns: int) -> Told:
    who = identity.operator or "a supervisor"
    match request.action:
        case Supervision.ADMIT:
            return replace(state, barred=_without(state.barred, request.operator)), ()
        case Supervision.RELEASE:
            note = f"released by {who}: {request.reason}"[:2000]
            return replace(state, stops=(), lease_note=note), ()
    state = replace(state, barred=_without(state.barred, request.operator))  # who is named is let in
    if _may_succeed(state, request):
        note = f"{who} lets {request.operator} take over from {state.lease.holder}: {request.reason}"[:2000]
        return replace(state, successor=Successor(operator=request.operator, until_ns=now_ns + SUCCESSION_NS), lease_note=note), ()
    barred = with_barred(state.barred, state.lease.holder, now_ns)
    offered = {"offered_to": request.operator, "offered_until_ns": now_ns + OFFERED_NS}
    note = f"{who} took the lease from {state.lease.holder}: {request.reason}"
    return withdraw(replace(state, barred=barred, **offered), note)


def _without(barred: dict[str, int], operator: str) -> dict[str, int]:
    return {name: at for name, at in barred.items() if name != operator}


def with_barred(barred: dict[str, int], operator: str, now_ns: int) -> dict[str, int]:
    """Whom a supervisor keeps from the lease and until when, with one more."""
    kept = sorted(((at, name) for name, at in barred.items() if at > now_ns and name != operator), reverse=True)
    return {name: at for at, name in kept[: BARRED_MAX - 1]} | {operator: now_ns + BARRED_NS}
