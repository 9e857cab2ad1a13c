"""Certificates for another machine: only what it needs, bound to what it is, whole or refused with the fix."""

import json
import stat
from datetime import UTC, datetime, timedelta
from hashlib import sha256
from pathlib import Path

import msgspec
import pytest
from cryptography import x509
from cryptography.x509.oid import NameOID

from wire import certificates
from wire.authority import issue, new_authority
from wire.bundle import Bundle, Issued, ends, export, install, read, write
from wire.certificates import CertificateError, authority_of, check, ensure, make
from wire.messages.base import encode
from wire.topics import CAR, TOWER, Role


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("authority") / "certificates"
    make(folder)
    return folder


@pytest.fixture
def carried(home: Path, tmp_path: Path) -> Path:
    file = tmp_path / "car-1.bundle"
    write(export(home, "car-1", ("10.0.0.2", "car.local"), with_simulation=False), file)
    return file


def certificate(pem: str) -> x509.Certificate:
    return x509.load_pem_x509_certificate(pem.encode())


def test_a_car_s_bundle_holds_the_car_s_roles_and_a_tower_s_the_tower_s_and_what_only_simulates_on_request(home: Path):
    assert set(export(home, "car-1", (), False).roles) == CAR - {Role.SIMULATE}
    assert set(export(home, "car-1", (), True).roles) == CAR
    assert set(export(home, "", (), False).roles) == TOWER - {Role.TOWER_SCRIPT, Role.TOWER_SUPERVISOR}
    assert set(export(home, "", (), True).roles) == TOWER - {Role.TOWER_SUPERVISOR}
    assert set(export(home, "", (), False, supervisor=True).roles) == TOWER - {Role.TOWER_SCRIPT}


def test_the_authority_s_key_is_in_no_bundle(home: Path):
    key = "".join((home / "authority.key").read_text().splitlines()[1:-1])
    for vehicle_id in ("car-1", ""):
        assert key not in encode(export(home, vehicle_id, (), True)).decode().replace("\\n", "")


def test_a_car_s_certificates_name_the_car_and_its_hosts(home: Path):
    bundle = export(home, "car-1", ("10.0.0.2", "car.local", "[fe80::1]"), False)
    for role, issued in bundle.roles.items():
        names = [each.value for each in certificate(issued.certificate).subject.get_attributes_for_oid(NameOID.COMMON_NAME)]
        assert names == [f"{role}.car-1"]
    hosts = certificate(bundle.roles[Role.VEHICLE_HUB].certificate).extensions.get_extension_for_class(x509.SubjectAlternativeName)
    assert {str(each) for each in hosts.value.get_values_for_type(x509.IPAddress)} == {"127.0.0.1", "10.0.0.2", "fe80::1"}
    assert set(hosts.value.get_values_for_type(x509.DNSName)) == {"localhost", "car.local"}


def test_what_was_imported_is_good_for_its_car_and_no_other_and_never_made_anew(carried: Path, tmp_path: Path):
    folder = tmp_path / "there"
    install(read(carried), folder, replace=False)
    check(folder, Role.VEHICLE_HUB, "car-1")
    with pytest.raises(CertificateError, match=r"issued for vehicle-hub.car-1, not for vehicle-hub.car-2"):
        check(folder, Role.VEHICLE_HUB, "car-2")
    with pytest.raises(CertificateError, match="import a bundle"):
        check(folder, Role.TOWER_HUB, "car-1")
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    assert ensure(folder) is False
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    assert "authority.key" not in before
    for refused in (lambda: make(folder), lambda: export(folder, "car-2", (), False)):
        with pytest.raises(CertificateError, match="imported, nothing can be issued here"):
            refused()


def test_bundle_and_keys_are_readable_by_their_owner_only(carried: Path, tmp_path: Path):
    install(read(carried), tmp_path / "there", replace=False)
    for file in (carried, *(tmp_path / "there").glob("*.key")):
        assert stat.S_IMODE(file.stat().st_mode) == 0o600, file


def test_importing_again_under_the_same_authority_renews_and_a_stranger_s_needs_replace(home: Path, carried: Path, tmp_path: Path):
    folder = tmp_path / "there"
    install(read(carried), folder, replace=False)
    install(export(home, "car-1", (), True), folder, replace=False)
    assert (folder / "simulate.key").is_file()
    make(tmp_path / "stranger")
    strange = export(tmp_path / "stranger", "car-1", (), False)
    with pytest.raises(CertificateError, match="--replace"):
        install(strange, folder, replace=False)
    install(strange, folder, replace=True)
    check(folder, Role.VIDEO, "car-1")
    assert not (folder / "simulate.key").exists()  # nothing of the old authority is left


def test_an_authority_is_not_overwritten_by_accident(carried: Path, tmp_path: Path):
    make(tmp_path / "own")
    with pytest.raises(CertificateError, match="--replace"):
        install(read(carried), tmp_path / "own", replace=False)
    authority_of(tmp_path / "own")
    install(read(carried), tmp_path / "own", replace=True)
    assert certificates.is_imported(tmp_path / "own")


@pytest.mark.parametrize("cut", [0, 1, 100, -1, -2])
def test_a_bundle_that_was_cut_is_refused(carried: Path, cut: int):
    carried.write_bytes(carried.read_bytes()[:cut])
    with pytest.raises(CertificateError, match="export it again"):
        read(carried)


def test_a_bundle_with_any_letter_changed_is_refused(carried: Path):
    whole = carried.read_bytes()
    for at in range(0, len(whole), 97):
        changed = bytes([whole[at] ^ 1])
        if json_equal(whole, whole[:at] + changed + whole[at + 1 :]):
            continue  # white space between the fields
        carried.write_bytes(whole[:at] + changed + whole[at + 1 :])
        with pytest.raises(CertificateError, match="export it again"):
            read(carried)


def json_equal(one: bytes, other: bytes) -> bool:
    try:
        return bool(json.loads(one) == json.loads(other))
    except ValueError:
        return False


def test_no_file_and_no_authority_are_told_with_the_command(tmp_path: Path):
    with pytest.raises(CertificateError, match="tower certificates export"):
        read(tmp_path / "none.bundle")
    with pytest.raises(CertificateError, match="make them with: tower certificates"):
        export(tmp_path, "car-1", (), False)


def test_a_host_that_is_none_is_told(home: Path):
    with pytest.raises(CertificateError, match="--host größe"):
        export(home, "car-1", ("größe",), False)


def forged(bundle: Bundle, **changes: object) -> Bundle:
    """With a digest that fits: what an accident cannot make."""
    made = msgspec.structs.replace(bundle, **changes, digest="")
    return msgspec.structs.replace(made, digest=sha256(encode(made)).hexdigest())


def test_a_bundle_put_together_by_hand_is_refused(home: Path, tmp_path: Path):
    good = export(home, "car-1", (), False)
    stranger = issue("vehicle-hub.car-1", (), new_authority())
    strange = Issued(key=stranger.key_pem.decode(), certificate=stranger.certificate_pem.decode())
    late = issue("vehicle-hub.car-1", (), authority_of(home), valid=timedelta())
    ended = Issued(key=late.key_pem.decode(), certificate=late.certificate_pem.decode())
    other_key = Issued(key=strange.key, certificate=good.roles[Role.VIDEO].certificate)
    cases = {
        "another authority": forged(good, roles=good.roles | {Role.VEHICLE_HUB: strange}),
        r"issued for \S+\.car-1": forged(good, vehicle_id="car-2"),
        "does not belong": forged(good, roles=good.roles | {Role.VIDEO: other_key}),
        "expired on": forged(good, roles=good.roles | {Role.VEHICLE_HUB: ended}),
        "no certificate for vehicle-hub": forged(good, roles={}),
    }
    for words, bundle in cases.items():
        write(bundle, tmp_path / "forged.bundle")
        with pytest.raises(CertificateError, match=words):
            read(tmp_path / "forged.bundle")


def test_the_ends_that_are_told_are_in_the_future(home: Path):
    assert ends(export(home, "car-1", (), False)) > datetime.now(UTC)
