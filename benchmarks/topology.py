"""One whole cycle of the planner among people: guidance, a local planner for each of its ways and one without, the decision.

Closed loops over reported streets: T-MPC++ drives, so that every cycle goes on from its last; its cycle beside the one that plans
a single trajectory (LMPCC) in drives of its own. CPU time of the thread; the first cycle of a drive, which has nothing to go on
from, counts as well.
"""

import gc
from collections.abc import Iterator
from time import thread_time_ns

from autonomy.compile import WARM_UPS
from autonomy.planning.crossings.drive import Asked, Seen, drive
from autonomy.planning.crossings.driver import CAR, TUNED, topology_driver
from autonomy.planning.crossings.scenario import World, find_crossing, read_crossing, world_of
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.topology import TopologySettings
from benchmarks.figures import Figure, figure, percentile

NAME = "topology"
STREETS = {"crossers_4": 5.0, "meeting_4": 5.0, "crossers_12": 10.0}  # and the reach of p95, ms: 4 and 12 people
SEEDS = range(6)
SHARES = (("p50", 0.5), ("p95", 0.95), ("p99", 0.99))


def figures() -> Iterator[Figure]:
    for make_ready in WARM_UPS.values():
        make_ready()
    gc.collect()
    gc.disable()
    try:
        for street, reach_ms in STREETS.items():
            yield from _of(street, reach_ms)
    finally:
        gc.enable()


def _of(street: str, reach_ms: float) -> Iterator[Figure]:
    crossing, tracks = read_crossing(find_crossing(street))
    worlds = [world_of(crossing, crossing.first_seed + seed, tracks) for seed in SEEDS]
    ours = [ms for world in worlds for ms in cycles_ms(world, settings_of(TUNED))]
    alone = [ms for world in worlds for ms in cycles_ms(world, settings_of(TUNED, guided=False))]
    for what, share in SHARES:
        peer = ("one trajectory (LMPCC)", percentile(alone, share))
        reach = reach_ms if what == "p95" else None
        yield figure(NAME, street, what, "ms CPU", percentile(ours, share), peer=peer, at_most=reach)


def settings_of(local: MpcSettings, guided: bool = True) -> TopologySettings:
    return TopologySettings(local=local, guided=guided)


def cycles_ms(world: World, settings: TopologySettings) -> list[float]:
    """CPU time of every cycle of one drive."""
    planner = topology_driver(world, settings)
    took: list[float] = []

    def timed(seen: Seen) -> Asked:
        began_ns = thread_time_ns()
        asked = planner(seen)
        took.append((thread_time_ns() - began_ns) / 1e6)
        return asked

    drive(world, CAR, timed)
    return took
