"""How every loop kept its time and what every process cost, from the 1 Hz health reports. Pure.

Counters are "since start": of another start of a program, also of one that runs beside it at another tower, they go on in sum. (In
recordings from before a start had a name, a smaller value than before means that the process was started again.)
"""

from collections.abc import Iterable, Sequence
from itertools import pairwise
from statistics import median

from recordings.counters import counted
from wire.messages.base import Message
from wire.messages.health import LoopHealth

_SECOND_NS = 1e9


class Loop(Message):
    period_ms: float
    cycles: int
    late_cycles: int  # later than one period
    late_share: float | None  # of the cycles; None without any
    lateness_p50_ms: float  # the median of the medians of all seconds reported
    lateness_max_ms: float  # the worst of all seconds reported
    scheduling: str  # as last told: "fifo 10", "other" and why


class Process(Message):
    cpu_s: float  # CPU seconds between its first and its last report
    cores: float | None  # that, over the time between them; None for fewer than two reports


class Load(Message):
    processes: dict[str, Process]
    cores: float | None  # all of them together, in the mean
    stolen_s: dict[str, float]  # taken away from the machine of each hub between its first and last report, all cores


def loops(health: Iterable[LoopHealth]) -> dict[str, Loop]:
    """Every loop that reported, as "process/loop"; cycles of a process that was restarted are added up."""
    return {f"{process}/{loop}": _loop(found) for (process, loop), found in sorted(_by_loop(health).items())}


def load(health: Iterable[LoopHealth]) -> Load | None:
    """What the processes used; None when nothing reported."""
    chosen = _one_loop_each(_by_loop(health))
    if not chosen:
        return None
    processes = {name: _process(reports) for name, reports in chosen.items()}
    cores = [process.cores for process in processes.values() if process.cores is not None]
    stolen = {
        name: told[-1] - told[0]
        for name, reports in chosen.items()
        if len(told := [report.machine_stolen_s for report in reports if report.machine_stolen_s is not None]) > 1
    }
    return Load(processes=processes, cores=sum(cores) if cores else None, stolen_s=stolen)


def _by_loop(health: Iterable[LoopHealth]) -> dict[tuple[str, str], list[LoopHealth]]:
    reports: dict[tuple[str, str], list[LoopHealth]] = {}
    for report in health:
        reports.setdefault((report.process, report.loop), []).append(report)
    return reports


def _one_loop_each(by_loop: dict[tuple[str, str], list[LoopHealth]]) -> dict[str, list[LoopHealth]]:
    """Every loop of a process tells the same CPU seconds: the one that told them most often speaks for it."""
    chosen: dict[str, list[LoopHealth]] = {}
    for (process, _), reports in sorted(by_loop.items()):
        if len(reports) > len(chosen.get(process, ())):
            chosen[process] = reports
    return chosen


def _loop(reports: Sequence[LoopHealth]) -> Loop:
    starts = _starts(reports)
    cycles = sum(counted([report.cycles for report in start]) for start in starts)
    late = sum(counted([report.late_cycles for report in start]) for start in starts)
    return Loop(
        period_ms=reports[-1].period_ms,
        cycles=cycles,
        late_cycles=late,
        late_share=late / cycles if cycles else None,
        lateness_p50_ms=median(report.lateness_p50_ms for report in reports),
        lateness_max_ms=max(report.lateness_max_ms for report in reports),
        scheduling=reports[-1].scheduling,
    )


def _process(reports: Sequence[LoopHealth]) -> Process:
    first, *later = _starts(reports)
    cpu_s = _used_s(first) + sum(start[0].process_cpu_s + _used_s(start) for start in later)
    span_s = (reports[-1].stamp_ns - reports[0].stamp_ns) / _SECOND_NS
    return Process(cpu_s=cpu_s, cores=cpu_s / span_s if span_s > 0 else None)


def _used_s(reports: Sequence[LoopHealth]) -> float:
    """CPU seconds between the first and the last report of one start."""
    used = [report.process_cpu_s for report in reports]
    return sum(now - before if now >= before else now for before, now in pairwise(used))


def _starts(reports: Sequence[LoopHealth]) -> list[list[LoopHealth]]:
    """The reports of each start of the program, in the order in which they first came."""
    starts: dict[str, list[LoopHealth]] = {}
    for report in reports:
        starts.setdefault(report.instance, []).append(report)
    return list(starts.values())
