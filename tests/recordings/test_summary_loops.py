"""Loops that are late now and then, processes that are restarted: worked out by hand beside each."""

from typing import Any

import pytest
from msgspec.structs import replace

from recordings.summary_loops import load, loops

SECOND = 1_000_000_000


def report(build: Any, process: str, at_s: float, cpu_s: float, stolen_s: float | None = None, loop: str = "cycle") -> Any:
    told = build.health(process, loop, round(at_s * 100))
    return replace(told, stamp_ns=round(at_s * SECOND), process_cpu_s=cpu_s, machine_stolen_s=stolen_s)


def test_a_loop_is_summed_up_over_its_seconds(build: Any) -> None:
    seconds = [(100, 0, 0.1, 1.0), (200, 1, 0.3, 12.0), (300, 3, 0.2, 11.0)]
    health = [
        replace(build.health("autonomy run", "drive", cycles, late, worst), lateness_p50_ms=usual, scheduling=f"fifo {cycles}")
        for cycles, late, usual, worst in seconds
    ]
    loop = loops(health)["autonomy run/drive"]
    assert (loop.cycles, loop.late_cycles, loop.late_share) == (300, 3, pytest.approx(0.01))
    assert (loop.lateness_p50_ms, loop.lateness_max_ms, loop.scheduling) == (0.2, 12.0, "fifo 300")


def test_a_loop_that_never_ran_has_no_share(build: Any) -> None:
    assert loops([build.health("p", "l", 0)])["p/l"].late_share is None


def test_cpu_is_that_between_the_reports_and_goes_on_over_a_restart(build: Any) -> None:
    # Starting up cost 3 s that nobody asks about; 1 s, then started again with 0.5 s, then 0.25 s: 1.75 s in 5 s.
    health = [report(build, "autonomy run", at, used) for at, used in ((10, 3.0), (12, 4.0), (14, 0.5), (15, 0.75))]
    found = load(health)
    assert found is not None
    assert found.processes["autonomy run"].cpu_s == pytest.approx(1.75)
    assert found.cores == found.processes["autonomy run"].cores == pytest.approx(0.35)


def test_two_programs_of_one_name_at_two_towers_are_added_up_and_none_is_a_restart_of_the_other(build: Any) -> None:
    """Taken for restarts, two cockpits were 12 cores on a machine that has two."""
    told = (("a", 1, 30.0), ("b", 1.5, 1.0), ("a", 2, 30.5), ("b", 2.5, 1.5), ("a", 3, 31.0), ("b", 3.5, 2.0))
    health = [replace(report(build, "tower cockpit", at, used), instance=name, cycles=round(100 * used)) for name, at, used in told]
    found = load(health)
    assert found is not None
    assert found.processes["tower cockpit"].cpu_s == pytest.approx(1.0 + 2.0)
    assert loops(health)["tower cockpit/cycle"].cycles == 3100 + 200


def test_the_loops_of_a_process_are_not_added_up_and_processes_are(build: Any) -> None:
    health = [
        report(build, "vehicle-gateway video", at, 2.0 * at, loop=loop) for at in (1, 2, 3) for loop in ("camera front", "status")
    ] + [report(build, "tower window", at, 0.5 * at) for at in (1, 3)]
    found = load(health)
    assert found is not None
    assert {name: process.cores for name, process in found.processes.items()} == {"vehicle-gateway video": 2.0, "tower window": 0.5}
    assert found.cores == pytest.approx(2.5)


def test_stolen_time_is_told_for_each_machine_that_has_a_hub(build: Any) -> None:
    health = [report(build, "vehicle-gateway run", at, 0.0, stolen) for at, stolen in ((1, 100.0), (2, 100.5), (3, 101.5))]
    found = load([*health, report(build, "tower window", 1, 0.0)])
    assert found is not None
    assert found.stolen_s == {"vehicle-gateway run": 1.5}
    assert found.processes["tower window"].cores is None, "one report is no time"


def test_nothing_is_made_up_where_nothing_reported() -> None:
    assert load([]) is None
    assert loops([]) == {}
