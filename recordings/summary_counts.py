"""What is counted: the gate's interventions, dropped messages, loops and their lateness, metres. Pure."""

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import pairwise

from recordings.drive import CycleRow, SpeedRow, StatusRow
from wire.messages.base import Message
from wire.messages.health import LoopHealth

_GATEWAY = "gateway"  # the process that GatewayStatus.dropped is of, as it names itself in its LoopHealth ...
_GATEWAY_NAMES = frozenset({_GATEWAY, "vehicle-gateway run"})  # ... or is named by its command, as others do
_GAP_NS = 1_000_000_000  # VehicleState comes at 50 Hz: a longer silence is not bridged by assuming a speed
_SECOND_NS = 1e9


class Loop(Message):
    period_ms: float
    cycles: int
    late_cycles: int
    lateness_max_ms: float  # the worst of all seconds reported


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
        process = _GATEWAY if loop.process in _GATEWAY_NAMES else loop.process
        for reason, count in loop.dropped.items():
            told.setdefault((process, loop.loop, reason), []).append(count)
    by_process: dict[tuple[str, str], int] = {}
    for (process, _, reason), counts in told.items():
        by_process[process, reason] = max(by_process.get((process, reason), 0), counted(counts))
    totals: Counter[str] = Counter()
    for (_, reason), count in by_process.items():
        totals[reason] += count
    return dict(sorted(totals.items()))


def loops(health: Iterable[LoopHealth]) -> dict[str, Loop]:
    """Every loop that reported, as "process/loop"; cycles of a process that was restarted are added up."""
    reports: dict[str, list[LoopHealth]] = {}
    for report in health:
        reports.setdefault(f"{report.process}/{report.loop}", []).append(report)
    return {name: _loop(found) for name, found in sorted(reports.items())}


def _loop(reports: Sequence[LoopHealth]) -> Loop:
    return Loop(
        period_ms=reports[-1].period_ms,
        cycles=counted([report.cycles for report in reports]),
        late_cycles=counted([report.late_cycles for report in reports]),
        lateness_max_ms=max(report.lateness_max_ms for report in reports),
    )


def counted(counts: Sequence[int]) -> int:
    """What a counter "since start" reached in all: a smaller value than before means that its process was restarted."""
    before_restarts = sum(before for before, now in pairwise(counts) if now < before)
    return before_restarts + (counts[-1] if counts else 0)


def distance_m(speeds: Sequence[SpeedRow]) -> float | None:
    """Metres driven, forward and backward, by the car's own speed (trapezium rule); None without any VehicleState."""
    if not speeds:
        return None
    return sum(
        (abs(before.speed_m_s) + abs(now.speed_m_s)) / 2 * (now.stamp_ns - before.stamp_ns) / _SECOND_NS
        for before, now in pairwise(speeds)
        if 0 < now.stamp_ns - before.stamp_ns <= _GAP_NS
    )
