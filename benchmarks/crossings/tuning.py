"""Tuning, with the same effort for every method: nine settings each, on crossings and seeds that are not reported.

    python -m benchmarks.crossings.tuning

What is compared is the mean duration, a collision or a time-out counting as a minute. What was found stands in `methods.py`.
"""

from collections.abc import Callable
from itertools import product

import numpy as np

from autonomy.control.speed import SpeedSettings
from autonomy.planning.braking_planner import PlanningSettings
from autonomy.planning.mpc.settings import MpcSettings, Weights
from autonomy.planning.topology import TopologySettings
from benchmarks.crossings.methods import Method, braking, topology
from benchmarks.crossings.runs import Run, Runs

CROSSING, SEEDS = "tuning_5", range(30)
WORST_S = 60.0


def candidates() -> dict[str, dict[str, Method]]:
    """By method, by what was set."""
    steps = list(product((4.0, 8.0, 13.0), (1.0, 2.0, 4.0)))
    found: dict[str, dict[str, Method]] = {
        "braking planner": {
            f"acceleration {acceleration}, gap {gap}": braking(
                PlanningSettings(acceleration_m_s2=acceleration, comfort_m_s2=acceleration, person_gap_m=gap),
                SpeedSettings(start_m_s2=acceleration),
            )
            for acceleration, gap in product((1.2, 2.0, 3.0), (1.2, 1.8, 2.5))
        }
    }
    for name, settings in KINDS.items():
        found[name] = {
            f"acceleration {acceleration}, speed {speed}": topology(settings(weights(acceleration, speed)))
            for acceleration, speed in steps
        }
    return found


KINDS: dict[str, Callable[[MpcSettings], TopologySettings]] = {
    "LMPCC": lambda local: TopologySettings(guided=False, local=local),
    "T-MPC++ without the unguided planner": lambda local: TopologySettings(unguided=False, local=local),
    "T-MPC++": lambda local: TopologySettings(local=local),
}


def weights(acceleration: float, speed: float) -> MpcSettings:
    return MpcSettings(weights=Weights(acceleration=acceleration, speed=speed))


def worth_s(runs: list[Run]) -> float:
    return float(np.mean([WORST_S if run.verdict.collided or run.verdict.timed_out else run.verdict.duration_s for run in runs]))


def main() -> None:
    kept = Runs()
    for method, settings in candidates().items():
        named = {f"{method}, {text}": made for text, made in settings.items()}
        runs = list(kept.of(CROSSING, named, SEEDS))
        for text in sorted(named, key=lambda text: worth_s([run for run in runs if run.method == text])):
            mine = [run for run in runs if run.method == text]
            hit = sum(run.verdict.collided for run in mine)
            late = sum(run.verdict.timed_out for run in mine)
            print(f"{worth_s(mine):6.2f} s  {hit} collisions, {late} time-outs  {text}", flush=True)


if __name__ == "__main__":
    main()
