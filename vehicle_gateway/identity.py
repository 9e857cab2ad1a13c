"""Whose certificate asks, found out when a question arrives: a shell around `wire.identity` with the car's certificates.

Only finds out; whether he gets what he asks for is decided in the cycle, which works on (and records) what was found here.
The end of a certificate is told on the car's own clock by the wall clock at start: a step of that one while driving ends nothing.
"""

from datetime import UTC, datetime
from pathlib import Path

from cryptography import x509

from wire.certificates import AUTHORITY, earliest_end
from wire.identity import Proven, Unproven, proven
from wire.messages.base import Message, Name, Text, TimeNs
from wire.messages.session import LeaseRequest, SupervisionRequest
from wire.topics import Role, operator_of, role_of

PER_SECOND_MAX = 50  # ours: a signature costs a third of a millisecond to check; two towers ask twice a second


class Identity(Message):
    """Who asked a question, in the inputs of a cycle beside it."""

    name: Name = ""  # common name of the certificate; "": not known (recordings from before questions were signed)
    operator: Name = ""  # whose personal certificate it is; "": of a tower, whoever sits there
    fingerprint: Name = ""  # SHA-256 of the certificate
    ends_ns: TimeNs = 0  # vehicle clock: when it expires, or the first of the car's own; 0: not known
    rule: Text = ""  # why nobody was recognised


class Verifier:
    """Recognises those who may ask this car."""

    def __init__(self, folder: Path, accepts_script: bool, utc_minus_monotonic_ns: int) -> None:
        """folder: of the car's certificates."""
        self._authority = x509.load_pem_x509_certificate((folder / f"{AUTHORITY}.pem").read_bytes())
        self._operators = frozenset({Role.TOWER_HUB} | ({Role.TOWER_SCRIPT} if accepts_script else set()))
        self._utc_ns = utc_minus_monotonic_ns
        self._own_end = earliest_end(folder)  # at its end the tower cuts the link as well
        self._second = self._count = 0

    def operator(self, request: LeaseRequest, now_ns: int) -> Identity:
        return self._identity(request, self._operators, now_ns)

    def supervisor(self, request: SupervisionRequest, now_ns: int) -> Identity:
        return self._identity(request, frozenset({Role.TOWER_SUPERVISOR}), now_ns)

    def _identity(self, question: LeaseRequest | SupervisionRequest, roles: frozenset[Role], now_ns: int) -> Identity:
        if not self._has_time(now_ns):
            return Identity(rule="too many questions at once: ask again")
        try:
            asker = proven(question, self._authority, datetime.fromtimestamp((now_ns + self._utc_ns) / 1e9, UTC))
        except Unproven as error:
            return Identity(rule=str(error))
        if role_of(asker.name) not in roles:
            return Identity(rule=f"the certificate of {asker.name} may not ask this")
        return self._of(asker)

    def _of(self, asker: Proven) -> Identity:
        ends_ns = round(min(asker.ends, self._own_end).timestamp() * 1e9) - self._utc_ns
        return Identity(name=asker.name, operator=operator_of(asker.name), fingerprint=asker.fingerprint, ends_ns=max(ends_ns, 1))

    def _has_time(self, now_ns: int) -> bool:
        """Questions come over the link, and their signatures must not cost the loop its time."""
        second = now_ns // 1_000_000_000
        self._count = self._count + 1 if second == self._second else 1
        self._second = second
        return self._count <= PER_SECOND_MAX
