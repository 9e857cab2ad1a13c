"""What is compiled belongs to the sources as they are, and once it is ready nothing is compiled again."""

from pathlib import Path

import numpy as np

from autonomy.compile import WARM_UPS, is_new, warm_up
from autonomy.planning.horizon import STEPS
from autonomy.planning.kernels import fingerprint, is_number, kept_in
from autonomy.planning.mpc import guess, risk, sqp
from autonomy.planning.mpc.halfspaces import half_spaces
from autonomy.planning.mpc.planner import solve
from autonomy.planning.mpc.settings import MpcSettings
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


def test_a_kernel_tells_numbers_from_what_is_none() -> None:
    assert all(map(is_number, (0.0, -1.0, 1e250)))
    assert not any(map(is_number, (np.nan, np.inf, -np.inf)))
