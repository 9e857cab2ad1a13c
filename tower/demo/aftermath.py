"""After the drive: make the recording whole if its recorder died, and sum it up with the recordings' own program."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

from rich.console import Console

PATIENCE_S = 60.0
UNFINISHED = 124  # exit code of a program that had to be given up, as timeout(1) has it


def told(command: list[str], patience_s: float = PATIENCE_S) -> subprocess.CompletedProcess[str]:
    """What a program said and its exit code; one that does not start or does not end says so on its stderr."""
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=patience_s, check=False)
    except subprocess.TimeoutExpired:
        text = f"not done within {patience_s:g} s; run it again: {' '.join(command)}"
    except OSError as error:
        text = f"{command[0]}: cannot be started: {error.strerror}; run: make setup"
    return subprocess.CompletedProcess(command, UNFINISHED, "", text)


def _recordings(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    return told([str(Path(sys.executable).parent / "recordings"), *map(str, arguments)])


def make_whole(folder: Path, console: Console) -> None:
    """Join the parts a killed recorder left behind into one drive.mcap; the parts are kept beside it."""
    parts = sorted(folder.glob("drive*.mcap"), key=lambda path: (len(path.name), path.name))
    if not parts or (len(parts) == 1 and _recordings("info", parts[0], "--json").returncode == 0):
        return
    joined = folder / "joined.mcap"
    done = _recordings("recover", *parts, "--output", joined)
    if done.returncode != 0:
        console.print(f"the recording could not be repaired: {done.stderr.strip()}", style="red")
        return
    for number, part in enumerate(parts, start=1):
        part.rename(folder / f"part-{number}.mcap")
    joined.rename(folder / "drive.mcap")
    console.print(f"the recording was repaired from {len(parts)} part{'s' if len(parts) > 1 else ''}")


def summarize(folder: Path, console: Console) -> dict[str, Any] | None:
    """Write summary.json, recomputed from drive.mcap; None when there is no readable recording, and why is told."""
    recording = folder / "drive.mcap"
    done = _recordings("info", recording, "--json") if recording.is_file() else None
    if done is None:
        return None
    if done.returncode != 0:
        console.print(f"the recording could not be summed up: {done.stderr.strip()}", style="red")
        return None
    (folder / "summary.json").write_text(done.stdout)
    summary: dict[str, Any] = json.loads(done.stdout)
    return summary
