"""Free ports are different ones, are free, and are none that the kernel would give to somebody else meanwhile."""

import socket
from pathlib import Path

import pytest

from wire.ports import free_udp_ports

GIVEN = Path("/proc/sys/net/ipv4/ip_local_port_range")


def test_free_ports_are_different_ones_and_anybody_may_listen_there():
    found = free_udp_ports(8)
    assert len(set(found)) == 8
    for port in found:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as each:
            each.bind(("127.0.0.1", port))


@pytest.mark.skipif(not GIVEN.exists(), reason="tells its range elsewhere: not Linux")
def test_the_kernel_gives_none_of_them_to_a_socket_that_names_no_port():
    lowest = int(GIVEN.read_text().split()[0])
    assert all(port < lowest for port in free_udp_ports(200))


def test_one_that_is_taken_is_passed_over_and_too_few_are_said():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as holder:
        (taken,) = free_udp_ports(1)
        holder.bind(("127.0.0.1", taken))
        with pytest.raises(OSError, match=r"fewer than 1 free UDP ports .* end other sessions"):
            free_udp_ports(1, range(taken, taken + 1))
    assert free_udp_ports(1, range(taken, taken + 1)) == [taken]
