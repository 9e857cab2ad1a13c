"""`make test-mutation`: every mutant of every file of the table must make its tests fail, or be listed as equivalent.

Resumable: verdicts are kept in .mutation/, by a hash of the source file and its tests; what did not change is not run again.
Fails for a survivor that is not listed, for a listed one that is killed or gone (stale), for more than 3 % listed.
Never changes a file of the project but the table of results.
"""

import hashlib
import json
import sys
import tomllib
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from benchmarks.proof.mutants import Mutant, mutants_of
from benchmarks.proof.subjects import ROOT, Subject, chosen
from benchmarks.proof.trial import Limits, try_out, warm_up

KEPT = ROOT / ".mutation"
LISTED = ROOT / "benchmarks/proof/equivalent_mutants.toml"
RESULTS = ROOT / "benchmarks/results/mutation.md"
EQUIVALENT_MAX = 0.03  # of a file's mutants
CPU_FACTOR, WALL_FACTOR, PATIENCE_S = 4.0, 20.0, 5.0  # of an unchanged run; hypothesis tries harder where nothing fails


class Result(NamedTuple):
    subject: Subject
    mutants: list[Mutant]
    survivors: list[Mutant]


def key_of(subject: Subject) -> str:
    """Changes when a verdict could."""
    engine = [ROOT / f"benchmarks/proof/{name}.py" for name in ("mutants", "trial")]
    digest = hashlib.sha256()
    for file in (ROOT / subject.source, *map(ROOT.joinpath, subject.tests), *engine):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def judge(subject: Subject) -> Result:
    """The verdict on each mutant of one file, from what is kept or by trying it out."""
    code = (ROOT / subject.source).read_text()
    mutants = mutants_of(code)
    file = KEPT / (subject.source.replace("/", ".") + ".jsonl")
    known = _kept(file, key_of(subject))
    missing = [mutant for mutant in mutants if _name(mutant) not in known]
    if missing:
        limits = _limits(subject, code)
        with file.open("a") as kept:
            for number, mutant in enumerate(missing, 1):
                verdict = try_out(subject, mutant.code, limits)
                known[_name(mutant)] = verdict.survived
                kept.write(json.dumps({"mutant": _name(mutant), "survived": verdict.survived, "how": verdict.how}) + "\n")
                kept.flush()
                if verdict.survived:
                    print(f"  survived  {mutant.name}", flush=True)
                if number % 50 == 0:
                    print(f"  {number} of {len(missing)}", flush=True)
    return Result(subject, mutants, [mutant for mutant in mutants if known[_name(mutant)]])


def _name(mutant: Mutant) -> str:
    return hashlib.sha256(mutant.code.encode()).hexdigest()[:16]


def _kept(file: Path, key: str) -> dict[str, bool]:
    """Verdicts of an earlier run with the same source and tests; begins a new file otherwise."""
    lines = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    if not lines or lines[0] != {"key": key}:
        file.parent.mkdir(exist_ok=True)
        file.write_text(json.dumps({"key": key}) + "\n")
        return {}
    return {line["mutant"]: line["survived"] for line in lines[1:]}


def _limits(subject: Subject, code: str) -> Limits:
    unchanged = try_out(subject, code, Limits(300.0, 600.0))
    if not unchanged.survived:
        raise SystemExit(f"{subject.source}: its own tests fail without any mutation: pytest {' '.join(subject.tests)}")
    return Limits(unchanged.cpu_s * CPU_FACTOR + PATIENCE_S, unchanged.cpu_s * WALL_FACTOR + 12 * PATIENCE_S)


def listed() -> dict[tuple[str, str, str, str], str]:
    """The equivalent mutants with the argument for each."""
    entries = tomllib.loads(LISTED.read_text()).get("mutant", [])
    return {(e["file"], e["scope"], e["was"], e["becomes"]): e["because"] for e in entries}


def _identity(subject: Subject, mutant: Mutant) -> tuple[str, str, str, str]:
    return (subject.source, mutant.scope, mutant.was, mutant.becomes)


def complaints(results: list[Result], equivalent: dict[tuple[str, str, str, str], str]) -> list[str]:
    """What makes the run fail, a line each."""
    said = []
    surviving = {_identity(result.subject, mutant) for result in results for mutant in result.survivors}
    files = {result.subject.source for result in results}
    for file, scope, was, becomes in sorted(surviving - equivalent.keys()):
        said.append(f"survived: {file} {scope or 'module'}: {was}  ->  {becomes}")
    for file, scope, was, becomes in sorted(equivalent.keys() - surviving):
        if file in files:
            said.append(f"stale in {LISTED.name}, killed or gone: {file} {scope or 'module'}: {was}  ->  {becomes}")
    for result in results:
        if len(result.survivors) > EQUIVALENT_MAX * len(result.mutants):
            said.append(f"{result.subject.source}: {len(result.survivors)} of {len(result.mutants)} survive; 3 % may be equivalent")
    return said


def row(result: Result, equivalent: dict[tuple[str, str, str, str], str]) -> str:
    argued = sum(_identity(result.subject, mutant) in equivalent for mutant in result.survivors)
    killed = len(result.mutants) - len(result.survivors)
    score = 100.0 * killed / max(len(result.mutants) - argued, 1)
    return f"| {result.subject.source} | {len(result.mutants)} | {killed} | {argued} | {score:.1f} % |"


def write_results(rows: list[str]) -> None:
    RESULTS.write_text(
        "# Mutants of the code that must be right\n\n"
        "`make test-mutation`, "
        + datetime.now(UTC).strftime("%Y-%m-%d")
        + ". A mutant is the file with one thing changed: it must make "
        "the file's own tests fail.\nThe score leaves out the equivalent ones, each argued in "
        "[equivalent_mutants.toml](../proof/equivalent_mutants.toml).\n\n"
        "| file | mutants | killed | equivalent | score |\n|---|---|---|---|---|\n" + "\n".join(rows) + "\n"
    )


def main(names: list[str]) -> int:
    warm_up()
    results = []
    equivalent = listed()
    for subject in (each for each in chosen(names) if each.mutated or names):
        print(subject.source, flush=True)
        results.append(judge(subject))
        print(row(results[-1], equivalent), flush=True)
    said = complaints(results, equivalent)
    print("\n".join(said))
    if not names and not said:
        write_results([row(result, equivalent) for result in results])
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
