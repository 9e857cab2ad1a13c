"""What is compiled belongs to the sources as they are, and once it is ready nothing is compiled again."""

import subprocess
import sys
from pathlib import Path

import numpy as np
from typer.testing import CliRunner

from autonomy.compile import COMPLETE, WARM_UPS, is_new, warm_up
from autonomy.planning.horizon import STEPS
from autonomy.planning.kernels import fingerprint, is_number, kept_in
from autonomy.planning.mpc import guess, risk, sqp
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.program import application
from benchmarks.planner_crowd import Drive


def test_any_change_of_any_source_asks_for_kernels_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "deeper").mkdir()
    (tmp_path / "one.py").write_text("A = 1\n")
    (tmp_path / "deeper" / "two.py").write_text("B = 2\n")
    before = fingerprint(tmp_path)
    assert fingerprint(tmp_path) == before
    (tmp_path / "deeper" / "two.py").write_text("B = 3\n")
    assert fingerprint(tmp_path) != before
    (tmp_path / "deeper" / "two.py").write_text("B = 2\n")
    assert fingerprint(tmp_path) == before
    (tmp_path / "one.py").rename(tmp_path / "three.py")
    assert fingerprint(tmp_path) != before


def test_after_the_warm_up_no_problem_waits_for_the_compiler() -> None:
    heard: list[str] = []
    warm_up(heard.append)
    assert all(any(line.startswith(f"{name}: ready") for line in heard) for name in WARM_UPS)
    assert not is_new() and fingerprint() in str(kept_in())
    entries = (sqp.optimise, guess.along, guess.from_places, risk.allocate, risk.quantiles)
    ready = [list(entry.signatures) for entry in entries]  # type: ignore[attr-defined]
    for people in (0, 3, 12):
        asked = Drive(0, people).problem()
        assert asked.predictions is not None
        places = np.linspace((0.0, 0.0), (10.0, 1.0), STEPS + 1)
        for sides in (None, half_spaces(places, asked.predictions)):
            solve(Drive(0, people).problem(sides), MpcSettings(), places)
            solve(Drive(0, people).problem(sides), MpcSettings())
    assert ready == [list(entry.signatures) for entry in entries]  # type: ignore[attr-defined]


def test_the_command_tells_what_it_compiles_and_nothing_when_all_is_there(monkeypatch) -> None:
    warm_up(lambda _: None)
    assert CliRunner().invoke(application, ["compile"]).output == ""
    monkeypatch.setattr("autonomy.compile.is_new", lambda: True)
    told = CliRunner().invoke(application, ["compile"]).output.splitlines()
    assert [line.partition(":")[0] for line in told[::2]] == list(WARM_UPS)


COLD = """
import gc
from autonomy.compile import warm_up
warm_up(lambda text: None)
from numba.core.registry import CPUDispatcher
from autonomy.planning.crossings.drive import drive
from autonomy.planning.crossings.driver import CAR, topology_driver
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.topology import TopologySettings

def kernels():
    found = [each for each in gc.get_objects() if isinstance(each, CPUDispatcher)]
    return {f"{each.py_func.__module__}.{each.py_func.__name__}": list(each.signatures) for each in found}

ready = kernels()
world = world_of(read_crossing(find_crossing("things"))[0], 0)
verdict, _ = drive(world, CAR, topology_driver(world, TopologySettings()))
assert verdict.duration_s > 10.0
print([name for name, signatures in kernels().items() if signatures != ready.get(name)])
"""


def test_after_the_warm_up_no_cycle_of_a_whole_drive_waits_for_a_kernel() -> None:
    """In a process of its own: in this one other tests have called them."""
    done = subprocess.run([sys.executable, "-c", COLD], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.strip()) == (0, "[]"), done.stderr


def test_a_compilation_that_was_broken_off_is_still_new(tmp_path: Path) -> None:
    (tmp_path / "planner").mkdir()
    (tmp_path / "planner" / "line.wrapped-59.py311.nbi").touch()
    assert is_new(tmp_path)
    (tmp_path / COMPLETE).touch()
    assert not is_new(tmp_path)


def test_a_kernel_tells_numbers_from_what_is_none() -> None:
    assert all(map(is_number, (0.0, -1.0, 1e250)))
    assert not any(map(is_number, (np.nan, np.inf, -np.inf)))
