"""The lease, from the tower's side: ask, renew, and notice when it is no longer ours. Pure; `tower.cockpit.asker` carries it out.

The car alone grants. A lease is asked for anew whenever the car speaks of another boot, holder or epoch: the answer to the
same session carries the current epoch and key.
"""

from dataclasses import dataclass, replace

from wire.messages.session import LeaseReply, LeaseRequest
from wire.messages.vehicle import GatewayStatus

RETRY_NS = 1_000_000_000
RENEW_NS = 1_500_000_000
MISMATCH_NS = 300_000_000  # a status that was under way when the epoch changed is younger than this
MISMATCH_RETRY_NS = 500_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Lease:
    epoch: int = 0  # 0: none
    key: bytes = b""
    boot_id: str = ""
    note: str = "not asked yet"  # why there is no lease
    changed_ns: int = 0  # when epoch or key came
    asked_ns: int | None = None
    renew_now: bool = False  # something contradicts what we believe

    @property
    def held(self) -> bool:
        return self.epoch > 0


def due(lease: Lease, status: GatewayStatus | None, operator: str, now_ns: int) -> bool:
    """Whether to ask for the lease now."""
    if lease.asked_ns is None:
        return True
    since = now_ns - lease.asked_ns
    if not lease.held:
        return since >= RETRY_NS
    wrong = lease.renew_now or contradicts(lease, status, operator, now_ns)
    return since >= (MISMATCH_RETRY_NS if wrong else RENEW_NS)


def contradicts(lease: Lease, status: GatewayStatus | None, operator: str, now_ns: int) -> bool:
    """Whether the car speaks of another boot, holder or epoch than ours, for longer than messages are under way.

    The next operator, whom a supervisor lets take over from the one who drives, has a lease of his own beside the holder's.
    """
    if status is None or now_ns - lease.changed_ns < MISMATCH_NS:
        return False
    leases = ((status.lease_holder, status.lease_epoch), (status.succession.operator, status.succession.lease_epoch))
    return status.boot_id != lease.boot_id or (operator, lease.epoch) not in leases


def kept_back(lease: Lease, note: str) -> Lease:
    """Not asked for, and why."""
    return replace(lease, note=note) if lease.note != note else lease


def asked(lease: Lease, now_ns: int) -> Lease:
    return replace(lease, asked_ns=now_ns, renew_now=False)


def answered(lease: Lease, reply: LeaseReply | None, now_ns: int) -> Lease:
    """With the car's answer; None: nobody answered, which changes nothing about a lease that is held."""
    if reply is None:
        return replace(lease, note="" if lease.held else "the car does not answer")
    if not reply.granted:
        return Lease(note=reply.rule or "refused", changed_ns=now_ns, asked_ns=lease.asked_ns)
    try:
        key = bytes.fromhex(reply.key_hex)
    except ValueError:
        return replace(lease, note="the lease's key is not hexadecimal")
    same = (reply.epoch, reply.boot_id) == (lease.epoch, lease.boot_id)
    return Lease(
        epoch=reply.epoch,
        key=key,
        boot_id=reply.boot_id,
        note="",
        changed_ns=lease.changed_ns if same else now_ns,
        asked_ns=lease.asked_ns,
    )


def with_epoch(lease: Lease, epoch: int, now_ns: int) -> Lease:
    """A granted hand-over carries the new epoch; the key of the session stays. An older epoch than ours is not taken."""
    return replace(lease, epoch=epoch, changed_ns=now_ns) if epoch > lease.epoch else lease


def request(operator: str, session: str, status: GatewayStatus, now_ns: int) -> LeaseRequest:
    """The unsigned question."""
    return LeaseRequest(
        operator=operator,
        session=session,
        sent_ns=now_ns,
        echoed_vehicle_ns=status.stamp_ns,
        echoed_boot_id=status.boot_id,
    )
