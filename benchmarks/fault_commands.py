"""What the car got of its operator's commands, heard beside the gateway, and which of them its cycles used.

`Arrivals` looks at what came to the car's hub: for how long nothing came, and nothing with a newer picture. By the limits of the
configuration that says whether the car had to stop, or had no reason to; how long a picture stood counts by the clock of who sent
the commands, as it does for the car. `Used` looks at the cycles as they are recorded: how old each command was that a cycle took
up. Both are told by a listener at the car's hub; never by what the gateway says of itself.
"""

from collections import deque
from collections.abc import Iterator, Sequence
from itertools import accumulate, chain, pairwise
from typing import Any, NamedTuple

from benchmarks.fault_bounds import FAILSAFE
from vehicle_gateway.lease import ECHO_AGE_MAX_NS

FAR = 2**40  # a sequence number no cockpit comes to: of an intruder (benchmarks.intruder)
CAMERA = "front"  # the required one
KEPT = 20_000  # arrivals: more than two minutes
SLOW_MS = 2500.0  # a slow loop: the p95 of a second above its limit, for one second more, and half a second of itself
TOLERANCE_MS = 100.0  # ours, of listening beside the gateway on a busy machine: nearer to a limit than that, both are right


class Arrival(NamedTuple):
    received_ns: int  # the car's clock
    capture_ns: int  # of the picture it was given on
    sent_ns: int  # the tower's clock

    @property
    def age_ms(self) -> float:
        """Of that picture."""
        return (self.received_ns - self.capture_ns) / 1e6


class Gaps(NamedTuple):
    """The longest time [ms] without a command, without a newer picture behind one, and with too old pictures behind all."""

    command_ms: float
    picture_ms: float
    slow_ms: float
    oldest_ms: float  # picture behind a command when it came

    @property
    def must_stop(self) -> bool:
        """One of them was clearly beyond its limit."""
        return self._silent_beyond(TOLERANCE_MS) or self.slow_ms > SLOW_MS + TOLERANCE_MS

    @property
    def may_stop(self) -> bool:
        """One of them was beyond its limit, or nearly."""
        return self._silent_beyond(-TOLERANCE_MS) or self.oldest_ms > FAILSAFE.loop_age_max_ms - TOLERANCE_MS

    def _silent_beyond(self, by_ms: float) -> bool:
        return self.command_ms > FAILSAFE.command_lost_ms + by_ms or self.picture_ms > FAILSAFE.picture_lost_ms + by_ms


def gaps(arrivals: Sequence[Arrival], from_ns: int, to_ns: int) -> Gaps:
    """Between the two instants; one that is still open at the end counts, as does one that was open at the beginning."""
    heard = [each for each in arrivals if each.received_ns <= to_ns]
    tower_ns = min((each.received_ns - each.sent_ns for each in heard), default=0)  # its clock, as of the quickest way
    newer = (each for each, newest_ns in zip(heard, _newest_before(heard), strict=True) if each.capture_ns > newest_ns)
    new = [each.sent_ns + tower_ns for each in newer]
    fresh = [each.received_ns for each in heard if each.age_ms <= FAILSAFE.loop_age_max_ms]
    command_ms, picture_ms, slow_ms = (_longest_ms(each, from_ns, to_ns) for each in ([a.received_ns for a in heard], new, fresh))
    return Gaps(command_ms, picture_ms, slow_ms, max((each.age_ms for each in heard if each.received_ns > from_ns), default=0.0))


def _newest_before(heard: Sequence[Arrival]) -> Iterator[int]:
    """For each, the newest picture that one before it told of."""
    return chain((0,), accumulate((each.capture_ns for each in heard[:-1]), max)) if heard else iter(())


def _longest_ms(instants_ns: Sequence[int], from_ns: int, to_ns: int) -> float:
    """Without any of these instants, counted from the last one before `from_ns`."""
    inside = [each for each in instants_ns if each > from_ns]
    begin = max((each for each in instants_ns if each <= from_ns), default=from_ns)
    return max(later - earlier for earlier, later in pairwise((begin, *inside, to_ns))) / 1e6


class Arrivals:
    """The operator's commands as they came to the car's hub, whoever else puts something on their key."""

    def __init__(self) -> None:
        self._kept: deque[Arrival] = deque(maxlen=KEPT)

    def take(self, topic: str, message: Any, received_ns: int) -> None:
        if topic == "drive_command" and message.get("dead_man") and message["sequence"] < FAR:  # or somebody's junk
            self._kept.append(Arrival(received_ns, message["displayed_capture_ns"].get(CAMERA, 0), message["sent_ns"]))

    def gaps(self, from_ns: int, to_ns: int) -> Gaps:
        return gaps(tuple(self._kept.copy()), from_ns, to_ns)


class Use(NamedTuple):
    """A command that a cycle took up; ages count from the car's own stamp that it answers."""

    sequence: int
    arrived_ms: float  # how old it was when it came: what the limit is about
    used_ms: float  # and at the cycle


class Used:
    """Every command that a cycle of the gateway used."""

    limit_ms = ECHO_AGE_MAX_NS / 1e6

    def __init__(self) -> None:
        self.uses: list[Use] = []
        self.cycles = 0

    def take(self, topic: str, cycle: Any, _: int) -> None:
        """A GatewayCycle as JSON."""
        self.cycles += 1
        command, received_ns = cycle["inputs"]["command"], cycle["inputs"]["command_ns"]
        if command is not None:
            echoed_ns = command["echoed_vehicle_ns"]
            self.uses.append(Use(command["sequence"], (received_ns - echoed_ns) / 1e6, (cycle["now_ns"] - echoed_ns) / 1e6))

    @property
    def oldest_ms(self) -> float:
        """Of those used, when it came; 0 when none was."""
        return max((use.arrived_ms for use in self.uses), default=0.0)

    @property
    def too_old(self) -> int:
        """How many were older than their limit when they came."""
        return sum(use.arrived_ms > self.limit_ms for use in self.uses)

    @property
    def forged(self) -> int:
        """How many were an intruder's."""
        return sum(use.sequence >= FAR for use in self.uses)
