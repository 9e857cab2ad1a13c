"""Hand-overs at their worst instants: the grant is lost, it is answered at the last or just too late.

The car drives itself (its gateway has started again, without the memory of a stop) and the keen operator takes it. A way of 60 ms
gives the time to act between a grant and what follows it; what became of it, and when, is told by the gateway's own status on its
own clock, which is the rig's. The limit is the configuration's: a grant commits within 300 ms, or never.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import msgspec

from benchmarks.fault_arms import Fate
from benchmarks.fault_bounds import COMMIT_MS
from benchmarks.fault_certificates import end, stand
from benchmarks.fault_rows import Shot
from benchmarks.impairment import Impairment
from benchmarks.rig import RigError
from benchmarks.warm_rig import WarmRig, said
from vehicle_gateway.authority import DRIVES
from vehicle_gateway.memory import Remembered, write
from wire.messages.vehicle import Mode

WAY_MS = 60.0  # of the packets that are to be caught under way; less than any limit
CYCLE_MS = 10.0  # of the gateway: so late it may notice that a grant has lapsed
EARLIER_MS = (30.0, 20.0, 10.0)  # than the limit, shot after shot: the answer is let through
LATER_MS = 5.0
TAKES_S = 40.0  # until the operator takes the car
DECIDED_S = 2.0
LOOK_S = 0.001
BACK_S = 20.0
FORWARD, BACK = (True, False), (False, True)
Status = dict[str, Any]


class Exchange(NamedTuple):
    """A kind of fault that is done to a hand-over; `story` is told the number of the shot."""

    name: str
    what: str
    fate: Fate
    story: Callable[[WarmRig, int], Shot]


class Granted(NamedTuple):
    at_ns: int  # the car's clock
    number: int
    origin: str  # the mode before
    speed_m_s: float

    def after_ms(self, now_ns: int) -> float:
        """now_ns: the rig's clock, which is the car's."""
        return (now_ns - self.at_ns) / 1e6


class Decided(NamedTuple):
    """What became of a grant."""

    state: str  # committed, expired, aborted
    mode: str  # afterwards
    took_ms: float  # on the car's clock


def grant_lost(rig: WarmRig, number: int) -> Shot:
    """The answer is under way to the tower when everything on that way is lost, until the grant has lapsed."""
    granted = _granted(rig, back=Impairment(delay_ms=WAY_MS))
    caught_ms = granted.after_ms(rig.way.be(back=Impairment(loss=1.0), lost=BACK))
    decided = _decided(rig, granted)
    rig.way.be()
    caught = caught_ms < WAY_MS
    same = DRIVES[Mode(decided.mode)] is DRIVES[Mode(granted.origin)]  # the automation may have begun or ceased to ask
    lapsed = decided.state == "expired" and same and decided.took_ms <= COMMIT_MS + CYCLE_MS
    text = f"{'caught' if caught else 'not caught,'} {caught_ms:.0f} ms after it"
    return _shot(rig, granted, decided, caught and lapsed, text)


def answered_late(rig: WarmRig, number: int, earlier_ms: tuple[float, ...], fate: Fate) -> Shot:
    """The operator's first command with the grant is held on its way, and let through so long before the limit."""
    early_ms = earlier_ms[(number - 1) % len(earlier_ms)]
    granted = _granted(rig, forward=Impairment(delay_ms=WAY_MS))
    held_ms = granted.after_ms(rig.way.be(forward=Impairment(delay_ms=WAY_MS), held=FORWARD))
    _until_ns(rig, granted.at_ns + round((COMMIT_MS - early_ms) * 1e6))
    let_ms = granted.after_ms(rig.way.be())
    decided = _decided(rig, granted)
    wanted = "committed" if fate is Fate.COMMITS else "expired"
    in_time = decided.took_ms <= COMMIT_MS + (0.0 if decided.state == "committed" else CYCLE_MS)
    text = f"let through {let_ms:.1f} ms after the grant" if held_ms < WAY_MS else f"not held, {held_ms:.0f} ms after it"
    return _shot(rig, granted, decided, held_ms < WAY_MS and decided.state == wanted and in_time, text)


def automation_drives(rig: WarmRig) -> None:
    """The car stands without an operator, no stop is latched or counted: as soon as somebody is there it drives itself."""
    stand(rig)
    end(rig, "gateway")
    before, memory = rig.car.newest["gateway_status"]["boot_id"], rig.sites.car.folder / "memory.json"
    known = msgspec.json.decode(memory.read_bytes(), type=Remembered)
    write(memory, msgspec.structs.replace(known, stop_latched=False, engaged=False, stops_utc_ns=()))
    rig.start("gateway")
    rig.wait_until("the gateway is back", lambda: rig.car.newest["gateway_status"]["boot_id"] != before, BACK_S)


def _granted(rig: WarmRig, forward: Impairment | None = None, back: Impairment | None = None) -> Granted:
    """The operator comes, on such a way, and the car has just granted him the take-over."""
    automation_drives(rig)
    rig.way.be(forward, back)
    rig.start("cockpit")
    status = status_when(rig, lambda status: status["mode"] == Mode.HANDING_OVER, TAKES_S)
    return Granted(status["mode_since_ns"], status["hand_over"]["number"], rig.car.modes[-2], rig.referee()[-1].speed_m_s)


def _decided(rig: WarmRig, granted: Granted) -> Decided:
    open_still = (granted.number, "granted")
    after = status_when(rig, lambda status: (status["hand_over"]["number"], status["hand_over"]["state"]) != open_still, DECIDED_S)
    return Decided(after["hand_over"]["state"], after["mode"], granted.after_ms(after["mode_since_ns"]))


def status_when(rig: WarmRig, what: Callable[[Status], bool], patience_s: float) -> Status:
    """The first status of the car of which this is so, a millisecond after it came. Raises RigError."""
    until_ns = rig.clock.now_ns() + round(patience_s * 1e9)
    while not what(status := rig.car.newest["gateway_status"]):
        if rig.clock.now_ns() > until_ns:
            raise RigError(f"the hand-over never came to it: {status['mode']}, {status['cause']}, {status['take_refused']}")
        time.sleep(LOOK_S)
    return dict(status)


def _until_ns(rig: WarmRig, instant_ns: int) -> None:
    while (left_ns := instant_ns - rig.clock.now_ns()) > 0:
        time.sleep(min(rig.clock.real_s(left_ns), LOOK_S))


def _shot(rig: WarmRig, granted: Granted, decided: Decided, held: bool, text: str) -> Shot:
    became = f"{granted.origin}: {text}; {decided.state} after {decided.took_ms:.1f} ms: {decided.mode}"
    return Shot(kind="", speed_m_s=granted.speed_m_s, held=held, text=became, saw=said(rig))


def _kind(name: str, what: str, fate: Fate, earlier_ms: tuple[float, ...]) -> Exchange:
    return Exchange(name, what, fate, partial(answered_late, earlier_ms=earlier_ms, fate=fate))


EXCHANGES: tuple[Exchange, ...] = (
    Exchange("grant-lost", "the answer to a take-over is lost on its way", Fate.LAPSES, grant_lost),
    _kind("answer-last", "a grant is answered in its last 30, 20, 10 ms", Fate.COMMITS, EARLIER_MS),
    _kind("answer-late", "a grant is answered 5 ms after its end", Fate.LAPSES, (-LATER_MS,)),
)
