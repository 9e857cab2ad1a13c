"""`python -m benchmarks [NAME...] [--json FILE]`: every performance figure, ours beside its peer or floor, by one command."""

import sys
from pathlib import Path
from typing import Annotated

import msgspec
import typer
from rich.console import Console

from benchmarks.figures import Figure
from benchmarks.registry import BENCHMARKS
from benchmarks.rig import RigError
from benchmarks.table import table_of

WIDTH = 160  # columns where there is no terminal


def main(
    names: Annotated[
        list[str] | None, typer.Argument(metavar="[NAME]...", help=f"{', '.join(BENCHMARKS)}; all by default.")
    ] = None,
    json: Annotated[Path | None, typer.Option(help="Also write them to this file; what it holds of others stays.")] = None,
) -> None:
    """Measure, and tell: a table here, a JSON list in a file. Exit code 1 when something could not be measured."""
    chosen = tuple(names or BENCHMARKS)
    unknown = [name for name in chosen if name not in BENCHMARKS]
    if unknown:
        print(f"unknown: {', '.join(unknown)}; known: {', '.join(BENCHMARKS)}", file=sys.stderr)
        raise typer.Exit(2)
    if json is not None and not json.parent.is_dir():
        print(f"--json {json}: no such folder", file=sys.stderr)
        raise typer.Exit(2)
    figures, failed = measure(chosen)
    console = Console(width=None if sys.stdout.isatty() else WIDTH, highlight=False)
    console.print(table_of(figures))
    if json is not None:
        write(json, figures, chosen)
    raise typer.Exit(1 if failed else 0)


def write(file: Path, figures: list[Figure], measured: tuple[str, ...]) -> None:
    """The figures into a JSON list, in place of those that the file holds of the same benchmarks."""
    held = msgspec.json.decode(file.read_bytes(), type=list[Figure]) if file.exists() else []
    kept = [each for each in held if each.name not in measured]
    ordered = sorted((*kept, *figures), key=lambda each: list(BENCHMARKS).index(each.name) if each.name in BENCHMARKS else -1)
    file.write_bytes(msgspec.json.format(msgspec.json.encode(ordered), indent=1) + b"\n")


def measure(names: tuple[str, ...]) -> tuple[list[Figure], bool]:
    """The figures of these benchmarks, and whether one of them could not be measured (it is told)."""
    figures: list[Figure] = []
    failed = False
    for name in names:
        print(f"measuring: {name}", file=sys.stderr, flush=True)
        try:
            figures.extend(BENCHMARKS[name]())
        except RigError as error:
            print(f"{name}: {error}", file=sys.stderr)
            failed = True
    return figures, failed


if __name__ == "__main__":
    typer.run(main)
