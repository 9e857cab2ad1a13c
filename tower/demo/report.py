"""The table of what happened, from summary.json. A figure that could not be measured is a dash."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from wire.topics import ECU, PROGRAMS, Role


def table_of(summary: Mapping[str, Any], folder: Path, real_time_factor: float = 1.0) -> Table:
    table = Table(title="What happened", title_justify="left", show_header=False, box=None, padding=(0, 2, 0, 0))
    if real_time_factor < 1.0:
        table.add_row(
            "slow motion", f"{real_time_factor:.0%} of real time; every figure below is in the drive's own time, also the CPU's"
        )
    for name, text in rows_of(summary):
        table.add_row(name, text)
    table.add_row("files", ", ".join(sorted(path.name for path in folder.iterdir() if path.is_file())))
    table.add_row("folder", str(folder))
    return table


def rows_of(summary: Mapping[str, Any]) -> list[tuple[str, str]]:
    """(name, text) for each line of the table."""
    modes = ", ".join(f"{mode.replace('_', ' ')} {seconds:.1f} s" for mode, seconds in summary["modes_s"].items())
    rows = [
        ("goal", _yes(summary["goal_reached"])),
        ("collisions", _figure(summary["collisions"], "d")),
        ("who drove", modes),
    ]
    rows += [row for takeover in summary["takeovers"] for row in _takeover(takeover)]
    rows += [(f"camera {name}", _camera(camera)) for name, camera in summary["cameras"].items()]
    rows += [
        ("loop age", f"{_spread(summary['loop_age_ms'])} ms, on the car's own clock"),
        ("motion to motion", _motion(summary.get("motion_to_motion_ms"))),
        ("wheel to CAN", f"{_spread(summary['wheel_to_can_ms'])} ms"),
        ("commands", f"{_figure(summary['command_rate_hz'], '.0f')} Hz"),
        ("gate stepped in", _counts(summary["gate_interventions"])),
        ("messages dropped", _counts(summary["messages_dropped"])),
        *_loops(summary.get("loops") or {}),
        ("CPU", _load(summary.get("load"))),
    ]
    return rows


def _camera(camera: Mapping[str, Any]) -> str:
    shown = f"{_figure(camera['fps'], '.1f')} fps, {_spread(camera['latency_ms'])} ms capture to screen"
    if not camera.get("reduced_s"):
        return shown
    lowest = _figure(camera.get("lowest_hz"), ".0f")
    gave_up = f"gave up frame rate for {camera['reduced_s']:.0f} s, down to {lowest} a second"
    smaller = f", and half its size for {camera['halved_s']:.0f} s" if camera.get("halved_s") else ""
    return f"{shown}; {gave_up}{smaller}: the machine could not keep up"


def _motion(motion: Mapping[str, Any] | None) -> str:
    if motion is None:
        return "-"
    parts = ", ".join(
        f"{name} {motion[f'{name}_ms']:.0f} ms {'measured' if motion[f'{name}_measured'] else 'assumed'}"
        for name in ("steering", "acceleration")
    )
    spread = {name: motion[name] for name in ("p50", "p95", "p99")}
    return f"{_spread(spread)} ms, +-{motion['bound_ms']:.0f}; {parts}"


def _takeover(takeover: Mapping[str, Any]) -> list[tuple[str, str]]:
    reasons = "; ".join(reason["text"] for reason in takeover["reasons"])
    accepted = takeover["takeover_time_s"]
    answer = "nobody took over" if accepted is None else f"taken over after {accepted:.1f} s"
    return [("take-over", f"asked at {takeover['requested_s']:.1f} s, {answer}"), ("", reasons)]


CONTROL = frozenset({ECU, *(PROGRAMS[role] for role in (Role.VEHICLE_HUB, Role.AUTONOMY, Role.SIMULATE, Role.TOWER_HUB))})


def _loops(loops: Mapping[str, Mapping[str, Any]]) -> list[tuple[str, str]]:
    """The loops that steer and brake, and those that show and record: these give way first."""
    control = {name: loop for name, loop in loops.items() if name.partition("/")[0] in CONTROL}
    others = {name: loop for name, loop in loops.items() if name not in control}
    scheduling = ", ".join(sorted({loop["scheduling"] for loop in control.values()}))
    return [("control loops", _lateness(control) + f"; {scheduling}" * bool(scheduling)), ("other loops", _lateness(others))]


def _lateness(loops: Mapping[str, Mapping[str, Any]]) -> str:
    """Cycles that came later than one period, of all these loops, and the loop that was latest."""
    if not loops:
        return "-"
    late, cycles = (sum(loop[name] for loop in loops.values()) for name in ("late_cycles", "cycles"))
    worst = max(loops, key=lambda name: float(loops[name]["lateness_max_ms"]))
    share = f"{100 * late / cycles:.2f} %" if cycles else "-"
    return f"{late} of {cycles} cycles late ({share}), at most {loops[worst]['lateness_max_ms']:.0f} ms in {worst}"


def _load(load: Mapping[str, Any] | None) -> str:
    if load is None:
        return "-"
    stolen_s = max(load["stolen_s"].values(), default=None)
    return f"{_figure(load['cores'], '.2f')} cores in the mean, {_figure(stolen_s, '.1f')} s taken away from the machine"


def _yes(value: bool | None) -> str:
    return "-" if value is None else "reached" if value else "not reached"


def _figure(value: float | None, form: str) -> str:
    return "-" if value is None else format(value, form)


def _spread(figures: Mapping[str, Any] | None) -> str:
    if not figures:
        return "-"
    return " / ".join(f"{name.removesuffix('_ms')} {_figure(value, '.1f')}" for name, value in figures.items())


def _counts(counts: Mapping[str, int] | None) -> str:
    return ", ".join(f"{name} {count}" for name, count in (counts or {}).items()) or "none"
