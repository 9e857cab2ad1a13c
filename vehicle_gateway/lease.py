"""The lease: the exclusive right to ask, and the fencing token that makes an old operator's commands worthless.

A new epoch per grant, strictly increasing over the life of the car (the shell persists it before it answers). The key of the
lease never enters this file: the shell checks the HMAC, and whose certificate asks (`identity`), and tells the outcome.
"""

from msgspec.structs import replace

from vehicle_gateway.identity import Identity
from wire.messages.base import Count, Message, Name, TimeNs
from wire.messages.operating import DriveCommand
from wire.messages.session import LeaseRequest

SILENT_OTHER_NS = 5_000_000_000  # another operator gets the lease of a holder silent this long (architecture: 5 s)
SILENT_SAME_NS = 500_000_000  # the same operator's restarted tower: as long as SAFE_STOP takes to fall
ECHO_AGE_MAX_NS = 500_000_000  # a command that answers an older state of the car is no answer (OCP loop limit 500 ms)
EXPIRY_MARGIN_NS = 10_000_000_000  # ours: the stop is over, and seen to be, before both hubs cut the link at the very end
NOBODY = Identity()


class Lease(Message):
    epoch: Count = 0  # of the newest grant; commands with any other are dropped
    holder: Name = ""
    session: Name = ""
    seen_ns: TimeNs = 0  # when its holder was last heard, vehicle clock
    certificate: Name = ""  # of its holder: common name
    fingerprint: Name = ""
    ends_ns: TimeNs = 0  # vehicle clock: when that certificate expires; 0: not known
    given: Count = 0  # the newest epoch given to somebody else beside it; 0: none

    @property
    def owner(self) -> tuple[str, str, str]:
        """Who holds it: an operator at one start of one tower, under one name."""
        return self.holder, self.session, self.certificate


def request_lease(lease: Lease, request: LeaseRequest, now_ns: int, in_use: bool, identity: Identity = NOBODY) -> tuple[Lease, str]:
    """The lease after a request, and the rule that refused it ("" when granted or renewed).

    in_use    the holder drives, or control is changing hands: then nobody else gets it, whatever the silence
    identity  whose certificate asks
    """
    if not request.operator:
        return lease, "an operator needs a name: set [tower.cockpit] operator"
    asked = Lease(
        epoch=lease.epoch,
        holder=request.operator,
        session=request.session,
        seen_ns=now_ns,
        certificate=identity.name,
        fingerprint=identity.fingerprint,
        ends_ns=identity.ends_ns,
        given=lease.given,
    )
    if lease.owner == asked.owner:
        return asked, ""
    silent_ns = now_ns - lease.seen_ns
    same = (lease.holder, lease.certificate) == (asked.holder, asked.certificate)
    patience_ns = SILENT_SAME_NS if same else SILENT_OTHER_NS
    if lease.holder and (in_use or silent_ns < patience_ns):
        return (
            lease,
            f"the lease is held by {lease.holder}; it is offered when its holder is silent for {patience_ns / 1e9:g} s",
        )
    return replace(asked, epoch=next_epoch(lease)), ""


def refuse_asker(lease: Lease, request: LeaseRequest, identity: Identity, boot_id: str, now_ns: int) -> str:
    """Why whoever asks gets no lease, whoever holds it now; "" when he may have one.

    A holder's own renewal may be as late as he may be silent: a question that waited out a blackout takes nothing from him.
    """
    if identity.rule:
        return identity.rule
    if not identity.name:
        return ""  # a recording from before questions were signed
    if identity.operator not in ("", request.operator):
        return f"this is the certificate of {identity.operator}: set [tower.cockpit] operator"
    age_max_ns = SILENT_OTHER_NS if (request.operator, request.session) == (lease.holder, lease.session) else ECHO_AGE_MAX_NS
    if request.echoed_boot_id != boot_id or not 0 <= now_ns - request.echoed_vehicle_ns <= age_max_ns:
        return "the question is too old: ask again"
    if now_ns >= identity.ends_ns - EXPIRY_MARGIN_NS:
        return "your certificate expires now, or the car's: renew it"
    return ""


def next_epoch(lease: Lease) -> int:
    """Above every one that was ever given."""
    return max(lease.epoch, lease.given) + 1


def renew_epoch(lease: Lease) -> Lease:
    """The same holder with the next epoch: every hand-over grant makes one."""
    return replace(lease, epoch=next_epoch(lease))


def without_holder(lease: Lease) -> Lease:
    """Nobody's, and every command of its holder is worth nothing from now on."""
    return Lease(epoch=next_epoch(lease))


class CommandGuard(Message):
    """What a command is checked against when it arrives."""

    epoch: Count
    boot_id: Name
    last_sequence: Count


def refuse_command(command: DriveCommand, guard: CommandGuard, genuine: bool, now_ns: int) -> str:
    """Why a command is dropped, as the name it is counted under; "" when it is good.

    now_ns  vehicle clock at arrival; the echoed stamp is on the same clock when the boot id is ours
    """
    checks = (
        (command.lease_epoch != guard.epoch, "command epoch"),
        (not genuine, "command signature"),
        (command.sequence <= guard.last_sequence, "command sequence"),
        (command.echoed_boot_id != guard.boot_id, "command boot id"),
        (now_ns - command.echoed_vehicle_ns > ECHO_AGE_MAX_NS, "command echo age"),
        (command.echoed_vehicle_ns > now_ns, "command from the future"),
    )
    return next((reason for failed, reason in checks if failed), "")
