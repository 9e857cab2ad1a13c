"""How late every control loop is during the demo, plain and with SCHED_FIFO, with the time the machine was kept from us.

A real demo with every process, its cameras and its window, on its short scenario; ended by request after half a minute of
driving. Figures come from its summary, which the recording alone gives. Beside each, in the same run: a loop of 10 ms that
does nothing, scheduled alike. Late is a cycle more than one period after its own deadline.
"""

import json
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import tomli_w

from benchmarks.figures import Figure, figure
from benchmarks.rig import RigError, driving
from wire.configuration import read_tables, shipped
from wire.messages.vehicle import Mode
from wire.settings import PaceSettings
from wire.topics import ECU, PROGRAMS, Role

NAME = "lateness"
DRIVE_S, START_S = 20.0, 60.0
REACH_PLAIN_PERCENT, REACH_FIFO_PERCENT = 0.1, 0.0
CONTROL = {PROGRAMS[role] for role in (Role.VEHICLE_HUB, Role.TOWER_HUB, Role.AUTONOMY, Role.SIMULATE)} | {ECU}


class Run(NamedTuple):
    loops: dict[str, dict[str, Any]]  # of the summary, by "process/loop"
    stolen_s: float
    cores: float  # all processes together, in the mean
    floor: dict[str, float]


def figures() -> Iterator[Figure]:
    fifo = PaceSettings().fifo_priority
    for priority, case, reach in ((0, "plain", REACH_PLAIN_PERCENT), (fifo, f"SCHED_FIFO {fifo}", REACH_FIFO_PERCENT)):
        with tempfile.TemporaryDirectory(prefix="lateness-") as folder:
            run = drive(Path(folder), priority)
        late = ("a loop of 10 ms that does nothing", 100.0 * run.floor["late_cycles"] / run.floor["cycles"])
        for name, loop in run.loops.items():
            percent = 100.0 * loop["late_cycles"] / loop["cycles"]
            yield figure(NAME, f"{case}: {name}", f"late of {loop['cycles']}", "%", percent, peer=late, at_most=reach)
        worst = max(loop["lateness_max_ms"] for loop in run.loops.values())
        yield figure(NAME, f"{case}: all loops", "worst", "ms", worst, peer=(late[0], run.floor["worst_ms"]))
        yield figure(NAME, f"{case}: machine", "stolen time", "s", run.stolen_s)
        yield figure(NAME, f"{case}: all processes", "mean", "cores", run.cores)


def drive(folder: Path, fifo_priority: int) -> Run:
    """Half a minute of a demo. Raises RigError when it does not come to drive, or tells nothing of a control loop."""
    tables = read_tables(shipped("simulated.toml"))
    tables["wire"]["pace"] = {"fifo_priority": fifo_priority}
    config = folder / "plain.toml"
    config.write_bytes(tomli_w.dumps(tables).encode())
    with driving(folder, "--scenario", "short", "--config", str(config)) as running:
        running.wait_until("the car drives itself", lambda: running.mode is Mode.AUTONOMOUS, START_S)
        command = [sys.executable, "-m", "benchmarks.bare_loop", str(fifo_priority)]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as floor:
            time.sleep(DRIVE_S)
            floor.terminate()
            told = json.loads(floor.communicate()[0])
        running.end()
    summary = json.loads((running.folder / "summary.json").read_text())
    loops = {name: loop for name, loop in summary["loops"].items() if name.rpartition("/")[0] in CONTROL}
    silent = CONTROL - {name.rpartition("/")[0] for name in loops}
    if silent:
        raise RigError(f"nothing was told of the loops of {', '.join(sorted(silent))}")
    return Run(loops, max(summary["load"]["stolen_s"].values(), default=0.0), summary["load"]["cores"], told)
