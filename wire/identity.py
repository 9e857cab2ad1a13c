"""Who asks: a question signed with the private key of its asker's own certificate (ECDSA on P-256 with SHA-256).

A hub hides who stands behind it, so the certificate of the transport says only which hub passed a question on. What is signed
holds the car's boot id and its newest stamp, so that it is good for one car and one moment; how long the moment may be is
decided where the question is answered. Never says whether the asker may do what he asks for.
"""

from dataclasses import dataclass
from datetime import datetime
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import TypeVar

import msgspec
from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from wire.authority import SIGNATURE, common_name, is_issued_by, is_signed_by, read_certificate
from wire.certificates import pair_of
from wire.messages.base import encode
from wire.messages.session import LeaseRequest, SupervisionRequest
from wire.topics import Role

Question = TypeVar("Question", LeaseRequest, SupervisionRequest)


class Unproven(Exception):
    """Nobody known has signed this; the text says what is wrong, for whoever asked."""


@dataclass(frozen=True, slots=True)
class Signer:
    """Signs in the name of one certificate."""

    key: ec.EllipticCurvePrivateKey
    certificate: x509.Certificate

    def sign(self, question: Question) -> Question:
        """The question with certificate and signature filled in."""
        named = msgspec.structs.replace(question, certificate=_pem(self.certificate), signature="")
        return msgspec.structs.replace(named, signature=self.key.sign(_signed_part(named), SIGNATURE).hex())


@dataclass(frozen=True, slots=True)
class Proven:
    """Whose key has signed."""

    name: str  # common name of the certificate
    fingerprint: str  # SHA-256 of the certificate, in hexadecimal: what `openssl x509 -fingerprint -sha256` prints
    ends: datetime  # until when it is valid


def signer_of(folder: Path, role: Role) -> Signer:
    """Who signs with a role's own key. Raises CertificateError."""
    pair = pair_of(folder, role)
    return Signer(pair.key, pair.certificate)


def proven(question: LeaseRequest | SupervisionRequest, authority: x509.Certificate, now: datetime) -> Proven:
    """Whose key has signed this question, under a certificate that is valid now. Raises Unproven."""
    if not question.certificate:
        raise Unproven("the question is not signed: is the tower of the same version?")
    certificate = _read(question.certificate)
    if not is_issued_by(certificate, authority):
        raise Unproven("your certificate comes from another authority than the car's")
    if not certificate.not_valid_before_utc <= now <= certificate.not_valid_after_utc:
        raise Unproven(f"your certificate is valid until {certificate.not_valid_after_utc:%Y-%m-%d %H:%M} UTC: renew it")
    if not is_signed_by(certificate, question.signature, _signed_part(question)):
        raise Unproven("the question is not signed with the key of its certificate")
    return Proven(common_name(certificate), fingerprint(certificate), certificate.not_valid_after_utc)


def fingerprint(certificate: x509.Certificate) -> str:
    return sha256(certificate.public_bytes(serialization.Encoding.DER)).hexdigest()


def _signed_part(question: LeaseRequest | SupervisionRequest) -> bytes:
    return type(question).__name__.encode() + encode(msgspec.structs.replace(question, signature=""))


@lru_cache(maxsize=8)
def _pem(certificate: x509.Certificate) -> str:
    return certificate.public_bytes(serialization.Encoding.PEM).decode()


def _read(pem: str) -> x509.Certificate:
    try:
        return read_certificate(pem.encode())
    except ValueError:
        raise Unproven("the certificate in the question cannot be read") from None
