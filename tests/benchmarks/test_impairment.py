"""Tests of benchmarks/impairment.py and, where namespaces can be made, of the real cable in benchmarks/bad_way.py."""

import os
import random
import select
import socket
import subprocess
import sys

import pytest

from benchmarks.bad_way import Both, Relay, bad_way
from benchmarks.impairment import HELD_MAX_S, Impairment, Way, changed, send
from benchmarks.two_machines import missing
from wire.clock import Clock

NOW_NS = 1_000_000_000
UDP = bytes([0x45, 0, 0, 40, 0, 0, 0, 0, 64, 17, 0, 0, *range(8), 1, 2, 3, 4, 0, 20, 0xAB, 0xCD]) + b"twelve bytes"
TCP = UDP[:9] + bytes([6]) + UDP[10:]


def through(impairment: Impairment, packets: int, seed: int = 3) -> list[tuple[tuple[int, bytes], ...]]:
    """Each packet a millisecond after the one before."""
    way, draw, out = Way(), random.Random(seed), []
    for number in range(packets):
        way, comes = send(way, UDP, NOW_NS + number * 1_000_000, impairment, draw)
        out.append(comes)
    return out


def test_a_perfect_way_gives_every_packet_at_once_as_it_was():
    assert through(Impairment(), 3) == [((NOW_NS + number * 1_000_000, UDP),) for number in range(3)]


def test_total_loss_lets_nothing_through_and_a_tenth_about_a_tenth():
    assert not any(through(Impairment(loss=1.0), 100))
    lost = sum(not comes for comes in through(Impairment(loss=0.1), 2000))
    assert 150 < lost < 250


def test_delayed_packets_keep_their_order_whatever_the_jitter():
    due = [comes[0][0] for comes in through(Impairment(delay_ms=20.0, jitter_ms=30.0), 500)]
    assert due == sorted(due)
    assert min(at - NOW_NS - number * 1_000_000 for number, at in enumerate(due)) >= 20_000_000


def test_a_reordered_packet_overtakes_those_before_it():
    due = [comes[0][0] for comes in through(Impairment(delay_ms=20.0, reorder=0.2), 200)]
    assert due != sorted(due)


def test_a_doubled_packet_comes_twice():
    assert all(len(comes) == 2 for comes in through(Impairment(duplicate=1.0), 5))


def test_a_narrow_way_spaces_packets_by_their_size_and_drops_what_its_buffer_cannot_hold():
    bits = len(UDP) * 8
    comes = through(Impairment(rate_kbps=bits / 10.0), 3000)  # one packet takes 10 ms, and they come every one
    passed = [each[0][0] for each in comes if each]
    assert all(b - a == 10_000_000 for a, b in zip(passed, passed[1:], strict=False))
    assert len(passed) == pytest.approx((3.0 + HELD_MAX_S) / 0.01, abs=3)


def test_one_bit_of_a_udp_payload_is_turned_and_the_checksum_says_none():
    twisted = changed(UDP, random.Random(5))
    differing = [a ^ b for a, b in zip(UDP[28:], twisted[28:], strict=True) if a != b]
    assert [bin(each).count("1") for each in differing] == [1]
    assert twisted[26:28] == b"\0\0"
    assert (twisted[:26], len(twisted)) == (UDP[:26], len(UDP))


@pytest.mark.parametrize("packet", [b"", b"\x60" + bytes(60), TCP, UDP[:28]], ids=["nothing", "IPv6", "TCP", "no payload"])
def test_what_is_no_udp_over_ipv4_is_never_changed(packet):
    assert changed(packet, random.Random(5)) == packet


ECHO = """
import socket
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.bind(("10.214.0.2", 7000))
print(flush=True)
while True:
    s.sendto(*s.recvfrom(2000))
"""
ASK = """
import socket, sys, time
s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
s.settimeout(float(sys.argv[1]))
began = time.monotonic()
s.sendto(b"hello", ("10.214.0.2", 7000))
try:
    print(s.recv(2000).decode(), time.monotonic() - began)
except TimeoutError:
    print("lost", 0)
"""


def test_what_is_held_comes_in_its_order_when_that_is_over_and_what_is_lost_under_way_never_comes():
    """The relay on two pairs of sockets in place of its devices."""
    (here, tower), (there, car) = (socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM) for _ in range(2))
    quiet, keys = os.pipe()  # nobody presses any
    with here, tower, there, car, os.fdopen(quiet, "rb", buffering=0) as instructions, os.fdopen(keys, "wb"):
        relay = Relay((here.fileno(), there.fileno()), Clock())
        car.setblocking(False)

        def cross(setting: Both, *packets: bytes) -> list[bytes]:
            relay.follow(setting)
            for packet in packets:
                tower.send(packet)
                relay.step(instructions)
            return list(iter(lambda: car.recv(9) if select.select([car], [], [], 0)[0] else b"", b""))

        assert cross(Both(), b"a") == [b"a"]
        assert cross(Both(held=(True, False)), b"b", b"c") == []
        assert cross(Both(held=(True, False)), b"d") == []
        assert cross(Both(), b"e") == [b"b", b"c", b"d", b"e"]
        assert cross(Both(held=(True, False)), b"f") == []
        assert cross(Both(lost=(False, True)), b"g") == [b"f", b"g"]  # the other direction
        assert cross(Both(held=(True, False)), b"h") == []
        assert cross(Both(lost=(True, False)), b"i") == [b"i"]


@pytest.mark.skipif(bool(missing()), reason=missing() or "namespaces")
def test_a_real_datagram_crosses_the_cable_late_when_it_is_slow_and_not_at_all_when_it_is_black():
    names = [f"rot-way-{os.getpid()}-{end}" for end in "ab"]
    for name in names:
        subprocess.run(["ip", "netns", "add", name], check=True)
    try:
        with bad_way((names[0], "10.214.0.1/24"), (names[1], "10.214.0.2/24"), Clock()) as way:
            command = ["ip", "netns", "exec", names[1], sys.executable, "-c", ECHO]
            with subprocess.Popen(command, stdout=subprocess.PIPE) as echo:
                echo.stdout.readline()
                asked = []
                for impairment, patience_s in (
                    (Impairment(), 10.0),
                    (Impairment(delay_ms=150.0), 10.0),
                    (Impairment(loss=1.0), 0.3),
                ):
                    way.be(forward=impairment)
                    ask = ["ip", "netns", "exec", names[0], sys.executable, "-c", ASK, str(patience_s)]
                    asked.append(subprocess.run(ask, capture_output=True, text=True, check=True).stdout.split())
                echo.kill()
    finally:
        for name in names:
            subprocess.run(["ip", "netns", "delete", name], check=True)
    assert [word for word, _ in asked] == ["hello", "hello", "lost"]
    assert float(asked[1][1]) > 0.15
