"""Servers of the video session as configured: passwords from elsewhere, and what is wrong said in one line."""

from pathlib import Path

import pytest

from wire.configuration import ConfigurationError, read_sections
from wire.ice import Server, Ways, ways
from wire.settings import WireSettings

TURN = '[[wire.ice.servers]]\nurl = "turn:relay.example.org:3478?transport=tcp"\nusername = "ann"\n'


def configured(folder: Path, text: str) -> Ways:
    file = folder / "settings.toml"
    file.write_text(text)
    return ways(read_sections(file, {"wire": WireSettings})["wire"].ice)


def test_without_a_section_no_server_is_asked(tmp_path: Path):
    assert configured(tmp_path, "") == Ways()


def test_a_password_comes_from_a_file_for_its_owner_s_eyes_only(tmp_path: Path):
    secret = tmp_path / "secret"
    secret.write_text("s3cret\n")
    secret.chmod(0o600)
    text = f'{TURN}password_file = "{secret}"\n[[wire.ice.servers]]\nurl = "stun:relay.example.org"\n'
    found = configured(tmp_path, text)
    assert found.servers == (
        Server("turn:relay.example.org:3478?transport=tcp", "ann", "s3cret"),
        Server("stun:relay.example.org"),
    )
    assert "s3cret" not in repr(found)
    secret.chmod(0o644)
    with pytest.raises(ConfigurationError, match=f"chmod 600 {secret}"):
        configured(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (TURN, "needs username, and password_file or password_variable"),
        (f'{TURN}password_variable = "ROT_NO_SUCH"\n', "set the environment variable ROT_NO_SUCH"),
        (f'{TURN}password_file = "/no/such/file"\n', "password_file /no/such/file: cannot be read"),
        ('[[wire.ice.servers]]\nurl = "http://relay"\n', "wire.ice.servers"),
        ('[[wire.ice.servers]]\nurl = "stun:a"\n[[wire.ice.servers]]\nurl = "stun:b"\n', "at most one stun: and one turn:"),
        ("[wire.ice]\nrelay_only = true\n", "relay_only: needs a turn: server"),
        ('[[wire.ice.servers]]\nurl = "stun:a"\npassword = "x"\n', "allowed keys: url, username, password_file"),
    ],
)
def test_what_is_missing_is_one_line_that_names_it(tmp_path: Path, text: str, words: str):
    with pytest.raises(ConfigurationError) as told:
        configured(tmp_path, text)
    assert words in str(told.value)
    assert "\n" not in str(told.value)
