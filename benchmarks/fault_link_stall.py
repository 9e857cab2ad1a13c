"""A link that stalls while the cockpit goes on sending: what it kept comes afterwards, all at once. None may be used too late.

What the gateway's cycles used is read from the cycles as the recorder hears them. As a kind of fault, and as figures for
benchmarks.reaction.
"""

import tempfile
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

from benchmarks.bad_way import NEITHER
from benchmarks.fault_arms import Arm, Armed, End, Finding, nothing
from benchmarks.fault_commands import Used
from benchmarks.fault_hand_overs import FORWARD
from benchmarks.impairment import Impairment
from benchmarks.rig import RigError
from benchmarks.two_machines import Listener, missing
from benchmarks.warm_rig import WarmRig, pause, warm_rig

AFTER_S = 2.0  # what came late has come by then
LEASE_S = 1.0  # real ones, of the link (wire.transport): a longer silence ends it, and with it what waits at its sender
BOTH = (True, True)
UP_S, AGAIN_S, HEARD_S = 120.0, 60.0, 10.0
OF_COMMANDS = "command "  # how the reasons begin for which the car drops one


class Case(NamedTuple):
    """What becomes of what is sent in the meantime: kept on its way, forward and back, or lost."""

    words: str
    seconds: float
    kept: tuple[bool, bool]
    loss: float = 0.0


OUTLIVED = Case("kept, to the car", 0.8, FORWARD)
CASES = (
    OUTLIVED,
    Case("kept, to the car", 1.0, FORWARD),
    Case("kept, both ways", 1.0, BOTH),
    Case("lost, both ways", 1.0, NEITHER, 1.0),
)


class Stalled(NamedTuple):
    """What came of one stall."""

    oldest_ms: float  # of the commands that a cycle used, when it came
    too_old: int  # used, beyond the limit
    refused: Counter[str]  # commands, by reason
    used: int


@contextmanager
def watched(rig: WarmRig) -> Iterator[Callable[[], Stalled]]:
    """From now on; the call tells what there was until then."""
    used, before = Used(), _refused(rig)
    with Listener(rig.sites.car, "gateway_cycle", tell=used.take):
        rig.wait_until("the cycles are heard", lambda: used.cycles, HEARD_S)
        yield lambda: Stalled(used.oldest_ms, used.too_old, _refused(rig) - before, len(used.uses))


def _refused(rig: WarmRig) -> Counter[str]:
    dropped = (rig.car.newest.get("gateway_status") or {"dropped": {}})["dropped"]
    return Counter({reason: number for reason, number in dropped.items() if reason.startswith(OF_COMMANDS)})


def held_up(seconds: float, which: tuple[bool, bool] = FORWARD) -> Arm:
    """Everything on these ways is kept for so long and comes then, in its order; if the link outlives it, some of it too late."""

    @contextmanager
    def arm(rig: WarmRig) -> Iterator[Armed]:
        with watched(rig) as told:

            def hurt(rig: WarmRig) -> End:
                rig.way.be(held=which)
                pause(rig, seconds)
                rig.way.be()
                pause(rig, AFTER_S)
                return nothing

            def found() -> Finding:
                seen = told()
                refused = ", ".join(f"{number} {reason}" for reason, number in seen.refused.items())
                text = f"of {seen.used} used the oldest came with {seen.oldest_ms:.0f} ms; refused: {refused or 'none'}"
                late = seen.refused.total() > 0 or rig.clock.real_s(round(seconds * 1e9)) >= LEASE_S
                return Finding(seen.too_old == 0 and seen.used > 0 and late, text)

            yield Armed(hurt, found=found)

    return arm


def stall(rig: WarmRig, case: Case) -> Stalled:
    """Once, while the operator drives."""
    rig.wait_until("the operator drives", rig.drives, AGAIN_S)
    lost = Impairment(loss=case.loss)
    with watched(rig) as told:
        rig.way.be(lost, lost, held=case.kept)
        pause(rig, case.seconds)
        rig.way.be()
        pause(rig, AFTER_S)
        return told()


def stalls(times: int) -> dict[Case, list[Stalled]]:
    """Every case so often. Raises RigError, also when a link that outlives its stall brought nothing late."""
    if missing():
        raise RigError(f"no stalled link: {missing()}")
    with tempfile.TemporaryDirectory(prefix="stall-") as place, warm_rig(Path(place)) as rig:
        rig.wait_until("the operator drives for the first time", rig.drives, UP_S)
        seen = {case: [stall(rig, case) for _ in range(times)] for case in CASES}
    if not all(each.refused.total() for each in seen[OUTLIVED]):
        raise RigError("a link that keeps what is sent brought nothing late: not measured")
    return seen
