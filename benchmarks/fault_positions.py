"""Satellite positions that stand still behind fresh stamps, while the car moves: the automation must notice, and know where it is.

Whoever drives, the automation estimates where the car is: wheels and gyro must carry the estimate on, and its localization must
speak up. Told by what it says on the link (its status, its scene) beside the referee's truth.
"""

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext
from math import hypot
from typing import Any

from benchmarks.fault_arms import Arm, Armed, Finding
from benchmarks.fault_certificates import end
from benchmarks.fault_hand_overs import automation_drives
from benchmarks.fault_intruder import intruding, loosed
from benchmarks.two_machines import Listener
from benchmarks.warm_rig import NOT_KEEN, WarmRig
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

CHANNEL = "localization"
NOTICE_S = 3.0  # twenty positions rejected in a row, at the sensor's own 10 Hz 2 s, and one for what smooths it
OFF_MAX_M = 0.6  # from where on the automation itself would doubt a position (autonomy.uncertainty.channels)
HEARD_S = 10.0


class Believed:
    """What the automation says from now on."""

    def __init__(self) -> None:
        self.places: list[tuple[int, float, float]] = []  # stamp, x, y of its scenes
        self.doubts_ns: list[int] = []  # stamps of statuses in which the channel is high

    def take(self, topic: str, message: Any, _: int) -> None:
        if topic == "scene":
            self.places.append((message["stamp_ns"], message["x_m"], message["y_m"]))
        elif any(each["channel"] == CHANNEL and each["high"] for each in message["evidence"]):
            self.doubts_ns.append(message["stamp_ns"])


def truth(log: Sequence[Referee], stamp_ns: int) -> tuple[float, float] | None:
    """Where the car was, between two entries of the referee; None outside of them."""
    place = bisect_left(log, stamp_ns, key=lambda each: each.stamp_ns)
    if not 0 < place < len(log):
        return None
    before, after = log[place - 1], log[place]
    share = (stamp_ns - before.stamp_ns) / (after.stamp_ns - before.stamp_ns)
    return before.x_m + share * (after.x_m - before.x_m), before.y_m + share * (after.y_m - before.y_m)


def off_m(places: Sequence[tuple[int, float, float]], log: Sequence[Referee], from_ns: int) -> float:
    """The farthest that the automation was from where it believed to be, since then."""
    pairs = ((x, y, truth(log, stamp_ns)) for stamp_ns, x, y in places if stamp_ns > from_ns)
    return max((hypot(x - true[0], y - true[1]) for x, y, true in pairs if true is not None), default=float("inf"))


def stuck(mode: Mode) -> Arm:
    """While the operator drives, or the car itself."""

    @contextmanager
    def arm(rig: WarmRig) -> Iterator[Armed]:
        believed = Believed()
        listener = Listener(rig.sites.car, "scene", "autonomy_status", tell=believed.take)
        driver = drives_itself(rig) if mode is Mode.AUTONOMOUS else nullcontext()
        with driver, intruding(rig, "stuck", at_tower=False) as loose, listener:
            rig.wait_until("the automation is heard", lambda: believed.places, HEARD_S)
            armed = loosed(loose)
            struck_ns: list[int] = []

            def hurt(rig: WarmRig) -> Any:
                struck_ns.append(rig.clock.now_ns())
                return armed.hurt(rig)

            yield Armed(hurt, mode=mode, found=lambda: finding(believed, rig.referee(), struck_ns[0]))

    return arm


def finding(believed: Believed, log: Sequence[Referee], struck_ns: int) -> Finding:
    noticed_s = min(((stamp - struck_ns) / 1e9 for stamp in believed.doubts_ns if stamp > struck_ns), default=float("inf"))
    off = off_m(believed.places, log, struck_ns)
    text = f"the automation doubts its place after {noticed_s:.1f} s, and was off by {off:.2f} m at the most"
    return Finding(noticed_s <= NOTICE_S and off <= OFF_MAX_M, text)


@contextmanager
def drives_itself(rig: WarmRig) -> Iterator[None]:
    """With an operator who takes the car only when it asks him; the keen one comes back afterwards."""
    automation_drives(rig)
    rig.start("cockpit", NOT_KEEN)
    try:
        yield
    finally:
        end(rig, "cockpit")
        rig.start("cockpit")
