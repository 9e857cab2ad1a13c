"""Certificates: made once, whole, readable by their owner only, all under one authority, and renewed before they end."""

import stat
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from wire.certificates import CertificateError, earliest_end, ensure, folder_of, make, make_if_none, missing, unnamed
from wire.topics import Role


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("pki") / "certificates"
    assert ensure(made)
    return made


def certificate(folder: Path, name: str) -> x509.Certificate:
    return x509.load_pem_x509_certificate((folder / f"{name}.pem").read_bytes())


def contents(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in folder.iterdir()}


def test_a_second_ensure_changes_nothing(folder: Path):
    before = contents(folder)
    assert ensure(folder) is False
    assert contents(folder) == before


def test_there_is_one_certificate_and_one_key_for_every_role_and_the_authority(folder: Path):
    names = {"authority", *map(str, Role)}
    assert set(contents(folder)) == {f"{name}.{end}" for name in names for end in ("pem", "key")}
    assert missing(folder) == ()


def test_keys_are_readable_by_their_owner_only_even_where_a_looser_file_lay_before(tmp_path: Path, folder: Path):
    loose = tmp_path / "certificates"
    loose.mkdir()
    (loose / "window.key").write_bytes(b"")
    (loose / "window.key").chmod(0o666)
    make(loose)
    for place in (folder, loose):
        for file in place.glob("*.key"):
            assert stat.S_IMODE(file.stat().st_mode) == 0o600, file.name


def test_every_certificate_names_its_role_and_is_signed_by_the_authority(folder: Path):
    authority = certificate(folder, "authority")
    for role in Role:
        issued = certificate(folder, role)
        issued.verify_directly_issued_by(authority)
        assert [each.value for each in issued.subject.get_attributes_for_oid(NameOID.COMMON_NAME)] == [str(role)]
        key = serialization.load_pem_private_key((folder / f"{role}.key").read_bytes(), password=None)
        assert key.public_key() == issued.public_key()


def test_no_role_s_certificate_may_sign_another(folder: Path):
    assert certificate(folder, "authority").extensions.get_extension_for_class(x509.BasicConstraints).value.ca
    for role in Role:
        extensions = certificate(folder, role).extensions
        constraints = [each.value for each in extensions if isinstance(each.value, x509.BasicConstraints)]
        assert not any(each.ca for each in constraints)


def test_two_folders_share_no_authority(tmp_path: Path, folder: Path):
    make(tmp_path / "other")
    with pytest.raises(InvalidSignature):
        certificate(folder, "window").verify_directly_issued_by(certificate(tmp_path / "other", "authority"))


def test_they_are_valid_now_and_for_a_quarter(folder: Path):
    left = earliest_end(folder) - datetime.now(UTC)
    assert timedelta(days=80) < left < timedelta(days=100)
    assert all(certificate(folder, role).not_valid_before_utc < datetime.now(UTC) for role in Role)


def expiring(hours: float) -> bytes:
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, "window")])
    now = datetime.now(UTC)
    built = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(1)
        .not_valid_before(now - timedelta(days=90))
        .not_valid_after(now + timedelta(hours=hours))
        .sign(key, hashes.SHA256())
    )
    return built.public_bytes(serialization.Encoding.PEM)


@pytest.mark.parametrize(("hours", "renewed"), [(-1, True), (23, True), (25, False)])
def test_they_are_renewed_all_together_when_one_ends_within_a_day(tmp_path: Path, hours: float, renewed: bool):
    folder = tmp_path / "certificates"
    make(folder)
    (folder / "window.pem").write_bytes(expiring(hours))
    assert ensure(folder) is renewed
    if renewed:
        assert earliest_end(folder) > datetime.now(UTC) + timedelta(days=80)
        certificate(folder, "window").verify_directly_issued_by(certificate(folder, "authority"))


def test_one_missing_file_makes_all_of_them_anew(tmp_path: Path):
    folder = tmp_path / "certificates"
    make(folder)
    (folder / "video.key").unlink()
    assert missing(folder) == ("video.key",)
    assert ensure(folder)
    assert missing(folder) == ()
    certificate(folder, "video").verify_directly_issued_by(certificate(folder, "authority"))


def test_a_damaged_certificate_is_made_anew_or_named_with_what_to_do(tmp_path: Path):
    folder = tmp_path / "certificates"
    make(folder)
    (folder / "video.pem").write_bytes(b"-----BEGIN CERTIFICATE-----\nAAAA\n-----END CERTIFICATE-----\n")
    try:
        assert ensure(folder)
        certificate(folder, "video").verify_directly_issued_by(certificate(folder, "authority"))
    except CertificateError as error:
        assert "video.pem" in str(error)


def test_a_folder_that_cannot_be_written_is_named_with_the_key_to_change(tmp_path: Path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(CertificateError, match=r"certificates") as told:
        make(tmp_path / "file" / "deeper")
    assert str(tmp_path / "file" / "deeper") in str(told.value)


def test_hosts_are_added_to_those_that_are_named_already_and_survive_a_renewal(tmp_path: Path):
    folder = tmp_path / "certificates"
    ensure(folder)
    authority = (folder / "authority.pem").read_bytes()
    assert ensure(folder, ("10.0.0.5",)) is True
    assert ensure(folder, ("10.0.0.5",)) is False
    assert ensure(folder, ("tower.example.org",)) is True
    assert (folder / "authority.pem").read_bytes() == authority, "what was exported before is still good"
    make(folder)
    assert (folder / "authority.pem").read_bytes() != authority, "what was exported before is worth nothing"
    hosts = ("10.0.0.5", "tower.example.org", "localhost", "10.0.0.6")
    assert unnamed(folder, Role.TOWER_HUB, hosts) == ("10.0.0.6",)


def test_the_user_s_folder_is_taken_when_none_is_set():
    assert folder_of("").parts[-2:] == ("remote-operation-tower", "certificates")
    assert folder_of("~/somewhere") == Path.home() / "somewhere"


def test_many_programs_that_start_at_once_share_one_authority(tmp_path: Path):
    place = tmp_path / "certificates"
    with ThreadPoolExecutor(8) as pool:
        made = list(pool.map(lambda _: make_if_none(place), range(8)))
    assert made.count(True) == 1
    assert missing(place) == ()
    for role in Role:
        certificate(place, role).verify_directly_issued_by(certificate(place, "authority"))
    assert [file.name for file in tmp_path.iterdir()] == ["certificates"]


def test_a_folder_that_holds_anything_is_left_alone(tmp_path: Path):
    (tmp_path / "authority.pem").write_text("from another machine")
    assert make_if_none(tmp_path) is False
    assert [file.name for file in tmp_path.iterdir()] == ["authority.pem"]


def test_a_file_where_the_folder_should_be_is_an_error_that_names_the_setting(tmp_path: Path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(CertificateError, match=r"\[wire.link\] certificates"):
        make_if_none(tmp_path / "taken")
