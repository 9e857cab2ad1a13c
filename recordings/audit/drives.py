"""The numbered remote drives of an audit trail: begin, end, operator, what intervened meanwhile. Pure."""

from collections.abc import Iterable

from msgspec.structs import replace

from wire.messages.audit import AuditEntry, AuditKind, Fingerprint, MapPosition
from wire.messages.base import Count, Message, Name, Text, TimeNs


class Counted(Message):
    """One rule of the gate, or one cause of the failsafe, during one drive."""

    episodes: Count = 0
    cycles: Count = 0
    seconds: float = 0.0


class RemoteDrive(Message):
    number: Count
    operator: Name
    certificate: Fingerprint  # "" where the car did not know it
    begin_utc_ns: TimeNs | None = None  # None: before this file begins
    end_utc_ns: TimeNs | None = None  # None: it goes on where this file ends
    begin_cause: Text = ""
    end_cause: Text = ""
    begin_at: MapPosition | None = None
    end_at: MapPosition | None = None
    interventions: dict[Name, Counted] = {}
    failsafes: dict[Name, Counted] = {}
    refusals: Count = 0
    stops: Count = 0  # STOP pressed in the tower

    @property
    def duration_s(self) -> float | None:
        if self.begin_utc_ns is None or self.end_utc_ns is None:
            return None
        return (self.end_utc_ns - self.begin_utc_ns) / 1e9


COUNTED = {AuditKind.INTERVENTION: "interventions", AuditKind.FAILSAFE: "failsafes"}
BEGINNING = {AuditKind.INTERVENTION_END: AuditKind.INTERVENTION, AuditKind.FAILSAFE_END: AuditKind.FAILSAFE}


def remote_drives(entries: Iterable[AuditEntry]) -> tuple[RemoteDrive, ...]:
    """In the order of their numbers. What began during a drive counts for it, also when it ended later."""
    drives: dict[int, RemoteDrive] = {}
    began_in: dict[tuple[str, str], int] = {}  # kind and subject of what is open: the drive it began in
    for entry in entries:
        if entry.remote or entry.kind is AuditKind.DRIVE_END:
            known = drives.get(entry.drive) or _new(entry)
            drives[entry.drive] = _with(known, entry)
            if entry.kind in COUNTED:
                began_in[entry.kind, entry.subject] = entry.drive
        beginning = BEGINNING.get(entry.kind)
        if beginning and (beginning, entry.subject) in began_in:
            number = began_in.pop((beginning, entry.subject))
            drives[number] = _ended(drives[number], beginning, entry)
    return tuple(drive for _, drive in sorted(drives.items()))


def _new(entry: AuditEntry) -> RemoteDrive:
    return RemoteDrive(number=entry.drive, operator=entry.operator, certificate=entry.certificate)


def _with(drive: RemoteDrive, entry: AuditEntry) -> RemoteDrive:
    """The drive after an entry that belongs to it."""
    match entry.kind:
        case AuditKind.DRIVE_BEGIN:
            return replace(drive, begin_utc_ns=entry.utc_ns, begin_cause=entry.text, begin_at=entry.position)
        case AuditKind.DRIVE_END:
            return replace(drive, end_utc_ns=entry.utc_ns, end_cause=entry.text, end_at=entry.position)
        case AuditKind.REFUSAL:
            return replace(drive, refusals=drive.refusals + 1)
        case AuditKind.STOP:
            return replace(drive, stops=drive.stops + 1)
        case AuditKind.INTERVENTION | AuditKind.FAILSAFE:
            return _counted(drive, entry.kind, entry.subject, Counted(episodes=1))
    return drive


def _ended(drive: RemoteDrive, beginning: AuditKind, entry: AuditEntry) -> RemoteDrive:
    return _counted(drive, beginning, entry.subject, Counted(cycles=entry.times, seconds=entry.lasted_s))


def _counted(drive: RemoteDrive, kind: AuditKind, subject: str, more: Counted) -> RemoteDrive:
    table: dict[str, Counted] = getattr(drive, COUNTED[kind])
    known = table.get(subject, Counted())
    together = Counted(
        episodes=known.episodes + more.episodes, cycles=known.cycles + more.cycles, seconds=known.seconds + more.seconds
    )
    return replace(drive, **{COUNTED[kind]: {**table, subject: together}})
