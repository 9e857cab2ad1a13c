"""The results of the faults, one row a case: kept as JSON so that a broken-off campaign goes on, shown as a table for people."""

import os
import platform
import subprocess
from pathlib import Path

import msgspec

HEAD = "| moment | hurt | how | mode | speed m/s | stood after m | bound m | what happened | held | commit |"


class Row(msgspec.Struct, frozen=True, kw_only=True):
    case: str
    moment: str
    victim: str
    how: str
    mode: str = ""  # in which the fault took effect; "" when it never came to it
    speed_m_s: float = 0.0
    stood_m: float | None = None  # None when the drive was to go on
    bound_m: float | None = None
    held: bool = False
    text: str = ""
    commit: str = ""


def present_commit() -> str:
    """The commit of the code that runs, with a + when files were changed since; "unknown" outside a repository."""

    def git(*arguments: str) -> str:
        return subprocess.run(["git", *arguments], capture_output=True, text=True, check=False).stdout.strip()

    changed = git("status", "--porcelain", "--", "*.py", "*.toml", "*.dbc")
    return (git("rev-parse", "--short", "HEAD") or "unknown") + ("+" if changed else "")


def load(file: Path) -> dict[str, Row]:
    rows = msgspec.json.decode(file.read_bytes(), type=list[Row]) if file.is_file() else []
    return {row.case: row for row in rows}


def save(file: Path, rows: dict[str, Row], order: tuple[str, ...], note: str) -> None:
    """Both forms, `file` and its .md, in the order of the campaign; cases that no longer exist are left out."""
    kept = [rows[name] for name in order if name in rows]
    file.write_bytes(msgspec.json.format(msgspec.json.encode(kept), indent=1) + b"\n")
    file.with_suffix(".md").write_text(_table(kept, note))


def _table(rows: list[Row], note: str) -> str:
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    held = sum(row.held for row in rows)
    lines = [
        "# Faults in every mode of a drive, with real processes", "", f"`make mode-faults`, {machine}: {held} of {len(rows)} held.",
        "", f"`{note}`", "",
        HEAD, "|---" * (HEAD.count("|") - 1) + "|", *map(_line, rows), "",
    ]  # fmt: skip
    return "\n".join(lines)


def _line(row: Row) -> str:
    stood, bound = (("-" if value is None else f"{value:.2f}") for value in (row.stood_m, row.bound_m))
    text = row.text.splitlines()[0] if row.text else ""
    cells = (row.moment, row.victim, row.how, row.mode, f"{row.speed_m_s:.1f}", stood, bound, text,
             "yes" if row.held else "no", row.commit)  # fmt: skip
    return f"| {' | '.join(cells)} |"
