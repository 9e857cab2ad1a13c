"""`make fuzz`: ten million inputs, in all, and 50,000 at least for each decoder; goes on where it was broken off.

Guided by coverage with atheris where its wheel installs; otherwise the same changed inputs without guidance. The count and
what was interesting are kept in .fuzz/; an input that breaks a rule is kept there, too, and named. Writes the count with the
commit into benchmarks/results/fuzz.md; a clone without .fuzz/ goes on from the count in there.
"""

import argparse
import importlib.util
import json
import random
import re
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.proof.noise import changed
from benchmarks.proof.rules import Target
from benchmarks.proof.subjects import ROOT

KEPT = ROOT / ".fuzz"
RESULTS = ROOT / "benchmarks/results/fuzz.md"
WANTED = 10_000_000
LEAST = 50_000  # of each; a decoder that lacks them is fuzzed before the others
EVERY = 5_000  # inputs between two savings of the count
_ROW = re.compile(r"^\| (.+) \| ([\d,]+) \|$", re.MULTILINE)
LONGEST_S = 5.0  # for one input, on a busy machine; all take milliseconds


class Tally:
    """How many inputs each target has had, over all runs."""

    def __init__(self, folder: Path, page: Path) -> None:
        """page  the committed table, for a folder without a count"""
        self._file = folder / "count.json"
        folder.mkdir(exist_ok=True)
        self.counts = Counter[str](json.loads(self._file.read_text()) if self._file.exists() else counts_in(page.read_text()))
        self._unsaved = 0

    def add(self, name: str) -> None:
        self.counts[name] += 1
        self._unsaved += 1
        if self._unsaved >= EVERY:
            self.save()

    def save(self) -> None:
        self._unsaved = 0
        self._file.write_text(json.dumps(self.counts))


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="make fuzz ARGS=", description=__doc__)
    parser.add_argument("inputs", nargs="?", type=int, help="how many in this run; without, as many as are missing")
    parser.add_argument("--only", default="", metavar="PART", help="decoders whose name contains this")
    asked = parser.parse_args(arguments)
    tally = Tally(KEPT, RESULTS)
    guided = importlib.util.find_spec("atheris") is not None
    with TemporaryDirectory(prefix="fuzz-") as folder:
        known = chosen(_load(Path(folder), guided), asked.only)
        runs = missing(tally.counts, [target.name for target in known]) if asked.inputs is None else asked.inputs
        how = "guided by atheris" if guided else "unguided"
        print(f"{tally.counts.total():,} inputs so far, {runs:,} to come, {how}", flush=True)
        _run(tally, runs, known, guided)
    return 0


def chosen(known: Sequence[Target], part: str) -> tuple[Target, ...]:
    """Those whose name contains `part`. Raises SystemExit with the known names when there is none."""
    found = tuple(target for target in known if part in target.name)
    if not found:
        raise SystemExit(f"{part}: no such decoder; there are: {', '.join(sorted(target.name for target in known))}")
    return found


def missing(counts: Counter[str], names: Sequence[str]) -> int:
    """How many inputs are to come."""
    return max(WANTED - counts.total(), sum(max(LEAST - counts[name], 0) for name in names))


def order_of(counts: Counter[str], known: Sequence[Target]) -> list[int]:
    """Numbers of targets, each as often as its share; of those alone that lack inputs, while there are any."""
    lacking = [number for number, target in enumerate(known) if counts[target.name] < LEAST]
    return lacking or [number for number, target in enumerate(known) for _ in range(target.share)]


def _load(folder: Path, guided: bool) -> tuple[Target, ...]:
    """The targets; guided, with the decoders' own Python instrumented."""
    if guided:
        import atheris

        with atheris.instrument_imports(include=["wire", "recordings", "vehicle_gateway"]):
            from benchmarks.proof.targets import targets
    else:
        from benchmarks.proof.targets import targets
    return targets(folder)


def _run(tally: Tally, runs: int, known: Sequence[Target], guided: bool) -> None:
    order = order_of(tally.counts, known)
    source = random.Random(tally.counts.total())
    left = runs

    def try_one(data: bytes) -> None:
        nonlocal left, order
        if left <= 0:
            return
        left -= 1
        target = known[order[int.from_bytes(data[:2], "little") % len(order)]]
        began_s = time.monotonic()
        try:
            target.try_one(data[2:])
        except BaseException:
            (KEPT / f"broke {target.name}.bin").write_bytes(data[2:])
            print(f"{target.name}: broken by the input in {KEPT}/broke {target.name}.bin", flush=True)
            raise
        if time.monotonic() - began_s > LONGEST_S:
            raise TimeoutError(f"{target.name}: one input took {time.monotonic() - began_s:.1f} s")
        tally.add(target.name)
        if tally.counts[target.name] == LEAST:
            order = order_of(tally.counts, known)
        if left == 0:
            tally.save()
            write_results(tally.counts, guided)

    def another(_: bytes = b"", longest: int = 1 << 20, seed: int = 0) -> bytes:
        """A seed, changed, for a target chosen by its share."""
        place = source.randrange(len(order))
        seeds = known[order[place]].seeds
        return (place.to_bytes(2, "little") + changed(source, source.choice(seeds)))[:longest]

    if not guided:
        while left > 0:
            try_one(another())
        return
    import atheris

    def mutate(data: bytes, longest: int, seed: int) -> bytes:
        """Half of them from a seed, half from what was interesting."""
        if source.random() < 0.5 or len(data) < 2:
            return another(longest=longest)
        body = bytes(data[2:])
        return (bytes(data[:2]) + (changed(source, body) if seed % 2 else atheris.Mutate(body, longest - 2)))[:longest]

    corpus = KEPT / "corpus"
    corpus.mkdir(exist_ok=True)
    options = [f"-runs={runs}", "-max_len=20000", "-print_final_stats=0", f"-artifact_prefix={KEPT}/", "-rss_limit_mb=0"]
    atheris.Setup([sys.argv[0], *options, str(corpus)], try_one, custom_mutator=mutate)
    atheris.Fuzz()


def counts_in(page: str) -> Counter[str]:
    """What a table says that `write_results` wrote."""
    return Counter({name: int(count.replace(",", "")) for name, count in _ROW.findall(page)})


def write_results(counts: Counter[str], guided: bool) -> None:
    head = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    RESULTS.write_text(page_of(counts, guided, head.stdout.strip()))


def page_of(counts: Counter[str], guided: bool, commit: str) -> str:
    how = "guided by atheris" if guided else "unguided"
    rows = "\n".join(f"| {name} | {count:,} |" for name, count in sorted(counts.items()))
    return (
        f"# Fuzzing\n\n`make fuzz`, {datetime.now(UTC):%Y-%m-%d}, commit {commit}, {how}: "
        f"**{counts.total():,} inputs** so far, none of which broke a rule:\nonly the documented errors, no NaN and no infinity "
        "let in, the same again after encoding and decoding, in bounded time.\n\n"
        "| decoder | inputs |\n|---|---|\n" + rows + "\n"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
