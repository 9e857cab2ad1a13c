"""STUN and TURN servers of the video session: sections [wire.ice] and [[wire.ice.servers]]. Both sites have the same.

Without any, only addresses of the machines themselves are tried, which is enough where one can reach the other: in one network,
or through a VPN. Passwords stand in a file or in the environment, never in the configuration: that is stored in every recording.
"""

import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from wire.configuration import ConfigurationError
from wire.messages.base import Message, Name, Text
from wire.private_file import refusal

GATHER_S = 1.0  # for a server's answer; the car's whole answer may take 1.5 s. A server that is silent costs this much per session


class IceServer(Message):
    url: Annotated[str, Meta(pattern=r"^(stun:[^\s/?]+|turns?:[^\s/?]+(\?transport=(udp|tcp))?)$", max_length=300)]
    username: Text = ""  # TURN only
    password_file: Text = ""  # a file with the password alone, for its owner's eyes only
    password_variable: Name = ""  # or the environment variable that holds it


class IceSettings(Message):
    servers: tuple[IceServer, ...] = ()  # at most one STUN and one TURN server are used
    relay_only: bool = False  # all video through the TURN server: where nothing else passes, or no address may be told

    def __post_init__(self) -> None:
        kinds = ["turn" if server.url.startswith("turn") else "stun" for server in self.servers]
        if len(set(kinds)) < len(kinds):
            raise ValueError("servers: at most one stun: and one turn: server are used; remove the others")
        if self.relay_only and "turn" not in kinds:
            raise ValueError("relay_only: needs a turn: server in [[wire.ice.servers]]")


@dataclass(frozen=True, slots=True)
class Server:
    """A server with its password, for the library."""

    url: str
    username: str = ""
    password: str = field(default="", repr=False)


@dataclass(frozen=True, slots=True)
class Ways:
    """How the two ends of the video may find each other."""

    servers: tuple[Server, ...] = ()
    relay_only: bool = False


DIRECT = Ways()  # no server at all


def ways(settings: IceSettings) -> Ways:
    """With the passwords read. Raises ConfigurationError that names the fix."""
    return Ways(tuple(_with_password(server) for server in settings.servers), settings.relay_only)


def _with_password(server: IceServer) -> Server:
    if not server.url.startswith("turn"):
        return Server(server.url)
    if not server.username or bool(server.password_file) == bool(server.password_variable):
        raise ConfigurationError(f"[[wire.ice.servers]] {server.url}: needs username, and password_file or password_variable")
    password = _from_file(Path(server.password_file).expanduser()) if server.password_file else _from_environment(server)
    return Server(server.url, server.username, password)


def _from_file(file: Path) -> str:
    try:
        problem = refusal(file)
        if problem:
            raise ConfigurationError(problem)
        return file.read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigurationError(f"[[wire.ice.servers]] password_file {file}: cannot be read: {error}") from None


def _from_environment(server: IceServer) -> str:
    password = os.environ.get(server.password_variable, "")
    if not password:
        raise ConfigurationError(f"[[wire.ice.servers]] {server.url}: set the environment variable {server.password_variable}")
    return password
