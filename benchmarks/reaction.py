"""How soon the car acts when the operator's side fails: the real cockpit, gateway, ECU and car of benchmarks.wheel_to_can.

Of two namespaces with a bad way between them and the scripted operator (benchmarks.warm_rig; needs root): the stalled link.

flooded  10,000 junk messages a second on the command key while wheel events are timed; beside it the same without
stands   the cockpit stands still for a second: how old is the oldest command that a cycle of the gateway used
stalled  the link stands still for a second while the cockpit goes on sending; what it kept comes afterwards: the same
killed   SIGKILL of the cockpit to the first CAN frame that brakes, the car rolling; and how long after the limit of silence
"""

import os
import signal
import subprocess
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic_ns

import msgspec

from benchmarks.datagram_wheel import PROFILE
from benchmarks.fault_commands import Used
from benchmarks.fault_intruder import INTRUDER, got_ready
from benchmarks.fault_link_stall import stalls
from benchmarks.figures import Figure, figure, percentile
from benchmarks.wheel_to_can import driven
from vehicle_gateway.failsafe import Cause, FailsafeLimits
from vehicle_gateway.state import Inputs, Outputs
from wire.clock import Clock
from wire.configuration import read_sections
from wire.link import open_link
from wire.messages.vehicle import GatewayCycle
from wire.settings import PaceSettings, WireSettings
from wire.topics import Role

NAME = "reaction"
FIFO = PaceSettings().fifo_priority
KILLS = 5
STALLS = 3  # of the link, each kind
STALL_S, AFTER_S = 1.0, 2.0  # what came late has come by then
FLOODED = 1000  # messages dropped: it has begun
ROLLS_M_S = 0.5
FLOOD_RATIO, BRAKES_WITHIN_MS, CYCLE_MS = 2.0, 150.0, 10.0  # the reaches; the last: one cycle
LIMITS = FailsafeLimits()
_INPUTS, _OUTPUTS = msgspec.json.Decoder(Inputs), msgspec.json.Decoder(Outputs)


def figures() -> Iterator[Figure]:
    yield from one_session()
    killed = [kill_once() for _ in range(KILLS)]
    case = f"cockpit killed, {KILLS} times"
    yield figure(NAME, case, "worst, to the braking frame", "ms", max(ms for ms, _ in killed), at_most=BRAKES_WITHIN_MS)
    yield figure(NAME, case, "worst, limit to braking cycle", "ms", max(ms for _, ms in killed), at_most=CYCLE_MS)
    yield from stalled_link()


def stalled_link() -> Iterator[Figure]:
    for how, seen in stalls(STALLS).items():
        case = f"link stalls {how.seconds:g} s, {STALLS} times; {how.words}"
        oldest_ms = max(each.oldest_ms for each in seen)
        yield figure(NAME, case, "oldest command used", "ms", oldest_ms, at_most=Used.limit_ms)
        yield figure(NAME, case, "used beyond the limit", "", sum(each.too_old for each in seen), at_most=0)
        yield figure(NAME, case, "refused, least", "", min(each.refused.total() for each in seen))


def one_session() -> Iterator[Figure]:
    """Flooded, then standing still."""
    with tempfile.TemporaryDirectory(prefix="reaction-") as folder, driven(Path(folder), FIFO) as (bench, config, cockpit):
        quiet = ("without it", percentile(bench.events()[0], 0.99))
        with flooding(config):
            bench.wait(lambda: bench.status is not None and sum(bench.status.dropped.values()) > FLOODED, "the flood")
            flooded = percentile(bench.events()[0], 0.99)
        yield figure(NAME, "10,000 junk messages/s", "wheel to CAN p99", "ms", flooded, peer=quiet, ratio_at_most=FLOOD_RATIO)
        with watched(config) as cycles:
            os.kill(cockpit, signal.SIGSTOP)
            bench.pause(STALL_S)
            os.kill(cockpit, signal.SIGCONT)
            bench.pause(AFTER_S)
        oldest = max(cycles.ages_ms)
        yield figure(NAME, f"cockpit stands for {STALL_S:g} s", "oldest command used", "ms", oldest, at_most=LIMITS.loop_age_max_ms)


@contextmanager
def flooding(config: Path) -> Iterator[None]:
    """10,000 junk messages a second on the command key, from here on."""
    with got_ready(subprocess.Popen((sys.executable, "-m", INTRUDER, "flood", str(config)), stdout=subprocess.PIPE)) as flood:
        flood.begin()
        yield


def kill_once() -> tuple[float, float]:
    """Milliseconds from the kill to the first frame that brakes, and from the limit of silence to the cycle that knew."""
    with (
        tempfile.TemporaryDirectory(prefix="reaction-") as folder,
        driven(Path(folder), FIFO) as (bench, config, cockpit),
        watched(config) as cycles,
    ):
        bench.inject(**{PROFILE.throttle.axis: PROFILE.throttle.pressed})
        bench.wait(lambda: (state := bench.state.get()) is not None and state.message.speed_m_s > ROLLS_M_S, "the car to roll")
        begun_ns = monotonic_ns()
        os.kill(cockpit, signal.SIGKILL)
        bench.wait(lambda: bench.braked_ns > begun_ns and cycles.silent_ns > begun_ns, "the car to brake")
        return (bench.braked_ns - begun_ns) / 1e6, (cycles.silent_ns - cycles.heard_ns) / 1e6 - LIMITS.command_gentle_ms


class Cycles:
    """What the gateway's cycles tell: the ages of the commands they used, and when one first missed them."""

    def __init__(self) -> None:
        self.ages_ms: list[float] = []
        self.heard_ns = self.silent_ns = 0

    def take(self, cycle: GatewayCycle, _: int) -> None:
        inputs = _INPUTS.decode(cycle.inputs)
        if inputs.command is not None:
            self.ages_ms.append((cycle.now_ns - inputs.command.echoed_vehicle_ns) / 1e6)
            self.heard_ns, self.silent_ns = inputs.command_ns, 0
        elif self.silent_ns == 0 and Cause.COMMAND_SILENT in _OUTPUTS.decode(cycle.outputs).causes:
            self.silent_ns = cycle.now_ns


@contextmanager
def watched(config: Path) -> Iterator[Cycles]:
    cycles, stop = Cycles(), threading.Event()
    with open_link(read_sections(config, {"wire": WireSettings})["wire"].link, Role.RECORDER, Clock(), stop) as link:
        link.on("gateway_cycle", cycles.take)
        yield cycles
