"""The figures as a table on the terminal."""

from collections.abc import Sequence

from rich.table import Table

from benchmarks.figures import Figure

HOLDS = {True: "[green]yes", False: "[bold red]no", None: ""}


def table_of(figures: Sequence[Figure]) -> Table:
    table = Table(title=f"{figures[0].machine}, commit {figures[0].commit}" if figures else "nothing was measured")
    for heading in ("benchmark", "case", "figure"):
        table.add_column(heading, overflow="fold")
    for heading in ("ours", "peer", "ratio"):
        table.add_column(heading, justify="right")
    for heading in ("beside", "reach", "holds"):
        table.add_column(heading, overflow="fold")
    for each in figures:
        table.add_row(*_cells(each), HOLDS[each.holds])
    return table


def _cells(each: Figure) -> tuple[str, ...]:
    peer = "" if each.peer_value is None else f"{each.peer_value:g} {each.unit}"
    ratio = "" if each.ratio is None else f"{each.ratio:g}"
    return each.name, each.case, each.figure, f"{each.ours:g} {each.unit}", peer, ratio, each.peer, each.reach
