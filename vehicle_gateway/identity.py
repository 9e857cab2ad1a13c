"""Whose certificate asks, found out when a question arrives: a shell around `wire.identity` with the car's certificates.

Only finds out; whether he gets what he asks for is decided in the cycle, which works on (and records) what was found here.
The end of a certificate is told on the car's own clock by the wall clock at start: a step of that one while driving ends nothing.
"""

import logging
import threading
from collections import Counter
from datetime import UTC, datetime

from wire.access import Names, admitted
from wire.authority import read_certificate
from wire.certificates import AUTHORITY, CertificateError, earliest_end, folder_of, revocations_of
from wire.clock import Clock
from wire.identity import Proven, Unproven, proven
from wire.messages.base import Message, Name, Text, TimeNs
from wire.messages.session import LeaseRequest, SupervisionRequest
from wire.revocation import Revocations
from wire.settings import LinkSettings
from wire.topics import Role, owner_of

log = logging.getLogger(__name__)
LOOK_S = 1.0  # how often the list of revoked certificates is looked at
PER_SECOND_MAX = 50  # ours: a signature costs a third of a millisecond to check; two towers ask twice a second
PER_ASKER_MAX = 25  # of those, by one name under one certificate: whoever floods still leaves the holder and a supervisor theirs


class Identity(Message):
    """Who asked a question, in the inputs of a cycle beside it."""

    name: Name = ""  # common name of the certificate; "": not known (recordings from before questions were signed)
    operator: Name = ""  # whose personal certificate it is; "": of a tower, whoever sits there
    fingerprint: Name = ""  # SHA-256 of the certificate
    ends_ns: TimeNs = 0  # vehicle clock: when it expires, or the first of the car's own; 0: not known
    rule: Text = ""  # why nobody was recognised


class Verifier:
    """Recognises those who may ask this car; a context in which a thread of its own looks at the list of the revoked."""

    def __init__(self, settings: LinkSettings, clock: Clock, utc_minus_monotonic_ns: int) -> None:
        """clock: of the car; certificates end in real time, however slow that is. Raises CertificateError."""
        self._settings, self._folder = settings, folder_of(settings.certificates)
        self._authority = read_certificate((self._folder / f"{AUTHORITY}.pem").read_bytes())
        self._operators = (Role.TOWER_HUB, Role.TOWER_SCRIPT) if settings.accepts_script else (Role.TOWER_HUB,)
        self._own_end = earliest_end(self._folder)  # at its end the tower cuts the link as well
        self._clock, self._utc_ns = clock, utc_minus_monotonic_ns
        self._second, self._looked = 0, Counter[tuple[str, str]]()  # by certificate and operator, in this second
        self._revoked = revocations_of(self._folder)
        self._names: Names = admitted(settings, self._revoked)
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="revocations", daemon=True)

    def __enter__(self) -> "Verifier":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join(timeout=LOOK_S)

    def operator(self, request: LeaseRequest, now_ns: int) -> Identity:
        return self._identity(request, self._operators, now_ns)

    def supervisor(self, request: SupervisionRequest, now_ns: int) -> Identity:
        return self._identity(request, (Role.TOWER_SUPERVISOR,), now_ns)

    def is_revoked(self, common_name: str) -> bool:
        """Whether this certificate is worth nothing any more, as far as was told here."""
        return self._revoked.is_revoked(common_name)

    def look(self) -> None:
        """Read the list again; one that cannot be read changes nothing."""
        try:
            revoked = revocations_of(self._folder)
        except CertificateError as error:
            log.warning("%s", error)
            return
        if revoked.number > self._revoked.number:
            self._take(revoked)

    def _take(self, revoked: Revocations) -> None:
        self._names, self._revoked = admitted(self._settings, revoked), revoked
        log.warning("certificates revoked: %s; hubs refuse them from their next start on", ", ".join(sorted(revoked.generations)))

    def _watch(self) -> None:
        while not self._end.wait(LOOK_S):
            self.look()

    def _identity(self, question: LeaseRequest | SupervisionRequest, roles: tuple[Role, ...], now_ns: int) -> Identity:
        if not self._has_time((question.certificate, question.operator), now_ns):
            return Identity(rule="too many questions at once: ask again")
        try:
            utc_ns = self._clock.system_ns(now_ns) + self._utc_ns
            asker = proven(question, self._authority, datetime.fromtimestamp(utc_ns / 1e9, UTC))
        except Unproven as error:
            return Identity(rule=str(error))
        if self.is_revoked(asker.name):
            return Identity(rule=f"the certificate of {asker.name} was revoked: import a new one")
        if not any(asker.name in self._names(role, self._settings.vehicle_id) for role in roles):
            return Identity(rule=f"the certificate of {asker.name} may not ask this")
        return self._of(asker)

    def _of(self, asker: Proven) -> Identity:
        ends_ns = self._clock.at_system_ns(round(min(asker.ends, self._own_end).timestamp() * 1e9) - self._utc_ns)
        return Identity(name=asker.name, operator=owner_of(asker.name), fingerprint=asker.fingerprint, ends_ns=max(ends_ns, 1))

    def _has_time(self, asker: tuple[str, str], now_ns: int) -> bool:
        """Questions come over the link: their signatures must not cost the loop its time, nor one asker's the others their turn."""
        second = now_ns // 1_000_000_000
        if second != self._second:
            self._second, self._looked = second, Counter()
        if self._looked[asker] >= PER_ASKER_MAX or self._looked.total() >= PER_SECOND_MAX:
            return False
        self._looked[asker] += 1
        return True
