"""What is counted: the gate's interventions, dropped messages, metres. Pure."""

from collections import Counter
from collections.abc import Sequence
from itertools import pairwise

from recordings.counters import counted
from recordings.drive import CycleRow, SpeedRow, StatusRow
from wire.messages.health import LoopHealth
from wire.topics import PROGRAMS, Role

_GATEWAY = PROGRAMS[Role.VEHICLE_HUB]  # the process that GatewayStatus.dropped is of
_GAP_NS = 1_000_000_000  # VehicleState comes at 50 Hz: a longer silence is not bridged by assuming a speed
_SECOND_NS = 1e9


def gate_interventions(cycles: Sequence[CycleRow]) -> dict[str, int] | None:
    """Episodes per rule: how often a rule began to change the request (rising edges), not for how many cycles."""
    if not cycles:
        return None
    before: frozenset[str] = frozenset()
    episodes: Counter[str] = Counter()
    for cycle in cycles:
        rules = frozenset(cycle.rules)
        episodes.update(rules - before)
        before = rules
    return dict(sorted(episodes.items()))


def messages_dropped(statuses: Sequence[StatusRow], health: Sequence[LoopHealth]) -> dict[str, int]:
    """Dropped messages by reason: per process what its counters reached, summed over the processes.

    Several loops of one process report the same counters, and GatewayStatus repeats the gateway's: the largest counts.
    """
    told: dict[tuple[str, str, str], list[int]] = {}  # (process, who says so, reason) -> counts in order
    for _, status in statuses:
        for reason, count in status.dropped.items():
            told.setdefault((_GATEWAY, "status", reason), []).append(count)
    for loop in health:
        for reason, count in loop.dropped.items():
            told.setdefault((loop.process, loop.loop, reason), []).append(count)
    by_process: dict[tuple[str, str], int] = {}
    for (process, _, reason), counts in told.items():
        by_process[process, reason] = max(by_process.get((process, reason), 0), counted(counts))
    totals: Counter[str] = Counter()
    for (_, reason), count in by_process.items():
        totals[reason] += count
    return dict(sorted(totals.items()))


def distance_m(speeds: Sequence[SpeedRow]) -> float | None:
    """Metres driven, forward and backward, by the car's own speed (trapezium rule); None without any VehicleState."""
    if not speeds:
        return None
    return sum(
        (abs(before.speed_m_s) + abs(now.speed_m_s)) / 2 * (now.stamp_ns - before.stamp_ns) / _SECOND_NS
        for before, now in pairwise(speeds)
        if 0 < now.stamp_ns - before.stamp_ns <= _GAP_NS
    )
