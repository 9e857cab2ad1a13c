"""UDP ports on loopback for programs that are started a moment later and told them by configuration.

Below those that the kernel gives to sockets that name none (32768 to 60999 on Linux, 49152 and up by RFC 6335): a session opens
dozens of such, and one of them could have the port before its owner listens there.
"""

import socket
from contextlib import ExitStack
from itertools import islice
from random import SystemRandom

LISTENED_ON = range(20_000, 32_768)


def free_udp_ports(count: int, among: range = LISTENED_ON) -> list[int]:
    """Different ones, at random, that nobody listens on right now. Raises OSError when there are not so many."""
    with ExitStack() as held:
        shuffled = SystemRandom().sample(among, len(among))
        ports = list(islice((port for port in shuffled if _is_held(port, held)), count))
    if len(ports) < count:
        raise OSError(f"fewer than {count} free UDP ports from {among[0]} to {among[-1]} on loopback; end other sessions here")
    return ports


def free_addresses(count: int) -> list[str]:
    """As many `host:port` on loopback."""
    return [f"127.0.0.1:{port}" for port in free_udp_ports(count)]


def _is_held(port: int, held: ExitStack) -> bool:
    each = held.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    try:
        each.bind(("127.0.0.1", port))
    except OSError:
        return False
    return True
