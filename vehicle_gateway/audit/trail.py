"""From gateway cycles to audit entries: what began, ended, was granted, refused, changed, and by which rule. Pure.

Looks at what a cycle started from, took in, gave and left; adds nothing of its own. A remote drive lasts from the cycle in which
the operator begins to drive to the one in which he no longer does, and where another one takes over from him the next drive begins;
its number goes on over restarts (the shell reads it back from the file). Content: StVFernLV Annex 3.
"""

from collections.abc import Iterable, Iterator

from msgspec.structs import replace

from vehicle_gateway.audit.episodes import END_OF, Episode, Episodes, Seen, follow_up
from vehicle_gateway.audit.position import MapOrigin, position_of
from vehicle_gateway.authority import Event
from vehicle_gateway.failsafe import RULES
from vehicle_gateway.journal import Entry
from vehicle_gateway.lease import Lease
from vehicle_gateway.state import open_request
from wire.audit_chain import GENESIS
from wire.messages.audit import AuditEntry, AuditKind, Fingerprint
from wire.messages.automation import Scene
from wire.messages.base import Count, Message, Name, Speed, Text
from wire.messages.session import Outcome
from wire.messages.vehicle import Actuation, Mode

REMOTE = (Mode.REMOTE, Mode.HANDING_BACK)  # the operator drives until a hand-back is committed
ENDS = (AuditKind.DRIVE_END, AuditKind.LEASE_LOST, *END_OF.values())
ENDED = ("committed", "expired", "aborted")  # what becomes of a granted hand-over


class About(Message):
    """What is the same in every entry of one start."""

    vehicle_id: Name
    boot_id: Name
    utc_minus_now_ns: int  # Unix time = vehicle clock + this
    origin: MapOrigin | None = None


class Trail(Message):
    """What has to be known of the cycles before."""

    drive: Count = 0  # number of the last remote drive
    remote: bool = False  # it goes on
    mode: Mode = Mode.STANDBY
    operator: Name = ""
    speed_m_s: Speed = 0.0
    scene: Scene | None = None  # the newest
    episodes: Episodes = ()


class Fact(Message):
    """What one entry tells besides time, place and who drives."""

    kind: AuditKind
    subject: Name = ""
    text: Text = ""
    operator: Name = ""
    certificate: Fingerprint = ""
    epoch: Count = 0
    question: Count = 0
    times: Count = 0
    lasted_s: float = 0.0
    requested: Actuation | None = None
    applied: Actuation | None = None


def certificate_of(lease: Lease) -> str:
    """Fingerprint of the certificate that holds the lease; "" in recordings from before a lease knew it."""
    return lease.fingerprint


def observe(trail: Trail, cycle: Entry, about: About) -> tuple[Trail, tuple[AuditEntry, ...]]:
    """The trail after one cycle, and what of it is to be kept."""
    before = _look(trail, cycle)
    trail, change = _drives(before, cycle)
    trail, lasting = _follow(trail, cycle, began=trail.remote and bool(change), ended=bool(change) and not trail.remote)
    facts = (*_events(cycle), *lasting)
    during = replace(trail, remote=before.remote or trail.remote)  # what ends a drive belongs to it, and what begins one
    if before.remote and trail.remote and change:
        return trail, _changed_hands(before, trail, cycle, facts, change, about)
    told = [entry_of(fact, during, cycle.now_ns, about) for fact in facts]
    changed = [entry_of(fact, trail, cycle.now_ns, about) for fact in change]
    return trail, (*changed, *told) if trail.remote else (*told, *changed)


def _changed_hands(
    before: Trail, trail: Trail, cycle: Entry, facts: Iterable[Fact], change: Iterable[Fact], about: About
) -> tuple[AuditEntry, ...]:
    """One drive ends and the next begins: what ended is told in the first one, by its operator, and the rest in the next."""
    first = replace(trail, drive=before.drive, operator=cycle.before.lease.holder)
    told = (*change, *facts)
    ends = [entry_of(fact, first, cycle.now_ns, about) for fact in told if fact.kind in ENDS]
    begins = [entry_of(fact, trail, cycle.now_ns, about) for fact in told if fact.kind not in ENDS]
    return (*ends[1:], *ends[:1], *begins)  # the end of the drive is the last of it


def start(
    trail: Trail, now_ns: int, about: About, software: str, configuration_sha256: str
) -> tuple[Trail, tuple[AuditEntry, ...]]:
    """A gateway starts. A remote drive that the one before it never ended is ended here: it died."""
    begins = entry_of(Fact(kind=AuditKind.START), replace(trail, operator=""), now_ns, about)
    entries = [replace(begins, software=software, configuration_sha256=configuration_sha256)]
    if trail.remote:
        died = Fact(
            kind=AuditKind.DRIVE_END, operator=trail.operator, text="the gateway died; the drive ended before it was started again"
        )
        trail = replace(trail, remote=False)
        entries.append(entry_of(died, trail, now_ns, about))
    return replace(trail, operator=""), tuple(entries)


def entry_of(fact: Fact, trail: Trail, now_ns: int, about: About) -> AuditEntry:
    """The entry, not yet in the chain."""
    return AuditEntry(
        number=1,
        previous=GENESIS,
        kind=fact.kind,
        stamp_ns=now_ns,
        utc_ns=max(now_ns + about.utc_minus_now_ns, 0),
        boot_id=about.boot_id,
        vehicle_id=about.vehicle_id,
        mode=trail.mode,
        drive=trail.drive,
        remote=trail.remote,
        operator=fact.operator or trail.operator,
        certificate=fact.certificate,
        subject=fact.subject[:64],
        text=fact.text[:2000],
        epoch=fact.epoch,
        question=fact.question,
        times=fact.times,
        lasted_s=fact.lasted_s,
        requested=fact.requested,
        applied=fact.applied,
        speed_m_s=trail.speed_m_s,
        position=position_of(trail.scene, now_ns, about.origin),
    )


def _look(trail: Trail, cycle: Entry) -> Trail:
    after = cycle.after
    return Trail(
        drive=trail.drive,
        remote=trail.remote,
        mode=after.authority.mode,
        operator=after.lease.holder,
        speed_m_s=after.feedback.speed_m_s if after.feedback else 0.0,
        scene=cycle.inputs.scene or trail.scene,
        episodes=trail.episodes,
    )


def _drives(trail: Trail, cycle: Entry) -> tuple[Trail, tuple[Fact, ...]]:
    """Begin or end of a remote drive. Compared with what was kept last, so that a cycle never seen loses no end."""
    remote, changes_hands = trail.mode in REMOTE, cycle.before.lease.owner != cycle.after.lease.owner
    if remote == trail.remote and not (remote and changes_hands):
        return trail, ()
    ends = [_drive(AuditKind.DRIVE_END, cycle.before.lease, cycle)] if trail.remote else []
    begins = [_drive(AuditKind.DRIVE_BEGIN, cycle.after.lease, cycle)] if remote else []
    return replace(trail, remote=remote, drive=trail.drive + remote), (*ends, *begins)


def _drive(kind: AuditKind, lease: Lease, cycle: Entry) -> Fact:
    return Fact(kind=kind, text=cycle.after.cause, operator=lease.holder, certificate=certificate_of(lease), epoch=lease.epoch)


def _events(cycle: Entry) -> Iterator[Fact]:
    """What happened at one instant, in the order in which the cycle decides."""
    if cycle.inputs.stop_number:
        yield Fact(kind=AuditKind.STOP, question=cycle.inputs.stop_number, text="STOP was pressed in the tower")
    yield from _request(cycle)
    yield from _orders(cycle)
    yield from _lease(cycle)
    for question, answer in zip(cycle.inputs.hand_over_requests, cycle.outputs.hand_over_replies, strict=True):
        if answer.outcome is Outcome.GRANTED:
            yield Fact(
                kind=AuditKind.GRANT,
                subject=question.action,
                question=question.number,
                epoch=answer.lease_epoch,
                operator=_asker(cycle, question.lease_epoch),
            )
    yield from _changes(cycle)
    yield from _succession(cycle)


def _asker(cycle: Entry, epoch: int) -> str:
    """Whose lease has, or had, this epoch; the holder for any other."""
    leases = (cycle.before.successor.lease, cycle.after.successor.lease, cycle.before.lease, cycle.after.lease)
    return next((lease.holder for lease in leases if lease.holder and lease.epoch == epoch), cycle.after.lease.holder)


def _succession(cycle: Entry) -> Iterator[Fact]:
    """A next operator who did not take over, and why; that he was named is the supervisor's order."""
    before, after = cycle.before.successor, cycle.after.successor
    if before.operator and not after.operator and Event.OPERATOR_CHANGED not in cycle.outputs.events:
        text = cycle.after.lease_note or cycle.after.cause
        yield Fact(kind=AuditKind.HAND_OVER, subject="expired", text=text, operator=before.operator, epoch=before.lease.epoch)


def _request(cycle: Entry) -> Iterator[Fact]:
    before, request = open_request(cycle.before), open_request(cycle.after)
    if request is not None and (before is None or before.number != request.number):
        reasons = "; ".join(f"{reason.channel}: {reason.text}" for reason in request.reasons)
        yield Fact(kind=AuditKind.REQUEST, question=request.number, subject=request.reasons[0].channel, text=reasons[:2000])


def _orders(cycle: Entry) -> Iterator[Fact]:
    """What a supervisor ordered and the car did; the supervisor's name and certificate."""
    inputs, outputs = cycle.inputs, cycle.outputs
    for asked, who, reply in zip(inputs.supervision_requests, inputs.supervisors, outputs.supervision_replies, strict=True):
        if reply.done:
            text = f"{asked.operator}: {asked.reason}" if asked.operator else asked.reason
            operator = who.operator or who.name
            yield Fact(kind=AuditKind.ORDER, subject=asked.action, text=text, operator=operator, certificate=who.fingerprint)


def _lease(cycle: Entry) -> Iterator[Fact]:
    before, after = cycle.before.lease, cycle.after.lease
    if before.owner == after.owner:
        return
    for kind, lease in ((AuditKind.LEASE_LOST, before), (AuditKind.LEASE, after)):
        if lease.holder:
            succeeded = Event.OPERATOR_CHANGED in cycle.outputs.events
            note = cycle.before.lease_note if succeeded else cycle.after.lease_note
            text = note if kind is AuditKind.LEASE_LOST else ""
            yield Fact(kind=kind, text=text, operator=lease.holder, certificate=certificate_of(lease), epoch=lease.epoch)


def _changes(cycle: Entry) -> Iterator[Fact]:
    before, after = cycle.before, cycle.after
    if before.authority.mode is not after.authority.mode:
        yield Fact(kind=AuditKind.MODE, subject=before.authority.mode, text=after.cause)
    if after.hand_over is not before.hand_over and after.hand_over != before.hand_over and after.hand_over.state in ENDED:
        ended = after.hand_over
        yield Fact(kind=AuditKind.HAND_OVER, subject=ended.state, text=ended.action, question=ended.question)


def _follow(trail: Trail, cycle: Entry, began: bool, ended: bool) -> tuple[Trail, tuple[Fact, ...]]:
    """What lasts: begun and over in this cycle. A drive that begins or ends splits it, so that each drive is told whole."""
    seen = _seen(cycle)
    if not seen and not trail.episodes:
        return trail, ()
    open_, begun, over = follow_up(() if began else trail.episodes, seen, cycle.now_ns)
    facts = (*map(_end, trail.episodes if began else over), *map(_begin, begun), *map(_end, open_ if ended else ()))
    return replace(trail, episodes=() if ended else open_), facts


def _seen(cycle: Entry) -> tuple[Seen, ...]:
    """What lasts, as far as it is there in this cycle."""
    outputs = cycle.outputs
    asked, sent = outputs.requested, outputs.applied
    return (
        *(Seen(AuditKind.INTERVENTION, rule, requested=asked, applied=sent) for rule in dict.fromkeys(outputs.rules)),
        *(Seen(AuditKind.FAILSAFE, cause, RULES[cause].text) for cause in outputs.causes),
        *_refusals(cycle),
    )


def _refusals(cycle: Entry) -> Iterator[Seen]:
    for asked, reply in zip(cycle.inputs.lease_requests, cycle.outputs.lease_replies, strict=True):
        if not reply.granted:
            yield Seen(AuditKind.REFUSAL, "lease", reply.rule, asked.operator)
    orders = zip(cycle.inputs.supervision_requests, cycle.inputs.supervisors, cycle.outputs.supervision_replies, strict=True)
    for order, who, told in orders:
        if not told.done:
            yield Seen(AuditKind.REFUSAL, order.action, told.rule, who.operator or who.name)
    for question, answer in zip(cycle.inputs.hand_over_requests, cycle.outputs.hand_over_replies, strict=True):
        if answer.outcome is Outcome.REFUSED:
            yield Seen(AuditKind.REFUSAL, question.action, answer.rule, _asker(cycle, question.lease_epoch), question.number)


def _begin(episode: Episode) -> Fact:
    return _of(episode, episode.kind)


def _end(episode: Episode) -> Fact:
    return replace(_of(episode, END_OF[episode.kind]), times=episode.times, lasted_s=episode.lasted_s)


def _of(episode: Episode, kind: AuditKind) -> Fact:
    return Fact(
        kind=kind,
        subject=episode.subject,
        text=episode.text,
        operator=episode.operator,
        question=episode.question,
        requested=episode.requested,
        applied=episode.applied,
    )
