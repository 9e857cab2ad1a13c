"""Certificates that end while the operator drives: one side's are issued anew for little more than a minute.

That side starts again with them. The lease, and the drive with it, has to end ten seconds before the certificate does
(vehicle_gateway.lease.EXPIRY_MARGIN_NS): when that is, is known to the millisecond beforehand. What was there before comes back.
"""

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime, timedelta
from pathlib import Path

from cryptography import x509

from benchmarks.fault_arms import Arm, Armed, nothing
from benchmarks.warm_rig import WarmRig
from vehicle_gateway.lease import EXPIRY_MARGIN_NS
from wire.authority import common_name, hosts_of, issue
from wire.certificates import authority_of, write_pem
from wire.messages.vehicle import Mode
from wire.topics import Role

LIFE_S = 75.0  # a busy machine may take half a minute until the operator drives again
EARLY_NS = 100_000_000  # the shot begins so long before the end of the lease
STANDS_S = 15.0
STANDING = (Mode.STOPPED, Mode.STANDBY)


def ends(role: Role) -> Arm:
    """The certificate of that role, of the operator's side or of the car's, and with it the lease of who drives."""
    of_the_car = role is Role.VEHICLE_HUB

    @contextmanager
    def arm(rig: WarmRig) -> Iterator[Armed]:
        site = rig.sites.car if of_the_car else rig.sites.tower
        folder = site.folder / "certificates"
        files = tuple(folder / f"{role}.{end}" for end in ("pem", "key"))
        before = {file: file.read_bytes() for file in files}
        stand(rig)
        try:
            life = timedelta(seconds=rig.clock.real_s(round(LIFE_S * 1e9)))
            ends_ns = rig.clock.at_system_ns(_issue_short(folder, role, site.folder.parent / "office", life)) - EXPIRY_MARGIN_NS
            begin_again(rig, of_the_car)
            yield Armed(lambda _: nothing, lambda: rig.clock.now_ns() >= ends_ns - EARLY_NS, LIFE_S)
        finally:
            for file, content in before.items():
                file.write_bytes(content)
            stand(rig)
            begin_again(rig, of_the_car)

    return arm


def _issue_short(folder: Path, role: Role, office: Path, life: timedelta) -> int:
    """A certificate of the same name in place of the old one; when it ends, time.monotonic_ns()."""
    old = x509.load_pem_x509_certificate((folder / f"{role}.pem").read_bytes())
    new = issue(common_name(old), hosts_of(old), authority_of(office), life)
    write_pem(folder, role, new.key_pem, new.certificate_pem)
    left_s = (new.certificate.not_valid_after_utc - datetime.now(UTC)).total_seconds()
    return time.monotonic_ns() + round(left_s * 1e9)


def stand(rig: WarmRig) -> None:
    """The operator is gone and the car stands."""
    end(rig, "cockpit")
    rig.wait_until("the car stands without an operator", lambda: rig.car.mode in STANDING and rig.stands(), STANDS_S)


def begin_again(rig: WarmRig, gateway: bool) -> None:
    """The operator comes again; with the gateway started anew he finds a car that sets off by itself."""
    if gateway:
        end(rig, "gateway")
        rig.start("gateway")
    rig.start("cockpit")


def end(rig: WarmRig, name: str) -> None:
    rig.send(name, signal.SIGKILL)
    rig.machine(name).running[name].process.wait()
