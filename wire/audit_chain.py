"""How audit records are chained and signed. Pure; used by the car that writes them and by whoever checks them.

A record's hash is SHA-256 over the bytes of its entry, and the entry holds the hash of the record before: nothing earlier can
be changed, removed or moved without changing every hash after it. A HEAD is signed with the vehicle hub's own key (ECDSA P-256,
FIPS 186-5): nobody without that key can make the hashes anew up to there. What no chain can show: records cut off after its
last signed head.
"""

from hashlib import sha256

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from wire.authority import SIGNATURE, is_signed_by
from wire.messages.audit import AuditEntry, AuditKind, AuditRecord
from wire.messages.base import Count, Message, encode

SIGNED_AT_ONCE = (AuditKind.START, AuditKind.DRIVE_END, AuditKind.END)  # the record behind one of these is a signed head
GENESIS = "0" * 64  # stands where the first record has none before it
_SIGNED = b"remote operation tower audit head "  # so that a signature made for anything else is none here


def hash_of(entry: bytes) -> str:
    return sha256(entry).hexdigest()


class Chain(Message):
    """Where a chain stands: its last record."""

    number: Count = 0
    hash: str = GENESIS


def follow(chain: Chain, entry: AuditEntry, key: ec.EllipticCurvePrivateKey) -> tuple[Chain, AuditRecord]:
    """The entry as the next record of the chain, whatever number it came with."""
    record = seal(msgspec.structs.replace(entry, number=chain.number + 1, previous=chain.hash), key)
    return Chain(number=chain.number + 1, hash=record.hash), record


def seal(entry: AuditEntry, key: ec.EllipticCurvePrivateKey) -> AuditRecord:
    """The record of an entry; a HEAD comes signed."""
    content = encode(entry)
    found = hash_of(content)
    signature = sign_head(found, key) if entry.kind is AuditKind.HEAD else ""
    return AuditRecord(stamp_ns=entry.stamp_ns, entry=msgspec.Raw(content), hash=found, signature=signature)


def sign_head(record_hash: str, key: ec.EllipticCurvePrivateKey) -> str:
    return key.sign(_SIGNED + record_hash.encode(), SIGNATURE).hex()


def is_signed(record: AuditRecord, certificate: x509.Certificate) -> bool:
    """Whether the record's hash was signed with the key of this certificate."""
    return is_signed_by(certificate, record.signature, _SIGNED + record.hash.encode())


def fingerprint(certificate: x509.Certificate) -> str:
    """SHA-256 of the certificate's DER, hex: how an operator's certificate is named in the audit trail."""
    return sha256(certificate.public_bytes(serialization.Encoding.DER)).hexdigest()
