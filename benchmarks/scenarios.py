"""`python -m benchmarks.scenarios`: the whole demo on each shipped scenario; goal, collisions, take-overs and the loop's age."""

import json
import sys
import tempfile
from pathlib import Path

from benchmarks.rig import RigError, driving

SCENARIOS = ("closed_road", "site_early", "mirrored", "reseeded")
PATIENCE_S = 180.0  # beyond the scenario's own time-out of 115 s


def drive(scenario: str) -> tuple[bool, str]:
    """Whether the drive went as it should, and its figures in a line."""
    with tempfile.TemporaryDirectory(prefix="scenarios-") as folder:
        try:
            with driving(Path(folder), "--scenario", scenario) as running:
                code = running.process.wait(PATIENCE_S)
            summary = json.loads((running.folder / "summary.json").read_text())
        except (RigError, OSError) as error:
            return False, str(error)
    takeovers, age = len(summary["takeovers"]), summary["loop_age_ms"] or {}
    good = code == 0 and summary["goal_reached"] and summary["collisions"] == 0 and takeovers == 1
    fps = summary["cameras"].get("front", {}).get("fps", 0)
    return good, (
        f"exit {code}, goal {summary['goal_reached']}, collisions {summary['collisions']}, take-overs {takeovers}, "
        f"{summary['drive_s']:.0f} s, loop age p50 {age.get('p50', 0):.0f} p99 {age.get('p99', 0):.0f} ms, {fps:.1f} fps"
    )


def main() -> int:
    failed = 0
    for scenario in SCENARIOS:
        good, text = drive(scenario)
        failed += not good
        print(f"{'good  ' if good else 'FAILED'}  {scenario:12s} {text}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
