"""The real link, QUIC with mutual TLS, between two network namespaces under loss, delay, jitter and blackouts (netem).

Two processes with an address each, joined by a pair of interfaces that does in both directions what a test says. In a blackout
QUIC's congestion window fills, and commands published after that wait in the sender: they come when the link is back, unless
its lease ended first. Here it is shown that none is older than the lease, and that a STOP comes. What an old command is worth
the gateway decides, by the age of its echo.
"""

import re
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import msgspec
import pytest

from wire import certificates
from wire.clock import Clock
from wire.settings import LinkSettings

SITES = ("car", "tower")
CAR_ADDRESS, TOWER_ADDRESS = "10.83.0.1", "10.83.0.2"
PORT = 7460
MOBILE = "delay 20ms 3ms loss 2%"  # each way: a fair mobile connection
POOR = "delay 20ms 3ms loss 10%"
BLACK = "loss 100%"
LEASE_MS = LinkSettings().lease_ms
HELD_UP_1_S = 40.0  # of 50 commands a second; a tower that sends fewer was held up by a busy machine, and its link may have ended
TRIES = 3
EMULATED_MS = 400.0  # that much longer a command may take through two emulated processes


class Ends:
    """Both ends and everything that has arrived at the car's."""

    def __init__(self, stack: ExitStack, system, start, folder: Path) -> None:
        self._stack, self._system, self._start = stack, system, start
        self.commands: list[tuple[int, int, int]] = []  # number, sent, received
        self.stops: dict[int, tuple[int, int]] = {}
        trusted = folder / "certificates"
        certificates.make(trusted, hosts=(CAR_ADDRESS,))
        place = f"{CAR_ADDRESS}:{PORT}"
        self._settings = {
            "car": LinkSettings(certificates=str(trusted), listen=(place,)),
            "tower": LinkSettings(certificates=str(trusted), connect=(place,)),
        }

    def join(self) -> None:
        """Two namespaces and the pair of interfaces between them."""
        for site in SITES:
            self._system(f"ip netns add {site}")
            self._stack.callback(self._system, f"ip netns delete {site}")
        self._system("ip link add to-tower netns car type veth peer name to-car netns tower")
        for site, interface, address in (("car", "to-tower", CAR_ADDRESS), ("tower", "to-car", TOWER_ADDRESS)):
            up = (f"link set {name} up" for name in ("lo", interface))
            self._system(f"ip -n {site} -batch -", f"address add {address}/24 dev {interface}", *up)

    def under(self, netem: str) -> int:
        """Both directions do this from now on; when that was so [ns]."""
        for site, interface in (("car", "to-tower"), ("tower", "to-car")):
            self._system(f"tc -n {site} qdisc replace dev {interface} root netem limit 10000 {netem}")
        return Clock().now_ns()

    def dropped(self) -> int:
        """Packets on their way to the car that netem dropped so far, by the kernel's own count."""
        return int(re.search(r"dropped (\d+)", self._system("tc -s -n tower qdisc show dev to-car")).group(1))

    def start(self, site: str) -> None:
        settings = msgspec.json.encode(self._settings[site]).decode()
        process = self._start("link_end.py", site, settings, namespace=site, piped=True)
        reader = threading.Thread(target=self._listen, args=(process,))
        reader.start()
        self._stack.callback(reader.join)
        self._stack.callback(process.wait)
        self._stack.callback(process.kill)
        if site == "tower":
            self._keys = process.stdin

    def _listen(self, process) -> None:
        for line in process.stdout:
            what, *numbers = line.split()
            number, sent_ns, received_ns = map(int, numbers)
            if what == "command":
                self.commands.append((number, sent_ns, received_ns))
            else:
                self.stops.setdefault(number, (sent_ns, received_ns))

    def press_stop(self) -> None:
        print("stop", file=self._keys, flush=True)

    def since(self, at_ns: int) -> list[tuple[int, int, int]]:
        return [each for each in self.commands if each[2] > at_ns]


@pytest.fixture(scope="module")
def ends(system, start, tmp_path_factory) -> Iterator[Ends]:
    with ExitStack() as stack:
        made = Ends(stack, system, start, tmp_path_factory.mktemp("link"))
        made.join()
        made.under(POOR)
        for site in SITES:
            made.start(site)
        yield made


def test_the_link_comes_up_at_ten_percent_loss_and_commands_arrive(ends, until):
    until(lambda: len(ends.commands) > 20, "declarations survive loss: they travel on reliable streams")


def next_commands(ends, until) -> tuple[list[tuple[int, int, int]], float, float]:
    """Three hundred of them, what share they are of those sent meanwhile, and how many were sent a second."""
    began_ns = Clock().now_ns()
    until(lambda: len(ends.since(began_ns)) > 320, "commands flow")
    seen = ends.since(began_ns)[20:]
    first, last = min(seen), max(seen)
    sent = last[0] - first[0] + 1
    return seen, len(seen) / sent, (sent - 1) * 1e9 / (last[1] - first[1])


def test_commands_over_a_mobile_connection_come_soon_and_once(ends, until, figure):
    ends.under(MOBILE)
    for _ in range(TRIES):
        seen, share, sent_1_s = next_commands(ends, until)
        if share > 0.9 or sent_1_s > HELD_UP_1_S:
            break
    ages_ms = sorted((received - sent) / 1e6 for _, sent, received in seen)
    p50, p99 = ages_ms[len(ages_ms) // 2], ages_ms[int(len(ages_ms) * 0.99)]
    figure(f"link, {MOBILE}: {share:.1%} of {len(seen)} commands arrive, age p50 {p50:.0f} ms, p99 {p99:.0f} ms")
    assert ages_ms[0] > 15.0, "netem does nothing: the figures would be worthless"
    assert share > 0.9
    assert len({number for number, _, _ in seen}) == len(seen)


@pytest.mark.parametrize(("blackout_s", "stop"), [(0.4, 1), (1.0, 2), (5.0, 3)])
def test_after_a_blackout_no_command_older_than_the_lease_arrives_but_the_stop_pressed_in_it_does(
    ends, until, figure, blackout_s, stop
):
    ends.under(MOBILE)
    began_ns, dropped = ends.under(BLACK), ends.dropped()
    ends.press_stop()
    threading.Event().wait(blackout_s)
    until(lambda: ends.dropped() > dropped, "there is a blackout")  # a busy machine may not have let the tower send anything yet
    assert stop not in ends.stops
    over_ns = ends.under(MOBILE)
    until(lambda: len([sent for _, sent, _ in ends.since(over_ns) if sent > over_ns]) > 50, "commands flow again")
    until(lambda: stop in ends.stops, "the STOP comes")
    late = ends.since(over_ns)
    waited = [each for each in late if began_ns < each[1] < over_ns]
    first_ns = min(received for _, sent, received in late if sent > over_ns)
    oldest_ms = max(received - sent for _, sent, received in late) / 1e6
    figure(
        f"link, blackout of {(over_ns - began_ns) / 1e9:.1f} s: {len(waited)} commands of it came afterwards, the oldest of all "
        f"{oldest_ms:.0f} ms old; after it the first new one takes {(first_ns - over_ns) / 1e6:.0f} ms, "
        f"the STOP pressed in it {(ends.stops[stop][1] - over_ns) / 1e6:.0f} ms"
    )
    assert oldest_ms < LEASE_MS + EMULATED_MS
