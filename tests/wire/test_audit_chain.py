"""Chaining and signing, held to hashlib and to the raw signature; what the software calls itself."""

import json
from hashlib import sha256

from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec, ed25519
from msgspec.structs import replace

from wire.audit_chain import GENESIS, Chain, fingerprint, follow, is_signed, seal
from wire.authority import issue, new_authority
from wire.messages.audit import AuditEntry, AuditKind, AuditRecord
from wire.messages.base import decoder, encode
from wire.messages.vehicle import Mode
from wire.software import PACKAGE, software, version_of

PAIR = issue("vehicle-hub", (), new_authority())
ENTRY = AuditEntry(
    number=1,
    previous=GENESIS,
    kind=AuditKind.STOP,
    stamp_ns=5,
    utc_ns=6,
    boot_id="boot",
    vehicle_id="car-1",
    mode=Mode.REMOTE,
    drive=1,
    remote=True,
)


def test_a_record_holds_the_hash_of_its_entrys_bytes_and_the_next_one_holds_it_too():
    chain, first = follow(Chain(), ENTRY, PAIR.key)
    chain, second = follow(chain, ENTRY, PAIR.key)
    assert first.hash == sha256(bytes(first.entry)).hexdigest()
    assert json.loads(bytes(second.entry)) | {"number": 1, "previous": GENESIS} == json.loads(bytes(first.entry))
    assert json.loads(bytes(second.entry))["previous"] == first.hash
    assert chain == Chain(number=2, hash=second.hash)


def test_a_record_read_again_hashes_the_same():
    record = seal(ENTRY, PAIR.key)
    again = decoder(AuditRecord).decode(encode(record))
    assert again == record and sha256(bytes(again.entry)).hexdigest() == again.hash


def test_only_a_head_is_signed_and_only_its_own_key_and_hash_fit():
    head = seal(replace(ENTRY, kind=AuditKind.HEAD), PAIR.key)
    assert seal(ENTRY, PAIR.key).signature == ""
    assert is_signed(head, PAIR.certificate)
    assert not is_signed(head, issue("vehicle-hub", (), new_authority()).certificate)
    assert not is_signed(replace(head, hash=sha256(b"another").hexdigest()), PAIR.certificate)
    PAIR.key.public_key().verify(
        bytes.fromhex(head.signature), b"remote operation tower audit head " + head.hash.encode(), ec.ECDSA(hashes.SHA256())
    )


def test_a_signature_made_for_something_else_is_none_here():
    head = seal(replace(ENTRY, kind=AuditKind.HEAD), PAIR.key)
    other = PAIR.key.sign(head.hash.encode(), ec.ECDSA(hashes.SHA256())).hex()
    assert not is_signed(replace(head, signature=other), PAIR.certificate)


def test_a_certificate_of_another_kind_of_key_signs_nothing():
    class Other:
        def public_key(self) -> ed25519.Ed25519PublicKey:
            return ed25519.Ed25519PrivateKey.generate().public_key()

    assert not is_signed(seal(replace(ENTRY, kind=AuditKind.HEAD), PAIR.key), Other())  # type: ignore[arg-type]


def test_the_fingerprint_is_the_one_that_other_tools_show():
    der = PAIR.certificate.public_bytes(serialization.Encoding.DER)
    assert fingerprint(PAIR.certificate) == sha256(der).hexdigest()


def test_the_software_names_itself_with_its_version():
    assert software().startswith(f"{PACKAGE} {version_of(PACKAGE)}")
    assert version_of("no such distribution") == ""
