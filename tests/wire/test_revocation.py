"""What the authority has revoked is worth nothing where its list has come to; and a certificate that expires cuts its link."""

import shutil
import threading
from collections.abc import Callable
from contextlib import ExitStack
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from msgspec.structs import replace

from wire import bundle, certificates
from wire.access import admitted
from wire.authority import common_name, issue, life_of, new_authority
from wire.certificates import CertificateError, authority_of, check, revocations_of, take_revocations
from wire.clock import Clock
from wire.link import Link, LinkError, open_link
from wire.messages.base import encode
from wire.messages.operating import ClockPing, WindowStatus
from wire.ports import free_addresses
from wire.revocation import NOTHING, Revocations, parted, read_revocations, with_revoked
from wire.settings import LinkSettings
from wire.topics import Role, owner_of, role_of

AUTHORITY = new_authority()
STATUS = WindowStatus(stamp_ns=1, sequence=0, displayed_capture_ns={}, frozen=False, shown=(), frames_dropped=0)


def name_in(folder: Path, role: Role) -> str:
    return common_name(certificates._load(folder / f"{role}.pem"))


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from(["window", "tower-hub.ann", "video.car-1"]), max_size=8))
def test_after_any_revocations_exactly_the_newest_certificate_of_each_name_is_good(names: list[str]):
    known, issued = NOTHING, {name: [name] for name in ("window", "tower-hub.ann", "video.car-1")}
    for name in names:
        known = with_revoked(known, name, AUTHORITY)
        issued[name].append(known.current(name))
    assert known.number == len(names)
    for name, all_of_it in issued.items():
        assert [known.is_revoked(each) for each in all_of_it] == [True] * (len(all_of_it) - 1) + [False]
        assert all(parted(each)[0] == name for each in all_of_it)
        assert len(set(all_of_it)) == len(all_of_it)
    assert read_revocations(encode(known), AUTHORITY.certificate) == known


def test_a_generation_changes_neither_role_nor_owner():
    assert (role_of("tower-hub.ann~3"), owner_of("tower-hub.ann~3")) == (Role.TOWER_HUB, "ann")
    assert (role_of("window~1"), owner_of("window~1")) == (Role.WINDOW, "")
    assert role_of("nobody~1") is None


def test_a_list_that_the_authority_did_not_sign_is_none():
    known = with_revoked(NOTHING, "window", AUTHORITY)
    for forged in (
        replace(known, generations={}),
        replace(known, number=9),
        replace(known, signature="00"),
        replace(known, signature="no"),
        with_revoked(NOTHING, "window", new_authority()),
        Revocations(number=1),
    ):
        with pytest.raises(ValueError, match="not signed"):
            read_revocations(encode(forged), AUTHORITY.certificate)
    with pytest.raises(ValueError, match="damaged"):
        read_revocations(b"{", AUTHORITY.certificate)


@pytest.fixture
def home(tmp_path: Path) -> Path:
    certificates.make(tmp_path / "certificates")
    return tmp_path / "certificates"


def test_where_the_authority_is_a_revoked_role_gets_its_next_certificate_at_once(home: Path):
    key = (home / "window.key").read_bytes()
    certificates.revoke(home, "window")
    assert name_in(home, Role.WINDOW) == "window~1" and (home / "window.key").read_bytes() != key
    check(home, Role.WINDOW, "car-1")
    certificates.revoke(home, "window~1")
    assert name_in(home, Role.WINDOW) == "window~2"
    assert certificates.ensure(home, ("10.0.0.5",))
    assert name_in(home, Role.WINDOW) == "window~2", "made anew under a name that was revoked"
    with pytest.raises(CertificateError, match="they begin with one of: vehicle-hub"):
        certificates.revoke(home, "nobody")


def test_another_machine_learns_it_from_a_list_or_from_its_next_bundle_and_never_forgets(home: Path, tmp_path: Path):
    there, late = tmp_path / "there", tmp_path / "late"
    first = bundle.export(home, "car-1", (), False)
    for folder in (there, late):
        bundle.install(first, folder, replace=False)
    certificates.revoke(home, "video.car-1")
    bundle.write_list(revocations_of(home), tmp_path / "list.json")
    assert bundle.is_list(tmp_path / "list.json")
    assert take_revocations(there, bundle.read_list(tmp_path / "list.json", there)) is True
    assert take_revocations(there, bundle.read_list(tmp_path / "list.json", there)) is False
    with pytest.raises(CertificateError, match=r"video.pem was revoked; import a bundle"):
        check(there, Role.VIDEO, "car-1")
    check(there, Role.AUTONOMY, "car-1")
    bundle.install(first, there, replace=False)  # an old bundle does not make it good again
    with pytest.raises(CertificateError, match="was revoked"):
        check(there, Role.VIDEO, "car-1")
    bundle.install(bundle.export(home, "car-1", (), False), late, replace=False)
    assert name_in(late, Role.VIDEO) == "video.car-1~1"
    check(late, Role.VIDEO, "car-1")


def test_a_list_of_another_authority_is_refused_and_a_new_authority_begins_with_none(home: Path, tmp_path: Path):
    certificates.make(tmp_path / "other")
    certificates.revoke(tmp_path / "other", "window")
    bundle.write_list(revocations_of(tmp_path / "other"), tmp_path / "list.json")
    with pytest.raises(CertificateError, match="not signed by the authority"):
        bundle.read_list(tmp_path / "list.json", home)
    shutil.copy(tmp_path / "list.json", home / "revoked.json")
    with pytest.raises(CertificateError, match=r"revoked.json: the list"):
        check(home, Role.WINDOW, "car-1")
    certificates.make(tmp_path / "other")
    assert revocations_of(tmp_path / "other") == NOTHING
    assert name_in(tmp_path / "other", Role.WINDOW) == "window"


def test_a_person_s_bundle_carries_his_name_and_only_he_is_let_in_where_persons_are_named(home: Path, tmp_path: Path):
    made = bundle.export(home, "", (), False, supervisor=True, person="ann")
    bundle.write(made, tmp_path / "ann.bundle")
    bundle.install(bundle.read(tmp_path / "ann.bundle"), tmp_path / "ann", replace=False)
    assert name_in(tmp_path / "ann", Role.TOWER_HUB) == "tower-hub.ann"
    assert name_in(tmp_path / "ann", Role.TOWER_SUPERVISOR) == "tower-supervisor.ann"
    assert name_in(tmp_path / "ann", Role.WINDOW) == "window"
    check(tmp_path / "ann", Role.TOWER_HUB, "car-1")
    named = admitted(LinkSettings(operators=("ann", "bob")), with_revoked(NOTHING, "tower-hub.bob", AUTHORITY))
    assert named(Role.TOWER_HUB, "car-1") == ("tower-hub.ann", "tower-hub.bob~1")
    assert named(Role.VIDEO, "car-1") == ("video", "video.car-1")
    assert admitted(LinkSettings())(Role.TOWER_HUB, "car-1") == ("tower-hub",)


@pytest.mark.parametrize("life", [timedelta(hours=2), timedelta(days=7)])
def test_they_live_as_long_as_was_asked_for_and_are_renewed_for_as_long(tmp_path: Path, life: timedelta):
    folder = tmp_path / "certificates"
    assert certificates.ensure(folder, valid=life)
    assert life_of(certificates._load(folder / "window.pem")) == pytest.approx(life, abs=timedelta(seconds=2))
    assert certificates.ensure(folder) is False
    assert certificates.ensure(folder, valid=life) is False
    assert certificates.ensure(folder, hosts=("10.0.0.5",))
    assert certificates.earliest_end(folder) - datetime.now(UTC) == pytest.approx(life, abs=timedelta(seconds=20))
    assert certificates.ensure(folder, valid=timedelta(days=1)) is True


def test_nothing_outlives_the_authority():
    assert issue("window", (), AUTHORITY, timedelta(days=9999)).certificate.not_valid_after_utc == (
        AUTHORITY.certificate.not_valid_after_utc
    )


# on the real link ------------------------------------------------------------------------------------------------------------


def settings_of(folder: Path) -> LinkSettings:
    car, tower = free_addresses(2)
    return LinkSettings(certificates=str(folder), car_hub=car, tower_hub=tower)


def opened(stack: ExitStack, settings: LinkSettings, role: Role, hub: bool = False) -> Link:
    return stack.enter_context(open_link(settings, role, Clock(), threading.Event(), hub=hub))


def until(done: Callable[[], object], meanwhile: Callable[[], object] = lambda: None) -> None:
    for _ in range(800):
        meanwhile()
        if done():
            return
        threading.Event().wait(0.01)
    raise AssertionError("it did not come in time")


def test_a_revoked_window_is_nobody_at_its_hub_while_the_next_one_is_heard(home: Path, tmp_path: Path):
    """The stolen copy of the folder knows of no list: it would start; the hub does not listen to it."""
    shutil.copytree(home, tmp_path / "stolen")
    certificates.revoke(home, "window")
    settings = settings_of(home)
    with ExitStack() as stack:
        hub = opened(stack, settings, Role.TOWER_HUB, hub=True)
        heard: list[int] = []
        hub.on("window_status", lambda status, _: heard.append(status.stamp_ns))
        stolen = opened(stack, replace(settings, certificates=str(tmp_path / "stolen")), Role.WINDOW)
        window = opened(stack, settings, Role.WINDOW)

        def speak() -> None:
            stolen.publish("window_status", replace(STATUS, stamp_ns=666))
            window.publish("window_status", STATUS)

        until(lambda: len(heard) > 20, speak)
        assert 666 not in heard
    take_revocations(tmp_path / "stolen", revocations_of(home))
    with (
        pytest.raises(LinkError, match="was revoked"),
        open_link(settings_of(tmp_path / "stolen"), Role.WINDOW, Clock(), threading.Event()),
    ):
        pass


def test_a_tower_whose_certificate_expires_is_cut_off_at_that_very_second(home: Path):
    """The certificate lives some four seconds of an open session; that it was heard until then shows that nothing else cut it."""
    short = issue("tower-hub", (), authority_of(home), timedelta(seconds=4))
    certificates.write_pem(home, Role.TOWER_HUB, short.key_pem, short.certificate_pem)
    ends_s = short.certificate.not_valid_after_utc.timestamp()
    settings = settings_of(home)
    with ExitStack() as stack:
        car = opened(stack, settings, Role.VEHICLE_HUB, hub=True)
        tower = opened(stack, settings, Role.TOWER_HUB, hub=True)
        last = [0.0]
        car.on("clock_ping", lambda _, __: last.__setitem__(0, datetime.now(UTC).timestamp()))

        def speak() -> None:
            tower.publish("clock_ping", ClockPing(number=1, sent_ns=1))

        until(lambda: datetime.now(UTC).timestamp() > ends_s + 1.5, speak)
        assert ends_s - 1.0 < last[0] < ends_s + 1.0
        assert tower.sites == 0
