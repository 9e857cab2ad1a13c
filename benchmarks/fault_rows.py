"""The results of a fault campaign: every shot as JSON, so that a broken-off campaign goes on, and a row a kind for people."""

import os
import platform
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import msgspec

HEAD = (
    *("kind", "what", "has to", "shots", "v m/s", "reaction s", "stood m", "bound m", "what happened", "operator told"),
    *("recording", "commit", "held"),
)


class Named(Protocol):
    """What is needed of benchmarks.fault_kinds.Kind."""

    @property
    def name(self) -> str: ...
    @property
    def what(self) -> str: ...
    @property
    def fate(self) -> str: ...


SLOW = "in slow motion"  # stands in the text of a shot that was


class Shot(msgspec.Struct, frozen=True, kw_only=True):
    """One fault at one instant."""

    kind: str
    number: int = 0
    speed_m_s: float = 0.0
    reaction_s: float | None = None  # None: it never braked
    stood_m: float | None = None  # None: it did not stop
    bound_m: float | None = None
    text: str = ""
    saw: str = ""  # mode and cause as the operator was told them last
    frozen: bool = False
    recording: bool = False  # whole, or repaired to be
    held: bool = False
    commit: str = ""


def load(file: Path) -> list[Shot]:
    return msgspec.json.decode(file.read_bytes(), type=list[Shot]) if file.is_file() else []


def save(file: Path, shots: Sequence[Shot], kinds: Sequence[Named], note: str) -> None:
    """Both forms, `file` and its .md, in the order of the kinds; kinds that no longer exist are left out."""
    kept = [shot for kind in kinds for shot in sorted(shots, key=lambda each: each.number) if shot.kind == kind.name]
    file.write_bytes(msgspec.json.format(msgspec.json.encode(kept), indent=1) + b"\n")
    file.with_suffix(".md").write_text(table(kept, kinds, note))


def table(shots: Sequence[Shot], kinds: Sequence[Named], note: str) -> str:
    machine = f"{os.cpu_count()} cores, {platform.machine()}, Python {platform.python_version()}"
    of_kind = {kind.name: [shot for shot in shots if shot.kind == kind.name] for kind in kinds}
    run = [kind for kind in kinds if of_kind[kind.name]]
    slow = sum(any(SLOW in shot.text for shot in of_kind[kind.name]) for kind in run)
    held = sum(all(shot.held for shot in of_kind[kind.name]) for kind in run)
    lines = [
        "# Faults, with real processes",
        "",
        f"`make faults`, {machine}, cameras half as wide and high: {held} of {len(run)} kinds held, {len(shots)} shots"
        f"{f'; {slow} kinds {SLOW} only' if slow else ''}. "
        "Worst of its shots in each column.",
        "",
        "Operator told: the mode and its cause as they last came to the window at the tower's hub; whether it was silent since,",
        "whether there was a window. FROZEN is the window's own word; which texts it shows it does not record.",
        "",
        f"`{note}`",
        "",
        f"| {' | '.join(HEAD)} |",
        "|---" * len(HEAD) + "|",
        *(_row(kind, of_kind[kind.name]) for kind in run),
        "",
    ]
    return "\n".join(lines)


def _row(kind: Named, shots: Sequence[Shot]) -> str:
    """The worst of its shots: the one that came closest to its bound, or beyond it."""
    worst = max(shots, key=lambda each: (not each.held, (each.stood_m or 0.0) / (each.bound_m or 1.0)))
    reactions = [shot.reaction_s for shot in shots if shot.reaction_s is not None]
    cells = (
        kind.name,
        kind.what,
        str(kind.fate),
        str(len(shots)),
        f"{worst.speed_m_s:.1f}",
        f"{max(reactions):.2f}" if reactions else "-",
        *("-" if value is None else f"{value:.2f}" for value in (worst.stood_m, worst.bound_m)),
        worst.text,
        worst.saw + (", FROZEN" if worst.frozen else ""),
        "whole" if all(shot.recording for shot in shots) else "lost",
        worst.commit,
        "yes" if all(shot.held for shot in shots) else "no",
    )
    return f"| {' | '.join(cells)} |"
