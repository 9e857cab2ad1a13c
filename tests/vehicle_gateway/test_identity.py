"""Whose certificate asks: what one key signed is recognised as its certificate's, and nothing else is."""

import os
from datetime import UTC, datetime, timedelta
from pathlib import Path
from ssl import DER_cert_to_PEM_cert

import pytest
from cryptography.hazmat.primitives.serialization import Encoding
from cryptography.x509 import load_pem_x509_certificate
from msgspec.structs import replace

from vehicle_gateway.identity import Verifier
from wire.authority import Pair, is_signed_by, issue, new_authority, read_certificate
from wire.certificates import CertificateError, authority_of, make, revoke
from wire.clock import Clock
from wire.identity import Signer, Unproven, fingerprint, proven, signer_of
from wire.messages.session import LeaseRequest, Supervision, SupervisionRequest
from wire.settings import LinkSettings
from wire.topics import Role

S = 10**9
KEY_TYPE = bytes.fromhex("2a8648ce3d0201")  # id-ecPublicKey, RFC 5480
UTC_NS = 1_790_000_000 * S  # Unix time minus the car's clock
NOW = round(datetime.now(UTC).timestamp() * 1e9) - UTC_NS
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


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("identity") / "certificates"
    make(made)
    return made


@pytest.fixture
def verifier(folder: Path) -> Verifier:
    return Verifier(LinkSettings(certificates=str(folder)), Clock(), UTC_NS)


def signer(pair: Pair) -> Signer:
    return Signer(pair.key, pair.certificate)


def test_a_cockpit_is_recognised_by_name_and_fingerprint_with_the_end_of_its_certificate(folder: Path, verifier: Verifier):
    cockpit = signer_of(folder, Role.TOWER_HUB)
    found = verifier.operator(cockpit.sign(LEASE), NOW)
    assert (found.rule, found.name, found.operator) == ("", "tower-hub", "")
    assert found.fingerprint == fingerprint(cockpit.certificate)
    assert found.ends_ns + UTC_NS == pytest.approx(cockpit.certificate.not_valid_after_utc.timestamp() * 1e9, abs=2e9)


def test_a_certificate_ends_in_real_time_however_slow_the_drive_is(folder: Path):
    clock, cockpit = Clock(0, 0.5, NOW - 600 * S), signer_of(folder, Role.TOWER_HUB)  # slow for ten minutes
    slow = Verifier(LinkSettings(certificates=str(folder)), clock, UTC_NS)
    found = slow.operator(cockpit.sign(LEASE), clock.at_system_ns(NOW))
    ends_ns = cockpit.certificate.not_valid_after_utc.timestamp() * 1e9
    assert found.rule == ""
    assert clock.system_ns(found.ends_ns) + UTC_NS == pytest.approx(ends_ns, abs=2e9)


def test_a_certificate_of_an_operator_s_own_is_recognised_as_his_where_the_car_knows_him_and_then_no_other_is(folder: Path):
    known = Verifier(LinkSettings(certificates=str(folder), operators=("ann", "bob")), Clock(), UTC_NS)
    ann, eve = (signer(issue(f"tower-hub.{name}", (), authority_of(folder))) for name in ("ann", "eve"))
    assert known.operator(ann.sign(LEASE), NOW).operator == "ann"
    for asker in (eve, signer_of(folder, Role.TOWER_HUB)):
        assert "may not ask this" in known.operator(asker.sign(LEASE), NOW).rule


def test_what_is_revoked_while_the_gateway_runs_is_refused_from_the_next_look_on(tmp_path: Path):
    make(tmp_path / "certificates")
    looking = Verifier(LinkSettings(certificates=str(tmp_path / "certificates")), Clock(), UTC_NS)
    old = signer_of(tmp_path / "certificates", Role.TOWER_HUB)
    revoke(tmp_path / "certificates", "tower-hub")
    new = signer_of(tmp_path / "certificates", Role.TOWER_HUB)
    assert looking.operator(old.sign(LEASE), NOW).rule == ""
    looking.look()
    assert "was revoked" in looking.operator(old.sign(LEASE), NOW).rule and looking.is_revoked("tower-hub")
    assert looking.operator(new.sign(LEASE), NOW).name == "tower-hub~1"
    (tmp_path / "certificates" / "revoked.json").write_bytes(b"{")
    looking.look()
    assert looking.is_revoked("tower-hub"), "a list that cannot be read lets somebody in again"


MAY = {"operator": {Role.TOWER_HUB}, "supervisor": {Role.TOWER_SUPERVISOR}}


@pytest.mark.parametrize("role", Role)
def test_only_cockpits_ask_for_a_lease_and_only_supervisors_give_orders(folder: Path, verifier: Verifier, role: Role):
    anyone = signer_of(folder, role)
    found = {"operator": verifier.operator(anyone.sign(LEASE), NOW), "supervisor": verifier.supervisor(anyone.sign(ORDER), NOW)}
    for what, allowed in MAY.items():
        assert (found[what].rule == "") == (role in allowed), (what, found[what].rule)
        assert (found[what].name == "") == (role not in allowed)


def test_a_scripted_operator_is_recognised_where_the_car_accepts_one(folder: Path):
    lenient = Verifier(LinkSettings(certificates=str(folder), accepts_script=True), Clock(), UTC_NS)
    assert lenient.operator(signer_of(folder, Role.TOWER_SCRIPT).sign(LEASE), NOW).rule == ""


@pytest.mark.parametrize(
    "change",
    [
        {"operator": "eve"},
        {"session": "s2"},
        {"echoed_vehicle_ns": 6},
        {"echoed_boot_id": "b"},
        {"sent_ns": 2},
        {"signature": ""},
        {"signature": "zz"},
        {"signature": "00" * 71},
    ],
)
def test_nothing_of_a_signed_question_can_be_changed(folder: Path, verifier: Verifier, change: dict[str, object]):
    signed = signer_of(folder, Role.TOWER_HUB).sign(LEASE)
    assert verifier.operator(replace(signed, **change), NOW).rule == "the question is not signed with the key of its certificate"


def test_a_certificate_without_its_key_a_stranger_s_and_none_at_all_are_refused(folder: Path, verifier: Verifier):
    cockpit, window = signer_of(folder, Role.TOWER_HUB), signer_of(folder, Role.WINDOW)
    borrowed = Signer(window.key, cockpit.certificate)
    stranger = signer(issue("tower-hub", (), new_authority()))
    cases = {
        "not signed with the key": borrowed.sign(LEASE),
        "another authority": stranger.sign(LEASE),
        "not signed: is the tower": LEASE,
        "cannot be read": replace(cockpit.sign(LEASE), certificate="none"),
    }
    for words, question in cases.items():
        assert words in verifier.operator(question, NOW).rule


def test_a_signature_under_a_lease_request_is_none_under_an_order(folder: Path, verifier: Verifier):
    chief = signer_of(folder, Role.TOWER_SUPERVISOR)
    moved = replace(ORDER, certificate=chief.sign(LEASE).certificate, signature=chief.sign(LEASE).signature)
    assert "not signed with the key" in verifier.supervisor(moved, NOW).rule


def test_a_certificate_is_good_to_its_last_second_and_not_before_its_first(folder: Path):
    authority = authority_of(folder)
    pair = issue("tower-hub", (), authority)
    first, last = pair.certificate.not_valid_before_utc, pair.certificate.not_valid_after_utc
    question = signer(pair).sign(LEASE)
    for at, good in ((first - timedelta(seconds=1), False), (first, True), (last, True), (last + timedelta(seconds=1), False)):
        if good:
            assert proven(question, authority.certificate, at).name == "tower-hub"
        else:
            with pytest.raises(Unproven, match="renew it"):
                proven(question, authority.certificate, at)


def test_a_flood_of_questions_is_refused_without_looking_and_the_next_second_is_another(folder: Path, verifier: Verifier):
    floods = [signer_of(folder, Role.TOWER_HUB).sign(replace(LEASE, operator=name)) for name in ("eve", "mallory", "trudy")]
    rules = [verifier.operator(question, NOW).rule for question in floods for _ in range(30)]
    looked = [rule == "" for rule in rules]
    assert looked == [*[True] * 25, *[False] * 5] * 2 + [False] * 30
    assert set(rules) == {"", "too many questions at once: ask again"}
    assert verifier.operator(floods[2], NOW + S).rule == ""


def test_who_floods_keeps_neither_another_operator_nor_a_supervisor_from_being_looked_at(folder: Path, verifier: Verifier):
    flood = signer_of(folder, Role.TOWER_HUB).sign(replace(LEASE, operator="eve"))
    rules = [verifier.operator(flood, NOW).rule for _ in range(500)]
    assert rules.count("") == 25
    assert verifier.operator(signer_of(folder, Role.TOWER_HUB).sign(LEASE), NOW).rule == ""
    assert verifier.supervisor(signer_of(folder, Role.TOWER_SUPERVISOR).sign(ORDER), NOW).rule == ""


def test_a_signer_whose_key_is_missing_damaged_or_open_to_others_is_refused(folder: Path, tmp_path: Path):
    with pytest.raises(CertificateError, match=r"tower-supervisor.key: damaged or unreadable"):
        signer_of(tmp_path, Role.TOWER_SUPERVISOR)
    for end in ("key", "pem"):
        (tmp_path / f"window.{end}").write_bytes((folder / f"window.{end}").read_bytes())
    os.chmod(tmp_path / "window.key", 0o644)
    with pytest.raises(CertificateError, match="chmod 600"):
        signer_of(tmp_path, Role.WINDOW)
    os.chmod(tmp_path / "window.key", 0o600)
    signer_of(tmp_path, Role.WINDOW)
    (tmp_path / "window.key").write_bytes((folder / "video.key").read_bytes())
    with pytest.raises(CertificateError, match="does not belong"):
        signer_of(tmp_path, Role.WINDOW)


def test_a_certificate_whose_key_is_of_a_kind_that_nobody_knows_is_refused_in_words(folder: Path, verifier: Verifier):
    """One byte of its key's type changed: to ask for the key raises."""
    cockpit = signer_of(folder, Role.TOWER_HUB)
    der = cockpit.certificate.public_bytes(Encoding.DER)
    assert KEY_TYPE in der
    odd = DER_cert_to_PEM_cert(der.replace(KEY_TYPE, KEY_TYPE[:-1] + b"\x09"))
    assert "another authority" in verifier.operator(replace(cockpit.sign(LEASE), certificate=odd), NOW).rule
    assert not is_signed_by(load_pem_x509_certificate(odd.encode()), "00", b"anything")


VERSION_3 = bytes.fromhex("a003020102")  # RFC 5280: [0] { INTEGER 2 }
COMMON_NAME = bytes.fromhex("0603550403")  # its type, RFC 5280; the letters follow


@pytest.mark.parametrize(
    ("part", "becomes"),
    [
        (VERSION_3, VERSION_3[:-1] + b"\x12"),
        (COMMON_NAME, b"\x14" + COMMON_NAME[1:]),
        (COMMON_NAME + b"\x0c", COMMON_NAME + b"\x03"),  # UTF8String, BIT STRING
    ],
    ids=["version", "name", "letters"],
)
def test_a_certificate_of_which_a_part_cannot_be_read_is_refused_in_words(folder: Path, verifier: Verifier, part, becomes):
    """What the library raises is not always a ValueError, and for a name it comes when that is asked for."""
    cockpit = signer_of(folder, Role.TOWER_HUB)
    der = cockpit.certificate.public_bytes(Encoding.DER)
    assert part in der
    odd = DER_cert_to_PEM_cert(der.replace(part, becomes))
    assert "cannot be read" in verifier.operator(replace(cockpit.sign(LEASE), certificate=odd), NOW).rule
    with pytest.raises(ValueError):  # noqa: PT011 - what the library says of it is its own
        read_certificate(odd.encode())
