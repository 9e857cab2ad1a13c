"""Two who ask at once, in ONE cycle of the gateway: the operator takes the car, and the automation asks for somebody who does, or
another operator asks beside him.

No rig puts two messages of real programs into one cycle of 4 to 10 ms at will. So the automation asks as often as it may, and what
two operators send is held on its way and comes out together, again and again; and it is done anew until the cycle that granted the
take-over had heard both. What a cycle heard is read from the cycle itself, as the recorder hears it: its inputs and outputs. The
operator must have the car, by one grant.
"""

import time
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NamedTuple

from benchmarks.fault_arms import Fate
from benchmarks.fault_hand_overs import FORWARD, TAKES_S, Exchange, automation_drives, status_when
from benchmarks.fault_intruder import intruding
from benchmarks.fault_rows import Shot
from benchmarks.rig import RigError
from benchmarks.two_machines import Listener
from benchmarks.warm_rig import WarmRig, said
from wire.messages.session import Action, Outcome
from wire.messages.vehicle import Mode

TRIES_MAX = 24  # in one of four both fall into one cycle
HELD_NS, OPEN_NS = 40_000_000, 10_000_000  # of the way to the car: twenty bunches a second, and far below any limit of silence
HEARD_S = 10.0  # until the cycles are heard at all; and until that of the grant is
NOT_SIGNED = "hand-over signature"  # why the car drops the question of whoever does not hold the lease
HOLDER = "demo"


class Heard(NamedTuple):
    """What is needed of one cycle."""

    number: int
    mode: str  # after it
    request: int | None  # number of the automation's request for a take-over, 0 without one; None: it said nothing
    operators: tuple[str, ...]  # who asked for the lease, with a certificate that is good
    grants: bool  # a take-over


class Meeting(NamedTuple):
    """The cycle in which a take-over was granted."""

    number: int
    origin: str  # the mode before it
    asked_anew: bool  # the automation came with a request that was not open before
    others: tuple[str, ...]  # operators who asked for the lease in it, besides its holder


class Taken(NamedTuple):
    """One try: the operator drives."""

    by_one_grant: bool  # the lease's holder, and the first grant of this gateway
    grant: str  # who it was, its number, what became of it
    meeting: Meeting
    refused: int  # questions that were not signed with the lease's key
    cause: str


class Beside(NamedTuple):
    """Who asks beside the operator: benchmarks.intruder."""

    intruder: str
    at_tower: bool
    words: str
    met: Callable[[Meeting], bool]


def heard(cycle: dict[str, Any]) -> Heard:
    """Of a GatewayCycle as JSON."""
    inputs, replies = cycle["inputs"], cycle["outputs"]["hand_over_replies"]
    status, answered = inputs["autonomy_status"], zip(inputs["hand_over_requests"], replies, strict=True)
    asking = zip(inputs["lease_requests"], inputs["operators"], strict=True)
    return Heard(
        number=cycle["number"],
        mode=cycle["mode"],
        request=None if status is None else (status["request"] or {"number": 0})["number"],
        operators=tuple(request["operator"] for request, identity in asking if not identity["rule"]),
        grants=any((asked["action"], reply["outcome"]) == (Action.TAKE, Outcome.GRANTED) for asked, reply in answered),
    )


def meeting_in(cycles: Sequence[Heard], holder: str) -> Meeting | None:
    """The last take-over that was granted; None when none was."""
    found, known, mode = None, 0, ""
    for cycle in cycles:
        request = known if cycle.request is None else cycle.request
        if cycle.grants:
            others = tuple(name for name in cycle.operators if name != holder)
            found = Meeting(cycle.number, mode, request not in (0, known), others)
        known, mode = request, cycle.mode
    return found


def at_once(rig: WarmRig, number: int, beside: Beside) -> Shot:
    """Again and again, until both fall into one cycle or something does not hold."""
    tries, taken = 1, _taken(rig, beside)
    while taken.by_one_grant and not beside.met(taken.meeting) and tries < TRIES_MAX:
        tries, taken = tries + 1, _taken(rig, beside)
    met, meeting = beside.met(taken.meeting), taken.meeting
    what = f"{beside.words} in the cycle of the grant" if met else "the two did not fall into one cycle"
    what += "" if taken.by_one_grant else f", and not by one grant: {taken.grant}"
    text = f"{meeting.origin}: {what} at try {tries}; {taken.refused} questions refused at the door; {taken.cause}"
    return Shot(kind="", speed_m_s=rig.referee()[-1].speed_m_s, held=taken.by_one_grant and met, text=text, saw=said(rig))


def _taken(rig: WarmRig, beside: Beside) -> Taken:
    """The operator comes and takes the car."""
    if rig.worn():
        raise RigError("worn before both fell into one cycle")
    automation_drives(rig)
    cycles: list[Heard] = []
    listener = Listener(rig.sites.car, "gateway_cycle", tell=lambda _, cycle, __: cycles.append(heard(cycle)))
    with listener, intruding(rig, beside.intruder, beside.at_tower) as loose:
        rig.wait_until("the cycles are heard", lambda: cycles, HEARD_S)
        loose.begin()
        rig.start("cockpit")
        if beside.at_tower:
            _bunch_until_taken(rig)
        status = status_when(rig, lambda status: status["mode"] == Mode.REMOTE, TAKES_S)
        meeting = _meeting(rig, cycles)
    hand_over = status["hand_over"]
    grant = status["lease_holder"], hand_over["number"], hand_over["state"]
    return Taken(
        grant == (HOLDER, 1, "committed"),
        " ".join(map(str, grant)),
        meeting,
        int(status["dropped"].get(NOT_SIGNED, 0)),
        status["cause"],
    )


def _bunch_until_taken(rig: WarmRig) -> None:
    """From when the car drives itself: what comes from the tower comes out together. Raises RigError."""
    status_when(rig, lambda status: status["mode"] != Mode.STANDBY, TAKES_S)
    end_ns = rig.clock.now_ns() + round(TAKES_S * 1e9)
    while rig.car.mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED) and rig.clock.now_ns() < end_ns:
        rig.way.be(held=FORWARD)
        time.sleep(rig.clock.real_s(HELD_NS))
        rig.way.be()
        time.sleep(rig.clock.real_s(OPEN_NS))


def _meeting(rig: WarmRig, cycles: list[Heard]) -> Meeting:
    """As soon as its cycle is heard. Raises RigError."""
    rig.wait_until("the cycle of the grant is heard", lambda: meeting_in(cycles.copy(), HOLDER), HEARD_S)
    found = meeting_in(cycles.copy(), HOLDER)
    assert found is not None  # for the type checker
    return found


RIVAL = Beside("rival", True, "another operator asked for the lease", lambda meeting: bool(meeting.others))
DOUBT = Beside("doubting", False, "the automation asked anew", lambda meeting: meeting.asked_anew)
MEETINGS: tuple[Exchange, ...] = (
    Exchange("two-takes", "another operator asks for lease and car beside him", Fate.COMMITS, partial(at_once, beside=RIVAL)),
    Exchange("asks-and-takes", "the automation asks as the operator takes", Fate.COMMITS, partial(at_once, beside=DOUBT)),
)
