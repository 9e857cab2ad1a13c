"""The audit trail of one start of the gateway, put together from its settings: file, key, what is the same in every entry."""

from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from vehicle_gateway.audit.file import AuditFile, resume
from vehicle_gateway.audit.log import AuditLog, Signer
from vehicle_gateway.audit.position import MapOrigin
from vehicle_gateway.audit.trail import About
from wire.certificates import folder_of, pair_of
from wire.clock import Clock, utc_minus_monotonic_ns
from wire.link import Link
from wire.settings import LinkSettings
from wire.software import software
from wire.topics import Role


@contextmanager
def open_audit(
    link: Link,
    file: Path,
    config: Path,
    settings: LinkSettings,
    boot_id: str,
    origin: MapOrigin | None,
    clock: Clock,
    fifo_priority: int = 0,
) -> Iterator[AuditLog]:
    """Call it with the hub open: then no other gateway writes this file, and the certificates are there.

    Raises ConfigurationError for a file that cannot be used, CertificateError for a key that cannot.
    """
    resumed = resume(file)
    about = About(vehicle_id=settings.vehicle_id, boot_id=boot_id, utc_minus_now_ns=utc_minus_monotonic_ns(), origin=origin)
    said = software, sha256(config.read_bytes()).hexdigest()
    with AuditFile(file) as store, AuditLog(link, store, resumed, signer_of(settings), about, clock, *said, fifo_priority) as log:
        yield log


def signer_of(settings: LinkSettings) -> Signer:
    """The vehicle hub's own key, with which it signs its audit trail."""
    pair = pair_of(folder_of(settings.certificates), Role.VEHICLE_HUB)
    return Signer(pair.key, pair.certificate_pem.decode("ascii"))
