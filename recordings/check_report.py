"""What the replay check found, for people: a table, and a line per step that differs. Decides nothing."""

from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.table import Table
from rich.text import Text

from recordings.check import Tally
from recordings.provenance import versions
from wire.software import PACKAGE


def show_check(path: Path, tallies: Sequence[Tally], recorded_by: dict[str, str], console: Console) -> None:
    """Print the steps per kind, and every mismatch that is told."""
    console.print(Text(f"{path}: recorded steps run again"), soft_wrap=True)
    table = Table()
    for number, name in enumerate(("steps", "checked", "differ", "not checked", "not recorded", "begun")):
        table.add_column(name, justify="right" if number else "left")
    for tally in tallies:
        counts = (tally.checked, tally.differing, tally.unchecked, tally.missing, tally.runs)
        table.add_row(tally.kind, *(str(count) for count in counts))
    console.print(table)
    for tally in tallies:
        for line in tally.mismatches:
            console.print(Text(line), soft_wrap=True)
        if tally.differing > len(tally.mismatches):
            console.print(Text(f"{tally.kind}: {tally.differing - len(tally.mismatches)} more differ"), soft_wrap=True)
        if not tally.checked:
            console.print(Text(f"{tally.kind}: no record says what it started from; nothing could be checked"), soft_wrap=True)
    if any(tally.differing for tally in tallies):
        console.print(Text(_other_version(recorded_by, versions())), soft_wrap=True)


def _other_version(recorded: dict[str, str], ours: dict[str, str]) -> str:
    """Another version may rightly compute something else: say so when it is another."""
    then, now = (one.get("commit") or one.get(PACKAGE) or "not told" for one in (recorded, ours))
    return f"recorded by {then}, run again by {now}" + ("" if then == now else ": another version may compute something else")
