"""A secret is its owner's alone, or refused with the command that makes it so - at every door through which one comes in."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from wire import bundle, certificates
from wire.certificates import CertificateError
from wire.configuration import ConfigurationError
from wire.ice import IceServer, IceSettings, ways
from wire.link import LinkError
from wire.private_file import exposed
from wire.settings import LinkSettings
from wire.topics import Role
from wire.transport import tls_of

FILE = Path("/a/window.key")


@settings(deadline=None)
@given(st.integers(0, 0o777), st.integers(0, 3), st.integers(0, 3))
def test_exactly_what_is_its_reader_s_or_root_s_and_closed_to_everybody_else_is_good(mode: int, owner: int, reader: int):
    """The plainer rule, letter by letter as `ls -l` prints the mode."""
    letters = [name if mode >> (8 - at) & 1 else "-" for at, name in enumerate("rwxrwxrwx")]
    good = (owner == reader or owner == 0) and letters[3:] == ["-"] * 6
    assert (exposed(FILE, mode, owner, reader) == "") == good


def test_the_fix_is_a_command_for_this_very_file():
    assert f"chmod 600 {FILE}" in exposed(FILE, 0o640, 7, 7)
    assert f"chown 7 {FILE}" in exposed(FILE, 0o600, 8, 7)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("keys") / "certificates"
    certificates.make(folder)
    return folder


def opened(folder: Path) -> tuple[tuple[Path, Callable[[], object], type[Exception]], ...]:
    """(a file with a secret, what reads it, how it complains)"""
    password, carried = folder / "turn-password", folder / "car-1.bundle"
    password.write_text("s3cret")
    password.chmod(0o600)
    bundle.write(bundle.export(folder, "car-1", (), False), carried)
    turn = IceSettings(servers=(IceServer(url="turn:relay", username="ann", password_file=str(password)),))
    settings = LinkSettings(certificates=str(folder))
    return (
        (folder / "window.key", lambda: tls_of(settings, Role.WINDOW), LinkError),
        (folder / "authority.key", lambda: certificates.authority_of(folder), CertificateError),
        (folder / "authority.key", lambda: tls_of(settings, Role.WINDOW), LinkError),
        (carried, lambda: bundle.read(carried), CertificateError),
        (password, lambda: ways(turn), ConfigurationError),
    )


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o620, 0o666])
def test_no_door_takes_a_secret_that_others_may_read_or_write(made: Path, mode: int):
    for file, read, complaint in opened(made):
        read()
        file.chmod(mode)
        with pytest.raises(complaint, match=f"chmod 600 {file}"):
            read()
        file.chmod(0o600)
        read()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give a file away")
def test_no_door_takes_a_secret_of_another_user(made: Path):
    for file, read, complaint in opened(made):
        os.chown(file, 65534, -1)
        with pytest.raises(complaint, match="belongs to another user"):
            read()
        os.chown(file, 0, -1)
        read()


def test_an_imported_folder_is_looked_at_as_well(made: Path, tmp_path: Path):
    certificates_there = tmp_path / "there"
    bundle.install(bundle.export(made, "car-1", (), False), certificates_there, replace=False)
    certificates.check(certificates_there, Role.VIDEO, "car-1")
    (certificates_there / "video.key").chmod(0o644)
    with pytest.raises(CertificateError, match="chmod 600"):
        certificates.check(certificates_there, Role.VIDEO, "car-1")
    certificates.check(certificates_there, Role.AUTONOMY, "car-1")
