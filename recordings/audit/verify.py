"""Is this audit trail as it was written? Names every record that was changed, removed, moved, inserted or cut. Pure.

A chain shows what happened between its records, a signed head that nobody made the chain anew. Neither shows records that were
cut off behind the last signed head, nor what somebody wrote who holds the vehicle hub's key. How it is made: `wire.audit_chain`.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from datetime import UTC, datetime

from cryptography import x509

from recordings.audit.source import Line, Read, readable
from wire.audit_chain import GENESIS, SIGNED_AT_ONCE, hash_of, is_signed
from wire.authority import common_name, is_issued_by, read_certificate
from wire.messages.audit import AuditKind
from wire.messages.base import Count, Message, Text
from wire.topics import Role, certificate_names


class Problem(Message):
    number: Count  # of the record; 0 where it has none
    place: Text  # in the file
    text: Text


class Verdict(Message):
    records: Count
    first: Count  # numbers of the first and the last record
    last: Count
    signed_to: Count  # number of the last head whose signature is good; 0: none
    unsigned: Count  # records behind it: nothing shows that none was changed or cut off there
    problems: tuple[Problem, ...]


def verify(lines: Iterable[Line], authority: x509.Certificate) -> Verdict:
    """authority  who must have issued the certificate of every signature"""
    lines = tuple(lines)
    found = readable(lines)
    heads = [(each, _wrong_head(each, authority)) for each in found if each.entry.kind is AuditKind.HEAD]
    numbers = [each.entry.number for each in found]
    signed_to = max((head.entry.number for head, wrong in heads if not wrong), default=0)
    problems = (
        *_unreadable(lines),
        *_changed(lines),
        *_missing(found),
        *_moved(found),
        *_not_following(found),
        *_unsigned_ends(found),
        *(_problem(head, wrong) for head, wrong in heads if wrong),
    )
    return Verdict(
        records=len(lines),
        first=min(numbers, default=0),
        last=max(numbers, default=0),
        signed_to=signed_to,
        unsigned=sum(number > signed_to for number in numbers),
        problems=tuple(sorted(problems, key=lambda problem: (problem.number, problem.place))),
    )


def _problem(read: Read, text: str) -> Problem:
    return Problem(number=read.entry.number, place=read.place, text=text[:2000])


def _unreadable(lines: Iterable[Line]) -> Iterator[Problem]:
    for line in lines:
        if line.error:
            yield Problem(number=0, place=line.place, text=line.error[:2000])


def _changed(lines: Iterable[Line]) -> Iterator[Problem]:
    for line in lines:
        if line.record is not None and hash_of(bytes(line.record.entry)) != line.record.hash:
            number = line.entry.number if line.entry else 0
            yield Problem(number=number, place=line.place, text="was changed: its content does not have the hash it carries")
        elif line.entry is not None and line.record is not None and line.record.stamp_ns != line.entry.stamp_ns:
            yield Problem(number=line.entry.number, place=line.place, text="was changed: its stamp is not the one of its entry")


def _missing(found: tuple[Read, ...]) -> Iterator[Problem]:
    numbers = sorted({each.entry.number for each in found})
    for before, after in zip(numbers, numbers[1:], strict=False):
        if after - before == 2:
            yield Problem(number=before + 1, place=f"before record {after}", text="is missing")
        elif after - before > 2:
            yield Problem(number=before + 1, place=f"before record {after}", text=f"to {after - 1} are missing")


def _moved(found: tuple[Read, ...]) -> Iterator[Problem]:
    """Records that stand behind one with a higher number, and numbers that stand there twice."""
    highest, places = 0, dict[int, str]()
    for each in found:
        number = each.entry.number
        if number in places:
            yield _problem(each, f"stands there a second time, first at {places[number]}: one of the two was inserted")
        elif number < highest:
            yield _problem(each, f"stands behind record {highest}: the order was changed")
        places.setdefault(number, each.place)
        highest = max(highest, number)


def _not_following(found: tuple[Read, ...]) -> Iterator[Problem]:
    """Records whose predecessor is there and is not the one they were written behind."""
    hashes = defaultdict[int, list[str]](list)
    for each in found:
        hashes[each.entry.number].append(each.record.hash)
    for each in found:
        number = each.entry.number
        before = [GENESIS] if number == 1 else hashes.get(number - 1, [])
        if before and each.entry.previous not in before:
            text = f"does not follow record {number - 1}: one of the two was changed and its hash made anew"
            yield _problem(each, text if number > 1 else "is not the first of a chain: it names a record before it")


def _unsigned_ends(found: tuple[Read, ...]) -> Iterator[Problem]:
    kinds = {each.entry.number: each.entry.kind for each in found}
    for each in found:
        follower = kinds.get(each.entry.number + 1, AuditKind.HEAD)
        if each.entry.kind in SIGNED_AT_ONCE and follower is not AuditKind.HEAD:
            yield _problem(each, f"is a {each.entry.kind} without the signed head that is written behind each of them")


def _wrong_head(head: Read, authority: x509.Certificate) -> str:
    """Why a head proves nothing; "" when it does."""
    entry = head.entry
    try:
        certificate = read_certificate(entry.signer_pem.encode())
    except ValueError:
        return "is a head without a certificate that can be read"
    made = datetime.fromtimestamp(entry.utc_ns / 1e9, UTC)
    checks = (
        (
            not is_issued_by(certificate, authority),
            "is signed with a certificate that another authority issued; name it with --authority",
        ),
        (
            common_name(certificate) not in certificate_names(Role.VEHICLE_HUB, entry.vehicle_id),
            f"is signed with the certificate of {common_name(certificate)}, not of this car's hub",
        ),
        (
            not certificate.not_valid_before_utc <= made <= certificate.not_valid_after_utc,
            "is signed with a certificate that was not valid then",
        ),
        (not is_signed(head.record, certificate), "has a signature that does not fit: it was changed after it was signed"),
    )
    return next((text for wrong, text in checks if wrong), "")
