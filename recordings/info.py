"""A summary for people, as rich tables. Decides and computes nothing."""

from collections.abc import Iterable

from rich.console import Console
from rich.table import Table
from rich.text import Text

from recordings.summary import Summary
from recordings.summary_modes import Takeover


def show(summary: Summary, console: Console) -> None:
    """Print the summary; a figure that the recording does not hold is shown as "-"."""
    about = summary.recording
    console.print(
        Text(
            f"{about.path}: {about.messages} messages on {len(about.topics)} channels, "
            f"{_number(summary.drive_s, 's')}, {_number(summary.distance_m, 'm')}"
        ),
        soft_wrap=True,
    )
    for table in (
        _drive(summary),
        _takeovers(summary.takeovers or ()),
        _latencies(summary),
        _pairs("Gate interventions", ("rule", "episodes"), summary.gate_interventions or {}),
        _pairs("Messages dropped", ("reason", "messages"), summary.messages_dropped),
        _loops(summary),
        _load(summary),
        _channels(summary),
    ):
        if table.row_count:
            console.print(table)


def _drive(summary: Summary) -> Table:
    table = _table("Drive", "", "")
    for mode, seconds in (summary.modes_s or {}).items():
        table.add_row(mode.replace("_", " "), _number(seconds, "s"))
    table.add_row("collisions", _or_dash(summary.collisions))
    table.add_row("goal reached", {True: "yes", False: "no", None: "-"}[summary.goal_reached])
    table.add_row("commands", _number(summary.command_rate_hz, "Hz"))
    return table


def _takeovers(found: Iterable[Takeover]) -> Table:
    table = _table("Take-over requests", "requested", "accepted", "took", "reasons")
    for takeover in found:
        reasons = "; ".join(f"{reason.channel}: {reason.text}" for reason in takeover.reasons)
        table.add_row(
            _number(takeover.requested_s, "s"),
            _number(takeover.accepted_s, "s"),
            _number(takeover.takeover_time_s, "s"),
            Text(reasons),
        )
    return table


def _latencies(summary: Summary) -> Table:
    table = _table("Latency", "", "p50", "p95", "p99", "")
    if summary.loop_age_ms is not None:
        age = summary.loop_age_ms
        table.add_row("loop age", *(_number(value, "ms") for value in (age.p50, age.p95, age.p99)), "")
    if summary.motion_to_motion_ms is not None:
        whole = summary.motion_to_motion_ms
        spread = (_number(value, "ms") for value in (whole.p50, whole.p95, whole.p99))
        table.add_row("motion to motion", *spread, f"+-{whole.bound_ms:.0f} ms")
    for name, camera in summary.cameras.items():
        late = camera.latency_ms
        values = (late.p50, late.p95, late.p99) if late is not None else (None, None, None)
        table.add_row(Text(f"{name}: camera to screen"), *(_number(value, "ms") for value in values), _number(camera.fps, "fps"))
    if summary.wheel_to_can_ms is not None:
        wheel = summary.wheel_to_can_ms
        table.add_row(
            "wheel to CAN", _number(wheel.p50, "ms"), "", _number(wheel.p99, "ms"), f"clock +-{wheel.clock_bound_ms:.2f} ms"
        )
    return table


def _loops(summary: Summary) -> Table:
    table = _table("Loops", "process/loop", "period", "cycles", "late", "usual", "worst", "scheduling")
    for name, loop in summary.loops.items():
        table.add_row(
            name,
            _number(loop.period_ms, "ms"),
            str(loop.cycles),
            str(loop.late_cycles),
            _number(loop.lateness_p50_ms, "ms"),
            _number(loop.lateness_max_ms, "ms"),
            loop.scheduling,
        )
    return table


def _load(summary: Summary) -> Table:
    table = _table("CPU", "process", "seconds", "cores")
    load = summary.load
    if load is None:
        return table
    for name, process in load.processes.items():
        table.add_row(name, _number(process.cpu_s, "s"), _cores(process.cores))
    table.add_row("together", "", _cores(load.cores))
    for name, seconds in load.stolen_s.items():
        table.add_row(f"taken away from the machine of {name}", _number(seconds, "s"), "")
    return table


def _cores(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"


def _channels(summary: Summary) -> Table:
    table = _table("Channels", "channel", "messages", "rate")
    for name, count in summary.recording.topics.items():
        rate = count / summary.drive_s if summary.drive_s else None
        table.add_row(name, str(count), _number(rate, "Hz"))
    return table


def _pairs(title: str, head: tuple[str, str], rows: dict[str, int]) -> Table:
    table = _table(title, *head)
    for name, count in rows.items():
        table.add_row(Text(name), str(count))
    return table


def _table(title: str, *columns: str) -> Table:
    table = Table(title=title, title_justify="left", show_header=any(columns))
    for number, column in enumerate(columns):
        words = number == 0 or column == "reasons"
        table.add_column(column, justify="left" if words else "right", overflow="fold" if words else "ellipsis")
    return table


def _number(value: float | None, unit: str) -> str:
    return "-" if value is None else f"{value:.1f} {unit}"


def _or_dash(value: int | None) -> str:
    return "-" if value is None else str(value)
