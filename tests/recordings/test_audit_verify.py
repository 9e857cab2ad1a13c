"""Every way to tamper with an audit trail, done to one that is whole: what is said, and of which record."""

from datetime import UTC, datetime, timedelta
from pathlib import Path
from ssl import DER_cert_to_PEM_cert

import msgspec
import pytest
from cryptography import x509
from cryptography.hazmat.primitives.serialization import Encoding
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from recordings.audit.source import line_of, read_lines
from recordings.audit.verify import verify
from wire.audit_chain import Chain, follow, hash_of, sign_head
from wire.authority import Pair, issue, new_authority
from wire.messages.audit import AuditEntry, AuditKind, AuditRecord
from wire.messages.base import decoder, encode
from wire.messages.vehicle import Mode
from wire.topics import Role

K = AuditKind
AUTHORITY = new_authority()
HUB = issue(f"{Role.VEHICLE_HUB}.car-1", (), AUTHORITY)
NOW_NS = round(datetime.now(UTC).timestamp()) * 10**9
STORY = (K.START, K.HEAD, K.LEASE, K.MODE, K.DRIVE_BEGIN, K.INTERVENTION, K.HEAD, K.STOP, K.MODE, K.DRIVE_END, K.HEAD, K.LEASE)
_RECORD, _ENTRY = decoder(AuditRecord), decoder(AuditEntry)


def entry(kind: AuditKind, at: int, **changes: object) -> AuditEntry:
    plain = AuditEntry(
        number=1,
        previous="0" * 64,
        kind=kind,
        stamp_ns=at * 10**9,
        utc_ns=NOW_NS + at * 10**9,
        boot_id="boot",
        vehicle_id="car-1",
        mode=Mode.REMOTE,
        drive=1,
        remote=True,
        signer_pem=HUB.certificate_pem.decode() if kind is K.HEAD else "",
    )
    return replace(plain, **changes)


def chain(kinds: tuple[AuditKind, ...] = STORY, signer: Pair = HUB, **changes: object) -> list[bytes]:
    """The lines of a file."""
    stands, lines = Chain(), list[bytes]()
    for at, kind in enumerate(kinds):
        stands, record = follow(stands, entry(kind, at, **changes), signer.key)
        lines.append(encode(record))
    return lines


WHOLE = chain()


def told(lines: list[bytes], authority: x509.Certificate = AUTHORITY.certificate) -> list[tuple[int, str]]:
    """(number of the record, what is said of it)"""
    found = [line_of(f"line {number}", line) for number, line in enumerate(lines, start=1)]
    return [(problem.number, problem.text) for problem in verify(found, authority).problems]


def parts(line: bytes) -> tuple[AuditRecord, AuditEntry]:
    record = _RECORD.decode(line)
    return record, _ENTRY.decode(record.entry)


def altered(line: bytes, rehash: bool, **changes: object) -> bytes:
    """The record with its entry changed, and with its hash made anew when `rehash`."""
    record, known = parts(line)
    content = encode(replace(known, **changes))
    return encode(replace(record, entry=msgspec.Raw(content), hash=hash_of(content) if rehash else record.hash))


def test_a_whole_trail_has_no_problem_and_says_how_far_it_is_signed():
    found = verify([line_of("", line) for line in WHOLE], AUTHORITY.certificate)
    assert found.problems == ()
    assert (found.records, found.first, found.last, found.signed_to, found.unsigned) == (12, 1, 12, 11, 1)


def test_a_part_of_a_trail_as_a_recording_holds_it_is_whole_too():
    assert told(WHOLE[4:]) == []


@pytest.mark.parametrize("at", range(len(WHOLE)))
def test_a_changed_record_is_named(at: int):
    lines = [*WHOLE[:at], altered(WHOLE[at], False, text="somebody else"), *WHOLE[at + 1 :]]
    assert [(number, text.split(":")[0]) for number, text in told(lines)] == [(at + 1, "was changed")]


@pytest.mark.parametrize("at", range(len(WHOLE) - 1))
def test_a_changed_record_with_its_hash_made_anew_is_found_by_the_one_behind_it(at: int):
    lines = [*WHOLE[:at], altered(WHOLE[at], True, text="somebody else"), *WHOLE[at + 1 :]]
    said = dict(told(lines))
    assert f"does not follow record {at + 1}" in said[at + 2]
    if STORY[at] is K.HEAD:
        assert "signature" in said[at + 1]


def test_a_chain_made_anew_from_a_changed_record_on_is_found_by_the_next_signed_head():
    """Whoever has no key: every hash recomputed, the old signatures kept."""
    stands, lines = Chain(), list[bytes]()
    for line in WHOLE:
        record, known = parts(line)
        changed = replace(known, text="somebody else") if known.number == 5 else known
        stands, made = follow(stands, changed, AUTHORITY.key)
        lines.append(encode(replace(made, signature=record.signature)))
    assert {number for number, text in told(lines) if "signature that does not fit" in text} == {7, 11}


@pytest.mark.parametrize("at", range(1, len(WHOLE) - 1))
def test_a_removed_record_is_missed_by_its_number(at: int):
    assert (at + 1, "is missing") in told(WHOLE[:at] + WHOLE[at + 1 :])


def test_several_removed_records_are_missed_by_their_numbers():
    assert told(WHOLE[:3] + WHOLE[6:]) == [(4, "to 6 are missing")]


def test_removed_records_with_the_rest_renumbered_and_made_anew_need_the_key():
    stands, lines = Chain(), list[bytes]()
    for line in WHOLE[:4] + WHOLE[5:]:
        record, known = parts(line)
        stands, made = follow(stands, known, AUTHORITY.key)
        lines.append(encode(replace(made, signature=record.signature)))
    assert any("signature" in text for _, text in told(lines))


def test_records_in_another_order_are_named():
    swapped = [*WHOLE[:4], WHOLE[5], WHOLE[4], *WHOLE[6:]]
    assert told(swapped) == [(5, "stands behind record 6: the order was changed")]


def test_an_inserted_copy_is_named_with_both_places():
    lines = [*WHOLE[:8], WHOLE[3], *WHOLE[8:]]
    assert told(lines) == [(4, "stands there a second time, first at line 4: one of the two was inserted")]


def test_an_inserted_forged_record_is_named():
    _, before = follow(Chain(), entry(K.STOP, 0), HUB.key)
    _, forged = follow(Chain(number=3, hash=parts(WHOLE[2])[0].hash), entry(K.STOP, 3), HUB.key)
    said = told([*WHOLE[:3], encode(forged), *WHOLE[3:]])
    assert [(number, text.split(",")[0]) for number, text in said] == [(4, "stands there a second time")]
    assert before.hash != forged.hash


def test_a_record_from_elsewhere_that_follows_nothing_is_named():
    said = told([*WHOLE, chain((K.STOP,) * 13)[12]])
    assert len(said) == 1 and said[0][0] == 13 and "does not follow record 12" in said[0][1]


def test_the_beginning_of_another_chain_is_not_the_first_record():
    record = altered(WHOLE[0], True, previous="ab" * 32)
    assert any("not the first of a chain" in text for number, text in told([record]) if number == 1)


def test_a_line_cut_in_the_middle_is_named(tmp_path: Path):
    file = tmp_path / "car.audit.jsonl"
    file.write_bytes(b"\n".join(WHOLE)[:-40])
    problems = verify(read_lines(file), AUTHORITY.certificate).problems
    assert [(problem.place, problem.text) for problem in problems] == [("line 12", "it ends in the middle of a record: cut off")]


def test_a_trail_cut_off_behind_its_last_head_looks_whole_and_before_it_is_told_as_unsigned():
    """The limit that is said in the output and in the README."""
    assert told(WHOLE[:11]) == []
    cut = verify([line_of("", line) for line in WHOLE[:10]], AUTHORITY.certificate)
    assert (cut.problems, cut.signed_to, cut.unsigned) == ((), 7, 3)


@pytest.mark.parametrize("at", [number for number, kind in enumerate(STORY) if kind is K.HEAD])
def test_a_signature_taken_away_or_taken_from_elsewhere_is_named(at: int):
    record, _ = parts(WHOLE[at])
    for signature in ("", sign_head(hash_of(b"something else"), HUB.key), "00" * 70):
        lines = [*WHOLE[:at], encode(replace(record, signature=signature)), *WHOLE[at + 1 :]]
        assert told(lines) == [(at + 1, "has a signature that does not fit: it was changed after it was signed")]


def test_the_head_behind_the_end_of_a_drive_cannot_be_left_out():
    lines = chain((K.START, K.HEAD, K.DRIVE_BEGIN, K.DRIVE_END, K.LEASE))
    assert told(lines) == [(4, "is a drive_end without the signed head that is written behind each of them")]


def signers() -> dict[str, Pair]:
    strangers = new_authority()
    return {
        "another authority issued": issue(f"{Role.VEHICLE_HUB}.car-1", (), strangers),
        "not of this car's hub": issue(Role.WINDOW, (), AUTHORITY),
        "of vehicle-hub.car-2": issue(f"{Role.VEHICLE_HUB}.car-2", (), AUTHORITY),
    }


@pytest.mark.parametrize(("words", "signer"), signers().items(), ids=signers())
def test_a_trail_made_with_another_key_is_refused_for_whose_key_it_is(words: str, signer: Pair):
    lines = chain((K.STOP, K.HEAD), signer, signer_pem=signer.certificate_pem.decode())
    said = told(lines)
    assert len(said) == 1 and said[0][0] == 2 and words in said[0][1]


def test_a_head_without_a_certificate_and_one_signed_after_it_expired_prove_nothing():
    assert "without a certificate" in told(chain((K.HEAD,), signer_pem="none"))[0][1]
    late = round((datetime.now(UTC) + timedelta(days=100)).timestamp()) * 10**9
    assert "not valid then" in told(chain((K.HEAD,), utc_ns=late))[0][1]


def test_a_head_whose_certificate_has_a_key_of_a_kind_that_nobody_knows_proves_nothing():
    der = HUB.certificate.public_bytes(Encoding.DER)
    odd = DER_cert_to_PEM_cert(der.replace(bytes.fromhex("2a8648ce3d0201"), bytes.fromhex("2a8648ce3d0209")))  # RFC 5480
    assert "another authority" in told(chain((K.HEAD,), signer_pem=odd))[0][1]


@pytest.mark.parametrize("part", ["a003020102", "0603550403"], ids=["version", "name"])  # RFC 5280
def test_a_head_whose_certificate_cannot_be_read_in_part_proves_nothing(part: str):
    der, known = HUB.certificate.public_bytes(Encoding.DER), bytes.fromhex(part)
    assert known in der
    odd = DER_cert_to_PEM_cert(der.replace(known, bytes((known[0] ^ 0x12,)) + known[1:-1] + b"\x12"))
    assert "without a certificate that can be read" in told(chain((K.HEAD,), signer_pem=odd))[0][1]


@settings(max_examples=60, deadline=None)
@given(st.integers(0, len(WHOLE) - 1), st.data())
def test_any_byte_changed_anywhere_is_found(at: int, data: st.DataObject):
    """But in the signature field of a record that is no head, and in what nothing signed stands behind."""
    line = bytearray(WHOLE[at])
    position = data.draw(st.integers(0, len(line) - 1))
    line[position] = data.draw(st.integers(0, 255).filter(lambda value: value != WHOLE[at][position]))
    problems = told([*WHOLE[:at], bytes(line), *WHOLE[at + 1 :]])
    record = line_of("", bytes(line)).record
    harmless = record is not None and STORY[at] is not K.HEAD and encode(replace(record, signature="")) == WHOLE[at]
    assert problems or harmless


@settings(max_examples=60, deadline=None)
@given(st.lists(st.integers(0, len(WHOLE) - 1), max_size=15))
def test_any_selection_in_any_order_is_found_unless_it_is_a_stretch_of_the_trail(picked: list[int]):
    stretch = picked == list(range(picked[0], picked[0] + len(picked))) if picked else True
    assert bool(told([WHOLE[index] for index in picked])) != stretch


def test_noise_between_records_is_named_by_its_place():
    for noise in (b"", b"\xff", b"{}", b"[" * 5000, b'{"entry":1,"hash":"' + b"0" * 64 + b'"}'):
        problems = verify([line_of("line 9", noise)], AUTHORITY.certificate).problems
        assert problems and {problem.place for problem in problems} == {"line 9"}
