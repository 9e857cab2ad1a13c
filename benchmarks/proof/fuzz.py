"""`make fuzz`: ten million inputs, in all, for every decoder; goes on where it was broken off.

Guided by coverage with atheris where its wheel installs; otherwise the same changed inputs without guidance. The count and
what was interesting are kept in .fuzz/; an input that breaks a rule is kept there, too, and named. Writes the count with the
commit into benchmarks/results/fuzz.md.
"""

import importlib.util
import json
import random
import subprocess
import sys
import time
from collections import Counter
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from benchmarks.proof.noise import changed
from benchmarks.proof.subjects import ROOT

KEPT = ROOT / ".fuzz"
RESULTS = ROOT / "benchmarks/results/fuzz.md"
WANTED = 10_000_000
EVERY = 5_000  # inputs between two savings of the count
LONGEST_S = 5.0  # for one input, on a busy machine; all take milliseconds


class Tally:
    """How many inputs each target has had, over all runs."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / "count.json"
        folder.mkdir(exist_ok=True)
        self.counts: Counter[str] = Counter(json.loads(self._file.read_text()) if self._file.exists() else {})
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
    """arguments  how many inputs in this run; without, as many as are missing"""
    tally = Tally(KEPT)
    runs = int(arguments[0]) if arguments else max(WANTED - tally.counts.total(), 0)
    guided = importlib.util.find_spec("atheris") is not None
    print(f"{tally.counts.total():,} inputs so far, {runs:,} to come, {'guided by atheris' if guided else 'unguided'}", flush=True)
    with TemporaryDirectory(prefix="fuzz-") as folder:
        _run(tally, runs, _load(Path(folder), guided), guided)
    return 0


def _load(folder: Path, guided: bool) -> Any:
    """The targets; guided, with the decoders' own Python instrumented."""
    if guided:
        import atheris

        with atheris.instrument_imports(include=["wire", "recordings", "vehicle_gateway"]):
            from benchmarks.proof.targets import targets
    else:
        from benchmarks.proof.targets import targets
    return targets(folder)


def _run(tally: Tally, runs: int, known: Any, guided: bool) -> None:
    order = [number for number, target in enumerate(known) for _ in range(target.share)]
    source = random.Random(tally.counts.total())
    left = runs

    def try_one(data: bytes) -> None:
        nonlocal left
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


def write_results(counts: Counter[str], guided: bool) -> None:
    head = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    how = "guided by atheris" if guided else "unguided"
    rows = "\n".join(f"| {name} | {count:,} |" for name, count in sorted(counts.items()))
    RESULTS.write_text(
        f"# Fuzzing\n\n`make fuzz`, {datetime.now(UTC):%Y-%m-%d}, commit {head.stdout.strip()}, {how}: "
        f"**{counts.total():,} inputs** so far, none of which broke a rule:\nonly the documented errors, no NaN and no infinity "
        "let in, the same again after encoding and decoding, in bounded time.\n\n"
        "| decoder | inputs |\n|---|---|\n" + rows + "\n"
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
