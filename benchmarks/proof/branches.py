"""`make test-coverage`: every branch of every file of the table is taken by its own tests; names each that is not."""

import json
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.proof.subjects import ROOT, Subject, chosen


def missing_of(subject: Subject, folder: Path) -> list[str]:
    """What its own tests do not reach, in words. Raises SystemExit when they fail."""
    data, report = folder / "data", folder / "report.json"
    coverage = [sys.executable, "-m", "coverage"]
    pytest = ["-m", "pytest", "-q", "-x", "-pno:cacheprovider", *subject.tests]
    ran = subprocess.run(
        [*coverage, "run", f"--data-file={data}", "--branch", f"--include={subject.source}", *pytest], cwd=ROOT, check=False
    )
    if ran.returncode:
        raise SystemExit(f"{subject.source}: its tests fail: pytest {' '.join(subject.tests)}")
    subprocess.run([*coverage, "json", f"--data-file={data}", "-q", "-o", str(report)], cwd=ROOT, check=True)
    found = json.loads(report.read_text())["files"][subject.source]
    lines = [f"line {line} is never run" for line in found["missing_lines"]]
    return lines + [f"from line {start} never to {_place(end)}" for start, end in found["missing_branches"]]


def _place(line: int) -> str:
    return f"line {line}" if line > 0 else "the end of the function"


def main(names: list[str]) -> int:
    said = []
    for subject in chosen(names):
        with TemporaryDirectory() as folder:
            missing = missing_of(subject, Path(folder))
        print(f"{subject.source}: {'every branch' if not missing else '; '.join(missing)}", flush=True)
        said += missing
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
