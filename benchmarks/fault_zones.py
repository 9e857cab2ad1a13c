"""No-stop zones under faults: a camera to the side hangs before one or in one, or the driver is lost in one.

Before: the car waits at the zone's edge until the pictures come again, without a safe stop. Inside: it leaves at walking pace. A
lost driver is a safe stop there as anywhere. Where the car is, is the referee's word.
"""

import os
import signal
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import NamedTuple

from benchmarks.cycle import CAR
from benchmarks.fault_arms import Arm, Armed, End, Finding, Hurt, nothing
from benchmarks.rig import RigError
from benchmarks.warm_rig import STANDSTILL_M_S, ZONE_M, WarmRig
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode

FRONT_M, REAR_M = CAR.length_m - CAR.rear_overhang_m, CAR.rear_overhang_m  # from the rear axle, which has the station
BEFORE_M = (20.0, 26.0)  # the fault begins so far before it: a picture is old after a second, and the car can still stop
INSIDE_M = (-3.0, -0.5)  # likewise: the front is on it by that much, and the back is not
WAITS_M = 1.5  # at most so far from the edge
PACE_M_S = 1.1 * 5 / 3.6  # walking pace and a tenth
STRAIGHT_ON_S = 30.0  # patience until a healed car has the zone behind it
CAMERA = "left"
RULE = "no-stop zone"


class Way(NamedTuple):
    """The car and one zone."""

    from_m: float
    log: Sequence[Referee]  # since the fault began

    def ahead_m(self) -> float:
        """From the leading end to the zone; negative inside and behind."""
        return self.from_m - self.log[-1].station_m - FRONT_M

    def is_behind(self) -> bool:
        return self.log[-1].station_m - REAR_M > self.from_m + ZONE_M

    def inside(self) -> list[Referee]:
        """While some part of the car is on it."""
        low_m, high_m = self.from_m - FRONT_M, self.from_m + ZONE_M + REAR_M
        return [each for each in self.log if low_m < each.station_m < high_m]


def waited(way: Way, mode: str, rules: Sequence[str]) -> Finding:
    """It stands at the edge, the operator still has it, and the zone is the reason."""
    last, ahead_m = way.log[-1], way.ahead_m()
    holds = last.speed_m_s < STANDSTILL_M_S and 0.0 < ahead_m < WAITS_M and mode == Mode.REMOTE and RULE in rules
    return Finding(holds, f"{ahead_m:.1f} m before the zone with {last.speed_m_s:.1f} m/s")


def stood_there(way: Way) -> Finding:
    """For the table: where a lost driver's stop ended."""
    return Finding(True, "past the zone" if way.is_behind() else "in the zone")


def left_slowly(way: Way) -> Finding:
    """It never stood on the zone, and drove at walking pace when it left it."""
    inside = way.inside()
    least, at_last = min(each.speed_m_s for each in inside), inside[-1].speed_m_s
    holds = way.is_behind() and least > STANDSTILL_M_S and at_last < PACE_M_S
    return Finding(holds, f"left the zone with {at_last:.1f} m/s, never slower than {least:.1f}")


def hangs(camera: str) -> Hurt:
    """The process that draws this camera stands still, and with it the camera's pictures."""

    def hurt(rig: WarmRig) -> End:
        pid = painter_of(rig.pid("video"), camera)
        os.kill(pid, signal.SIGSTOP)
        return lambda: os.kill(pid, signal.SIGCONT)

    return hurt


def painter_of(video: int, camera: str) -> int:
    """The process that draws it. Raises RigError."""
    children = Path(f"/proc/{video}/task/{video}/children").read_text().split()
    for pid in map(int, children):
        if Path(f"/proc/{pid}/comm").read_text().strip() == f"painter-{camera}":
            return pid
    raise RigError(f"no process draws the camera {camera}")


class AtZone:
    """The instant is when the leading end of the car is between these two distances before a zone; inside they are negative."""

    def __init__(self, rig: WarmRig, hurt: Hurt, between_m: tuple[float, float]) -> None:
        self.rig, self._hurt, self._between_m = rig, hurt, between_m
        self.from_m, self._since_ns = 0.0, 0
        self.end: End = nothing

    def is_due(self) -> bool:
        last, (low, high) = self.rig.referee()[-1], self._between_m
        self.from_m = next((each for each in self.rig.ride.zones_m if low <= each - last.station_m - FRONT_M <= high), 0.0)
        return self.from_m > 0.0

    def hurt(self, rig: WarmRig) -> End:
        self._since_ns = rig.referee()[-1].stamp_ns
        self.end = self._hurt(rig)
        return self.end

    def way(self) -> Way:
        return Way(self.from_m, [each for each in self.rig.referee() if each.stamp_ns >= self._since_ns])

    def waited_and_went_on(self) -> Finding:
        """Ends the fault."""
        newest = self.rig.car.newest
        finding = waited(self.way(), newest["gateway_status"]["mode"], newest["vehicle_state"]["rules"])
        self.end()
        self.rig.wait_until("the zone is behind the car", lambda: self.way().is_behind(), STRAIGHT_ON_S)
        return finding._replace(text=f"{finding.text}, and went on when the camera did")


def at_zone(hurt: Hurt, between_m: tuple[float, float], found: Callable[[AtZone], Finding]) -> Arm:
    def arm(rig: WarmRig) -> AbstractContextManager[Armed]:
        at = AtZone(rig, hurt, between_m)
        return nullcontext(Armed(at.hurt, at.is_due, found=lambda: found(at)))

    return arm


def before_zone() -> Arm:
    """The side camera hangs before one, and is well again when the car has waited."""
    return at_zone(hangs(CAMERA), BEFORE_M, AtZone.waited_and_went_on)


def in_zone(hurt: Hurt, found: Callable[[Way], Finding]) -> Arm:
    """Done while the front of the car is on one."""
    return at_zone(hurt, INSIDE_M, lambda at: found(at.way()))
