"""What is fuzzed of that which somebody signed: questions, certificates, the list of the revoked, the car's audit trail.

The keys are made here, at every start, and no input has them: so whatever is let in must say what a seed says.
"""

from collections.abc import Callable, Iterator
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from ssl import DER_cert_to_PEM_cert
from typing import TypeVar

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from msgspec.structs import replace

from benchmarks.proof.rules import Broken, Target, must_be_finite
from recordings.audit.report import head_of, report_of, said
from recordings.audit.source import Line, read_lines, readable
from recordings.audit.verify import verify
from recordings.errors import RecordingError
from vehicle_gateway.audit.file import resume
from wire.audit_chain import Chain, follow, hash_of, seal
from wire.authority import SIGNATURE, issue, new_authority
from wire.configuration import ConfigurationError
from wire.identity import Signer, Unproven, proven
from wire.messages.audit import AuditEntry, AuditKind, AuditRecord
from wire.messages.base import UNDECODABLE, decoder, encode
from wire.messages.session import LeaseRequest, Supervision, SupervisionRequest
from wire.messages.vehicle import Mode
from wire.revocation import NOTHING, read_revocations, with_revoked
from wire.topics import Role

AUTHORITY = new_authority()
COCKPIT = issue(str(Role.TOWER_HUB), (), AUTHORITY)
HUB = issue(f"{Role.VEHICLE_HUB}.car-1", (), AUTHORITY)
NOW = datetime.now(UTC)
LEASE = LeaseRequest(operator="ann", session="s1", sent_ns=1, echoed_vehicle_ns=5, echoed_boot_id="boot")
ORDER = SupervisionRequest(
    action=Supervision.REVOKE,
    lease_epoch=7,
    operator="",
    reason="r",
    stop=False,
    sent_ns=1,
    echoed_vehicle_ns=5,
    echoed_boot_id="boot",
)
ENTRY = AuditEntry(
    number=1,
    previous="0" * 64,
    kind=AuditKind.HEAD,
    stamp_ns=1,
    utc_ns=round(NOW.timestamp()) * 10**9,
    boot_id="boot",
    vehicle_id="car-1",
    mode=Mode.REMOTE,
    drive=1,
    remote=True,
    signer_pem=HUB.certificate_pem.decode(),
)
K = AuditKind
STORY = (K.START, K.HEAD, K.LEASE, K.DRIVE_BEGIN, K.INTERVENTION, K.INTERVENTION_END, K.HEAD, K.DRIVE_END, K.HEAD, K.MODE)
DEEP = b"[" * 5000  # deeper than any decoder follows
_RECORD = decoder(AuditRecord)
Question = TypeVar("Question", LeaseRequest, SupervisionRequest)


def signed_targets(folder: Path) -> Iterator[Target]:
    """folder  for what is read from files"""
    signer = Signer(COCKPIT.key, COCKPIT.certificate)
    lease, order = signer.sign(LEASE), signer.sign(ORDER)
    yield Target("question of a lease", _question(lease), (encode(lease),))
    yield Target("question of a supervisor", _question(order), (encode(order),))
    yield Target("certificate", _certificate, tuple(each.certificate.public_bytes(Encoding.DER) for each in (COCKPIT, HUB)))
    yield Target("revocations", _revocations, (encode(REVOKED), encode(NOTHING), DEEP))
    trail = b"".join(record + b"\n" for record in TRAIL)
    deep = TRAIL[0].replace(b'"entry":', b'"entry":' + DEEP) + b"\n"
    (folder / "authority.pem").write_bytes(AUTHORITY.certificate_pem)
    tried = _trail(folder / "car.audit.jsonl", folder / "authority.pem")
    yield Target("audit trail", tried, (b"\x00" + trail, b"\x01" + trail, b"\x00" + deep), 1)
    yield Target("audit file at a start", _resumed(folder / "next.audit.jsonl"), (trail, trail[:-9], deep), 1)


def _question(genuine: Question) -> Callable[[bytes], None]:
    known = decoder(type(genuine))

    def try_one(data: bytes) -> None:
        try:
            question = known.decode(data)
            proven(question, AUTHORITY.certificate, NOW)
        except (*UNDECODABLE, Unproven):
            return
        if replace(question, signature="") != replace(genuine, signature=""):
            raise Broken(f"{question} is held for signed, and nobody has")

    return try_one


def _certificate(data: bytes) -> None:
    """Whatever certificate a question or the head of a trail comes with, signed by a key that is really there."""
    pem = DER_cert_to_PEM_cert(data)
    question = replace(LEASE, certificate=pem)
    signature = COCKPIT.key.sign(b"LeaseRequest" + encode(question), SIGNATURE)
    with suppress(Unproven):
        proven(replace(question, signature=signature.hex()), AUTHORITY.certificate, NOW)
        _must_be_issued(data, COCKPIT.certificate)
    head = replace(ENTRY, signer_pem=pem)
    if verify([Line("line 1", seal(head, HUB.key), head, "")], AUTHORITY.certificate).signed_to:
        _must_be_issued(data, HUB.certificate)


def _must_be_issued(der: bytes, genuine: x509.Certificate) -> None:
    if x509.load_der_x509_certificate(der).tbs_certificate_bytes != genuine.tbs_certificate_bytes:
        raise Broken("a certificate that nobody issued is believed")


REVOKED = with_revoked(with_revoked(NOTHING, "window", AUTHORITY), "tower-hub.ann", AUTHORITY)


def _revocations(data: bytes) -> None:
    try:
        known = read_revocations(data, AUTHORITY.certificate)
    except ValueError:
        return
    if known not in (NOTHING, replace(REVOKED, signature=known.signature)):
        raise Broken(f"{known} is held for the authority's")


def _story() -> Iterator[AuditRecord]:
    chain = Chain()
    for at, kind in enumerate(STORY):
        signer = ENTRY.signer_pem if kind is K.HEAD else ""
        moment = replace(ENTRY, kind=kind, stamp_ns=at * 10**9, utc_ns=ENTRY.utc_ns + at * 10**9, signer_pem=signer)
        chain, record = follow(chain, moment, HUB.key)
        yield record


RECORDS = tuple(_story())
TRAIL = tuple(encode(record) for record in RECORDS)


def _trail(file: Path, authority: Path) -> Callable[[bytes], None]:
    """`recordings audit`. First byte 1: somebody without the key has made all hashes anew."""

    def try_one(data: bytes) -> None:
        file.write_bytes(_hashed_anew(data[1:]) if data[:1] == b"\x01" else data[1:])
        try:
            report = report_of(file, authority)
        except RecordingError:
            return
        must_be_finite(report, "report")
        encode(report)
        if not all(head_of(report)) or not all(map(said, report.verdict.problems)):
            raise Broken("there is a problem that has no words")
        if report.holds:
            _must_be_written(file, report.verdict.signed_to)

    return try_one


def _must_be_written(file: Path, signed_to: int) -> None:
    for each in readable(read_lines(file)):
        if each.entry.number <= signed_to and each.record.hash != RECORDS[each.entry.number - 1].hash:
            raise Broken(f"record {each.entry.number} is held for signed, and nobody has")


def _hashed_anew(data: bytes) -> bytes:
    return b"\n".join(_with_its_hash(line) for line in data.split(b"\n"))


def _with_its_hash(line: bytes) -> bytes:
    try:
        record = _RECORD.decode(line)
    except UNDECODABLE:
        return line
    return encode(msgspec.structs.replace(record, hash=hash_of(bytes(record.entry))))


def _resumed(file: Path) -> Callable[[bytes], None]:
    """The gateway at its start. No whole line is ever changed."""

    def try_one(data: bytes) -> None:
        file.with_suffix(".part").unlink(missing_ok=True)
        file.write_bytes(data)
        with suppress(ConfigurationError):
            must_be_finite(resume(file), "resumed")
        if file.read_bytes() != data[: data.rfind(b"\n") + 1]:
            raise Broken("a start has changed whole lines of the audit file")

    return try_one
