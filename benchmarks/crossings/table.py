"""`make table1`: every method through every crossing with the same seeds, as Markdown. Goes on where it was broken off.

    python -m benchmarks.crossings.table [--seeds N] [--crossings NAME ...] [--out FILE]

Only the whole of it, every crossing with at least 100 seeds, is written to benchmarks/results/table1.md; a part is printed, and
written where --out says.

Paired: the same seed is the same people. A difference of durations is told over the seeds in which neither of the two collided;
its interval is a bootstrap of those pairs (10,000 resamples, percentiles). A time-out counts as the 40 s that it took. Where most
pairs are equal that interval alone says "sure" too often (four seeds of a hundred, all of one sign, are enough); so a difference
is called sure only when turning the signs of the pairs at random gives as large a mean in less than 5 % of the cases as well.
"""

import argparse
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import numpy as np

from autonomy.outputs import check_output
from autonomy.planning.crossings.drive import EDGE_M
from benchmarks.crossings.methods import METHODS, TUNING
from benchmarks.crossings.runs import Run, Runs
from benchmarks.figures import commit, machine
from wire.configuration import shipped

RESULT = Path("benchmarks/results/table1.md")
SEEDS = 100
OURS, PEERS = "T-MPC++", ("braking planner", "LMPCC", "T-MPC++ without the unguided planner")
RESAMPLES = 10_000
SURE = 0.05
# The paper, Table I (25 runs each): duration s (sd), collisions, time-outs, mean speed m/s
PAPER = {
    ("crossers_0", "braking planner"): "19.5 (0.1), 0, 0, 1.87",
    ("crossers_0", "T-MPC++"): "19.4 (0.3), 0, 0, 1.86",
    ("crossers_2", "braking planner"): "24.0 (4.2), 1, 0, 1.54",
    ("crossers_2", "LMPCC"): "22.4 (3.3), 0, 0, 1.65",
    ("crossers_2", "T-MPC++ without the unguided planner"): "21.5 (1.6), 0, 0, 1.70",
    ("crossers_2", "T-MPC++"): "21.6 (1.8), 0, 0, 1.70",
    ("crossers_4", "braking planner"): "27.9 (9.7), 2, 3, 1.22",
    ("crossers_4", "LMPCC"): "26.7 (6.6), 1, 2, 1.43",
    ("crossers_4", "T-MPC++ without the unguided planner"): "24.0 (3.3), 0, 0, 1.57",
    ("crossers_4", "T-MPC++"): "23.5 (3.8), 0, 0, 1.61",
}
HEAD = """# Table I: planners among people who cross

`make table1`, {machine}, commit {commit}: {seeds} seeds of {which}, the same people for
each method. Durations in seconds (standard deviation); collisions with a person, a thing or the road's edge (a corner
{edge_m:g} m beyond it); time-outs at 40 s. Beyond edge: the farthest that a corner was in any run. Braked: cycles of 0.1 s
without a plan, for each run. The paper's rows are for its own scenario, which is not public: another street, 25 runs, and
Autoware's planner beside our braking planner. Recorded people are no part of it: their CSV is the user's
(`config/crossings/examples`).

A difference is called shorter or longer when the bootstrap's 95 % interval leaves out 0 and p of a paired sign-flip test is below
0.05, not corrected for the number of comparisons: of {comparisons}, at most about {chance:.0f} would be called so by chance alone.

Tuned with the same effort, nine settings each, on a street and on seeds that are not reported
(`python -m benchmarks.crossings.tuning`): {tuning}.
`crossers_*` were fixed before any planner had driven; `meeting_*` were added when those had shown that most people
have crossed before the car comes, and before any planner was tuned. `cyclist` and `occluded_4` were made anew, by geometry
alone, after planners had driven and been tuned: in the old ones riders left the bends and nobody stepped out near the car. How
riders are predicted (`along_street.py`) was chosen on `cyclist` itself, with seeds 100 to 149.
"""


def main(arguments: Sequence[str] | None = None) -> None:
    asked = argparse.ArgumentParser(prog="python -m benchmarks.crossings.table", description="Table I")
    asked.add_argument("--seeds", type=int, default=SEEDS, help="seeds of every crossing")
    asked.add_argument("--crossings", nargs="*", default=reported(), help="names in config/crossings")
    asked.add_argument("--out", type=Path, help=f"where to write it; default: {RESULT} for the whole, nowhere for a part")
    options = asked.parse_args(arguments)
    if options.out is not None:
        check_output("--out", ".md", options.out)
    kept, parts = Runs(), []
    for crossing in options.crossings:
        runs = list(kept.of(crossing, METHODS, range(options.seeds)))
        parts.append(section(crossing, runs))
        print(parts[-1], flush=True)
    out = options.out or written_to(options.seeds, options.crossings)
    if out is not None:
        out.write_text("\n".join((head(options.seeds, options.crossings), *parts)))


def written_to(seeds: int, crossings: Sequence[str]) -> Path | None:
    """A part must not stand where the whole is read."""
    return RESULT if seeds >= SEEDS and set(crossings) >= set(reported()) else None


def head(seeds: int, crossings: Sequence[str]) -> str:
    every = set(crossings) >= set(reported())
    which = "every crossing in `config/crossings`" if every else ", ".join(crossings)
    compared = len(crossings) * len(PEERS)
    return HEAD.format(
        machine=machine(),
        commit=commit(),
        seeds=seeds,
        which=which,
        tuning=TUNING,
        edge_m=EDGE_M,
        comparisons=compared,
        chance=SURE * compared,
    )


def reported() -> list[str]:
    """Every shipped crossing that nothing is tuned or trained on."""
    return sorted(path.stem for path in shipped("crossings").glob("*.toml") if not path.stem.startswith(("tuning", "training")))


def section(crossing: str, runs: Sequence[Run]) -> str:
    by_method = {name: [run for run in runs if run.method == name] for name in METHODS}
    rows = [f"| {name} | {told(mine)} | {PAPER.get((crossing, name), '')} |" for name, mine in by_method.items()]
    beside = [f"- beside {peer}: {difference(by_method[OURS], by_method[peer])}" for peer in PEERS]
    head = [
        "| method | duration | collisions | time-outs | mean speed m/s | closest m | beyond edge m | braked | the paper's |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    return "\n".join([f"## {crossing}", "", *head, *rows, "", f"{OURS}", *beside, ""])


def told(runs: Sequence[Run]) -> str:
    verdicts = [run.verdict for run in runs]
    durations = [verdict.duration_s for verdict in verdicts if not verdict.collided]
    spread = f"{np.mean(durations):.1f} ({np.std(durations, ddof=1):.1f})" if len(durations) > 1 else "-"
    hits, late = sum(verdict.collided for verdict in verdicts), sum(verdict.timed_out for verdict in verdicts)
    speed = np.mean([verdict.mean_speed_m_s for verdict in verdicts])
    closest = min((verdict.closest_m for verdict in verdicts if verdict.closest_m is not None), default=None)
    near = "-" if closest is None else f"{closest:.2f}"
    beyond, braked = max(verdict.off_road_m for verdict in verdicts), np.mean([verdict.braked for verdict in verdicts])
    return f"{spread} | {hits} | {late} | {speed:.2f} | {near} | {beyond:.3f} | {braked:.1f}"


def difference(ours: Sequence[Run], theirs: Sequence[Run]) -> str:
    pairs = [(a.verdict, b.verdict) for a, b in zip(ours, theirs, strict=True)]
    by_s = np.array([a.duration_s - b.duration_s for a, b in pairs if not a.collided and not b.collided])
    (low, high), p = interval(by_s), flipped(by_s)
    sure = p < SURE and not low <= 0.0 <= high
    word = "no difference that is sure" if not sure else "shorter" if high < 0.0 else "longer"
    apart = int((np.abs(by_s) > 0.05).sum())
    return f"{by_s.mean():+.2f} s [{low:+.2f}, {high:+.2f}], p {p:.4f}, {word}; another duration in {apart} of {len(by_s)} seeds"


def interval(values: np.ndarray) -> tuple[float, float]:
    """95 %, of the mean."""
    random = np.random.default_rng(0)
    means = values[random.integers(0, len(values), (RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.percentile(means, (2.5, 97.5))
    return float(low), float(high)


def flipped(values: np.ndarray) -> float:
    """p of a paired sign-flip test, two-sided: all signs of the values that are not 0, or as many random ones as RESAMPLES."""
    changed = values[values != 0.0]
    if 2 ** len(changed) <= RESAMPLES:
        signs = np.array(list(product((1.0, -1.0), repeat=len(changed))))
        return float((np.abs(signs @ changed) >= abs(changed.sum()) - 1e-9).mean())
    signs = np.random.default_rng(0).choice((1.0, -1.0), (RESAMPLES, len(changed)))
    return float((1 + (np.abs(signs @ changed) >= abs(changed.sum()) - 1e-9).sum()) / (1 + RESAMPLES))


if __name__ == "__main__":
    main()
