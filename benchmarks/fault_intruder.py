"""Somebody who does not belong (benchmarks.intruder), in a site's namespace: got ready beforehand, let loose at the instant."""

import signal
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import msgspec

from benchmarks.fault_arms import Arm, Armed, End, Finding, nothing
from benchmarks.fault_commands import Used
from benchmarks.intruder import Followed
from benchmarks.intruder_tower import READY
from benchmarks.rig import RigError
from benchmarks.two_machines import Listener
from benchmarks.warm_rig import WarmRig, log_in, run_in, wait_for_line

INTRUDER = "benchmarks.intruder"
READY_S = 30.0  # his program on a busy machine
HEARD_S = 10.0  # until the cycles are
SIGNATURE = "command signature"  # why the car drops a command without the lease's key
COUNTER = 'reason="can counter"'  # in the log of an ECU that refused a frame


@dataclass(slots=True)
class Loose:
    """An intruder that is ready."""

    process: "subprocess.Popen[bytes]"

    def begin(self) -> None:
        self.process.send_signal(signal.SIGUSR1)

    def end(self) -> bytes:
        """What he has to say in the end; b"" when he was ended before."""
        self.process.terminate()
        try:
            said, _ = self.process.communicate(timeout=10.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            said, _ = self.process.communicate()
        return said


def loosed(loose: Loose, found: Callable[[], Finding] = Finding) -> Armed:
    def hurt(rig: WarmRig) -> End:
        loose.begin()
        return nothing

    return Armed(hurt, found=found)


def intruder(what: str, at_tower: bool) -> Arm:
    @contextmanager
    def arm(rig: WarmRig) -> Iterator[Armed]:
        with intruding(rig, what, at_tower) as loose:
            yield loosed(loose)

    return arm


@contextmanager
def forger(rig: WarmRig) -> Iterator[Armed]:
    """Commands without the lease's key: many came, and no cycle used one."""
    used, before = Used(), _refused(rig)
    with intruding(rig, "forged", at_tower=True) as loose, Listener(rig.sites.car, "gateway_cycle", tell=used.take):
        rig.wait_until("the cycles are heard", lambda: used.cycles, HEARD_S)

        def found() -> Finding:
            refused = _refused(rig) - before
            text = f"{refused} forged commands refused, {used.forged} of {len(used.uses)} used were forged"
            return Finding(refused > 0 and used.forged == 0 and len(used.uses) > 0, text)

        yield loosed(loose, found)


@contextmanager
def looker_on(rig: WarmRig) -> Iterator[Armed]:
    """Another tower's window: it gets pictures, and takes none from the one that drives."""
    with intruding(rig, "looker", at_tower=True) as loose:

        def found() -> Finding:
            pictures = msgspec.json.decode(loose.end() or b"0", type=int)
            return Finding(pictures > 0, f"the other window got {pictures} pictures")

        yield loosed(loose, found)


def _refused(rig: WarmRig) -> int:
    return int((rig.car.newest.get("gateway_status") or {"dropped": {}})["dropped"].get(SIGNATURE, 0))


@contextmanager
def wrong_counters(rig: WarmRig) -> Iterator[Armed]:
    """Frames that ask for something else with a right checksum: the ECU says that it refused them, and no demand was theirs."""
    with intruding(rig, "frames", at_tower=False) as loose:
        log = rig.sites.car.running["ecu"]
        before = log.said().count(COUNTER)

        def found() -> Finding:
            told = followed(loose.end(), log_in(rig.sites.car, INTRUDER))
            refused = log.said().count(COUNTER) > before
            said = f"{told.sent} frames sent, {told.followed} of {told.demands} demands were theirs"
            text = said if refused else f"{said}, not refused"
            return Finding(refused and told.sent > 0 and told.demands > 0 and told.followed == 0, text)

        yield loosed(loose, found)


def followed(said: bytes, log: Path) -> Followed:
    """What the intruder says in the end. Raises RigError with the end of his log when that is nothing."""
    try:
        return msgspec.json.decode(said, type=Followed)
    except msgspec.DecodeError:
        raise RigError(f"the intruder did not say what became of his frames: {log.read_text()[-500:]}") from None


@contextmanager
def got_ready(process: "subprocess.Popen[bytes]") -> Iterator[Loose]:
    """An intruder who has just been started, as soon as he is ready; leaving the context ends him. Raises RigError."""
    loose = Loose(process)
    try:
        wait_for_line(process, READY, READY_S)
        yield loose
    finally:
        loose.end()


@contextmanager
def intruding(rig: WarmRig, what: str, at_tower: bool) -> Iterator[Loose]:
    """Ready; `begin` lets him loose."""
    site = rig.sites.tower if at_tower else rig.sites.car
    elsewhere = 19 if at_tower else 0  # from a computer of its own he would take no time from the car's
    with got_ready(run_in(site, INTRUDER, what, str(site.config), niceness=elsewhere)) as loose:
        yield loose
