"""Where a hub listens or dials, as people write it: HOST:PORT, or the Zenoh form quic/HOST:PORT. Pure.

Nothing is looked up here: whether a host exists is found out when it is dialled. QUIC is the only transport (wire.link).
"""

from dataclasses import dataclass

FORM = "write HOST:PORT, for instance 192.168.1.20:7450"
EVERYWHERE = frozenset({"0.0.0.0", "[::]"})
_PORT_MAX = 65535


class EndpointError(ValueError):
    """The text is no endpoint; the message is one line that names the fix."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    host: str  # a name, an IPv4 address, or an IPv6 address in brackets
    port: int

    def __str__(self) -> str:
        return f"{self.host}:{self.port}"

    @property
    def zenoh(self) -> str:
        """The Zenoh form: QUIC, commands as datagrams beside reliable streams."""
        return f"quic/{self}?mixed_rel=1"

    def covers(self, other: "Endpoint") -> bool:
        """Whether listening here already is listening there, so that asking for both would be refused."""
        return self.port == other.port and (self.host in EVERYWHERE or self.host == other.host)


def parse(text: str) -> Endpoint:
    """Raises EndpointError."""
    if not text.isprintable():
        raise EndpointError(f"{text!r}: not an address; {FORM}")
    protocol, slash, rest = text.strip().rpartition("/")
    if slash and protocol != "quic":
        raise EndpointError(f"{text}: the link is QUIC only, not {protocol or 'a path'}; write quic/HOST:PORT, or just HOST:PORT")
    address, _, metadata = rest.partition("?")
    if metadata not in ("", "mixed_rel=1") or "#" in address:
        raise EndpointError(f"{text}: leave out what follows the port, it is set by itself; {FORM}")
    host, colon, port = address.rpartition(":")
    if not colon or host.count("[") != host.count("]"):
        raise EndpointError(f"{text or 'an empty text'}: the port is missing; {FORM}")
    return Endpoint(_host(text, host), _port(text, port))


def _host(text: str, host: str) -> str:
    if ":" in host and not (host.startswith("[") and host.endswith("]")):
        raise EndpointError(f"{text}: an IPv6 address stands in brackets; write [{host}]:PORT")
    if not host or host == "[]" or any(letter.isspace() for letter in host):
        raise EndpointError(f"{text}: the host is missing; {FORM}, or 0.0.0.0:PORT to listen on every address")
    return host


def _port(text: str, port: str) -> int:
    number = int(port) if port.isascii() and port.isdigit() and len(port) <= 5 else 0
    if not 1 <= number <= _PORT_MAX:
        raise EndpointError(f"{text}: {port or 'nothing'} is no port; a number from 1 to {_PORT_MAX} follows the host")
    return number
