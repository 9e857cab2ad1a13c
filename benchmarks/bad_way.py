"""A cable between two network namespaces that can be made bad: `python -m benchmarks.bad_way FACTOR NAME=ADDRESS/BITS NAME=...`.

A process of its own with a TUN device in each namespace, both named `way`; every packet goes through benchmarks.impairment. What
it does from now on is a line of JSON on its standard input, `{"forward": {...}, "back": {...}}`, answered by the same line once it
is so; forward is from the first namespace to the second. All times are a drive's own, FACTOR of the real ones. Ends with its
input. Linux, root. Never outside those two namespaces.
"""

import ctypes
import fcntl
import heapq
import os
import random
import select
import struct
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO

import msgspec

from benchmarks.impairment import Impairment, Way, send
from wire.clock import Clock
from wire.messages.base import Message
from wire.pace import raise_priority

DEVICE = "way"
MTU = 1500
NEITHER = (False, False)
PROMPT = 20  # SCHED_FIFO, before every program of a drive: no cable waits for a processor
_CLONE_NEWNET = 0x40000000  # linux/sched.h
_TUNSETIFF, _IFF_TUN, _IFF_NO_PI = 0x400454CA, 0x0001, 0x1000  # linux/if_tun.h


class Both(Message):
    """What either direction does from now on, and what becomes of the packets that are under way: (forward, back)."""

    forward: Impairment = Impairment()
    back: Impairment = Impairment()
    held: tuple[bool, bool] = NEITHER  # nothing comes out; all of it does, in its order, when this is over
    lost: tuple[bool, bool] = NEITHER  # what is under way at this moment never comes out


def tun_in(namespace: str, address: str) -> int:
    """A TUN device in a namespace, up, with its address; its descriptor. This process is in that namespace afterwards."""
    libc = ctypes.CDLL(None, use_errno=True)
    with open(f"/run/netns/{namespace}", "rb") as place:
        if libc.setns(place.fileno(), _CLONE_NEWNET):
            raise OSError(ctypes.get_errno(), f"namespace {namespace}")
    descriptor = os.open("/dev/net/tun", os.O_RDWR | os.O_NONBLOCK)
    fcntl.ioctl(descriptor, _TUNSETIFF, struct.pack("16sH", DEVICE.encode(), _IFF_TUN | _IFF_NO_PI))
    for words in (f"addr add {address} dev {DEVICE}", f"link set {DEVICE} mtu {MTU} up", "link set lo up"):
        subprocess.run(["ip", *words.split()], check=True)
    return descriptor


_Due = tuple[int, int, bytes]  # when it is due, its number, the packet


class Relay:
    """Both directions and what is under way in them."""

    def __init__(self, ends: tuple[int, int], clock: Clock, seed: int = 1) -> None:
        self._ends, self._clock = ends, clock
        self._ways = [Way(), Way()]
        self._under_way: tuple[list[_Due], list[_Due]] = ([], [])  # by the end it came in at
        self._count = 0
        self._draw = random.Random(seed)
        self.setting = Both()

    def step(self, keys: IO[bytes]) -> bool:
        """Wait for the next thing to do and do it. False when there are no more instructions to come."""
        due_ns = [waiting[0][0] for waiting, held in zip(self._under_way, self.setting.held, strict=True) if waiting and not held]
        wait_s = self._clock.real_s(max(min(due_ns) - self._clock.now_ns(), 0)) if due_ns else None
        ready, _, _ = select.select([*self._ends, keys.fileno()], [], [], wait_s)
        for end in (0, 1):
            if self._ends[end] in ready:
                self._take(end)
            if not self.setting.held[end]:
                self._let_out(self._under_way[end], self._ends[1 - end])
        return keys.fileno() not in ready or self._obey(keys)

    def _take(self, end: int) -> None:
        packet = os.read(self._ends[end], 65536)
        impairment = self.setting.back if end else self.setting.forward
        self._ways[end], comes = send(self._ways[end], packet, self._clock.now_ns(), impairment, self._draw)
        for due_ns, out in comes:
            self._count += 1
            heapq.heappush(self._under_way[end], (due_ns, self._count, out))

    def _let_out(self, waiting: list[_Due], to: int) -> None:
        now_ns = self._clock.now_ns()
        while waiting and waiting[0][0] <= now_ns:
            _, _, packet = heapq.heappop(waiting)
            try:
                os.write(to, packet)
            except BlockingIOError:  # no room in the device: lost, as on any full line
                continue

    def _obey(self, keys: IO[bytes]) -> bool:
        line = keys.readline()
        if not line:
            return False
        self.follow(msgspec.json.decode(line, type=Both))
        os.write(1, line)
        return True

    def follow(self, setting: Both) -> None:
        self.setting = setting
        for waiting, lost in zip(self._under_way, setting.lost, strict=True):
            if lost:
                waiting.clear()


class BadWay:
    """The relay's process, from outside."""

    def __init__(self, process: "subprocess.Popen[bytes]", clock: Clock) -> None:
        self._process, self._clock = process, clock

    def be(
        self,
        forward: Impairment | None = None,
        back: Impairment | None = None,
        held: tuple[bool, bool] = NEITHER,
        lost: tuple[bool, bool] = NEITHER,
    ) -> int:
        """Both directions do this from now on; perfect where nothing is said. When that was so [ns, its clock]."""
        keys, answers = self._process.stdin, self._process.stdout
        if keys is None or answers is None:
            raise RuntimeError("the relay has no pipes")
        both = Both(forward=forward or Impairment(), back=back or Impairment(), held=held, lost=lost)
        keys.write(msgspec.json.encode(both) + b"\n")
        keys.flush()
        if not answers.readline():
            raise RuntimeError(f"the relay has ended with {self._process.wait()}")
        return self._clock.now_ns()


@contextmanager
def bad_way(first: tuple[str, str], second: tuple[str, str], clock: Clock) -> Iterator[BadWay]:
    """Join two namespaces, each (its name, ADDRESS/BITS); perfect until it is told otherwise. Leaving the context cuts it."""
    process = subprocess.Popen(
        [sys.executable, "-m", "benchmarks.bad_way", str(clock.real_time_factor), "=".join(first), "=".join(second)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    try:
        way = BadWay(process, clock)
        way.be()
        yield way
    finally:
        process.kill()
        process.wait()


def main(arguments: list[str]) -> int:
    raise_priority(PROMPT)
    factor, *places = arguments
    ends = [tun_in(*each.split("=", 1)) for each in places]
    relay = Relay((ends[0], ends[1]), Clock(0, float(factor)))
    keys = os.fdopen(0, "rb", buffering=0)
    while relay.step(keys):
        pass
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
