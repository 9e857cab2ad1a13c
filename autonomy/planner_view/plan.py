"""`autonomy plan`: drives a crossing, says how it went, and writes pictures of what the planner thought."""

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import accumulate, chain
from pathlib import Path
from time import perf_counter

import cv2
import numpy as np

from autonomy.compile import is_new, warm_up
from autonomy.outputs import check_output, writing
from autonomy.planner_view.colours import Given, give
from autonomy.planner_view.film import write_film
from autonomy.planner_view.layers import Street, View, street_of, view
from autonomy.planner_view.picture import camera_over, picture
from autonomy.planner_view.record import write_recording
from autonomy.planner_view.sheet import Pixels
from autonomy.planner_view.watched import APART_M, METHODS, Cycle, Watched, cycle_at, different, most_telling, watch
from autonomy.planning.crossings.driver import CAR
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.guidance.state import Lack
from autonomy.planning.horizon import PLAN_PERIOD_S
from autonomy.planning.topology import Decision
from wire.configuration import ConfigurationError


@dataclass(frozen=True, slots=True, kw_only=True)
class Wanted:
    scenario: str
    seed: int | None = None  # the crossing's first
    method: str = "t-mpc++"
    plot: Path | None = None
    at_s: float | None = None  # of the picture; None: the most telling
    animate: Path | None = None
    record: Path | None = None


@dataclass(frozen=True, slots=True)
class Shown:
    """A drive, and what its pictures have in common."""

    watched: Watched
    title: str
    street: Street
    given: tuple[Given, ...]  # colours, cycle by cycle

    def view(self, number: int) -> View:
        return view(self.watched.world, self.street, self.watched.cycles[number], self.given[number], CAR)

    def picture(self, number: int) -> Pixels:
        seen = self.view(number)
        title = f"{self.title}   ·   t = {seen.time_s:.1f} s   ·   {seen.speed_m_s:.1f} m/s"
        return picture(seen, camera_over(self.watched.world)(seen), title)


def plan(wanted: Wanted, tell: Callable[[str], None]) -> bool:
    """Whether the goal was reached. Raises ConfigurationError with the fix, before anything is driven where that can be known."""
    settings = METHODS.get(wanted.method)
    if settings is None:
        raise ConfigurationError(f"--method {wanted.method!r}: no such method; one of {', '.join(METHODS)}")
    check_outputs(wanted)
    crossing, tracks = read_crossing(find_crossing(wanted.scenario))
    seed = crossing.first_seed if wanted.seed is None else wanted.seed
    world = world_of(crossing, seed, tracks)
    warm_up(tell if is_new() else lambda text: None)
    watched = watch(world, settings, perf_counter)
    shown = shown_of(watched, f"{crossing.name}, seed {seed}, {wanted.method}")
    for line in chain((shown.title,), verdict_lines(watched), written(wanted, shown)):
        tell(line)
    return not (watched.verdict.collided or watched.verdict.timed_out)


def check_outputs(wanted: Wanted) -> None:
    for option, ending, path in _outputs(wanted):
        check_output(option, ending, path)
    if wanted.at_s is not None and wanted.plot is None:
        raise ConfigurationError("--at says which moment --plot draws; name a picture with --plot FILE.png")


def _outputs(wanted: Wanted) -> list[tuple[str, str, Path]]:
    named = (("--plot", ".png", wanted.plot), ("--animate", ".mp4", wanted.animate), ("--record", ".mcap", wanted.record))
    return [(option, ending, path) for option, ending, path in named if path is not None]


def shown_of(watched: Watched, title: str) -> Shown:
    identities = ([each.identity for each in cycle.decision.candidates] for cycle in watched.cycles)
    given = tuple(accumulate(identities, give, initial=dict[int, int]()))[1:]
    return Shown(watched, title, street_of(watched.world), given)


def verdict_lines(watched: Watched) -> list[str]:
    verdict, took = watched.verdict, [cycle.took_ms for cycle in watched.cycles]
    end = "collided" if verdict.collided else "not reached in time" if verdict.timed_out else "reached"
    closest = "" if verdict.closest_m is None else f", closest {max(verdict.closest_m, 0.0):.2f} m"
    several = sum(different(cycle.decision) > 1 for cycle in watched.cycles)
    p50, p95 = np.percentile(took, (50, 95))
    return [
        f"goal            {end} after {verdict.duration_s:.1f} s, mean speed {verdict.mean_speed_m_s:.2f} m/s",
        f"collisions      {int(verdict.collided)}{closest}, beyond the edge {verdict.off_road_m:.2f} m",
        f"without a plan  {verdict.braked} of {len(took)} cycles{_refusals(watched.cycles)}",
        f"several ways    in {several} cycles, trajectories {APART_M:g} m and more apart",
        f"cycle           p50 {p50:.1f} ms, p95 {p95:.1f} ms",
    ]


def _refusals(cycles: tuple[Cycle, ...]) -> str:
    """What the planners refused to be asked, and in how many cycles; nothing when they only found no way."""
    refused = Counter(why for cycle in cycles for why in _refused(cycle.decision) if why)
    return "".join(f"; {why} in {count}" for why, count in refused.most_common())


def _refused(decision: Decision) -> set[str]:
    local = {each.trajectory.refused for each in decision.candidates}
    lack = decision.guidances.lack
    return local if local or lack in (None, Lack.NO_WAY) else {f"guidance: {lack.value}"}


def written(wanted: Wanted, shown: Shown) -> Iterator[str]:
    """What was written where, as it is done. Raises ConfigurationError when a disk refuses."""
    cycles = shown.watched.cycles
    if wanted.plot is not None:
        number = most_telling(cycles) if wanted.at_s is None else _named_moment(cycles, wanted.at_s)
        with writing("--plot", wanted.plot):
            _write_picture(wanted.plot, shown.picture(number))
        yield f"picture         {wanted.plot}, at {cycles[number].seen.time_s:.1f} s"
    if wanted.animate is not None:
        with writing("--animate", wanted.animate):
            write_film(wanted.animate, (shown.picture(number) for number in range(len(cycles))))
        yield f"film            {wanted.animate}"
    if wanted.record is not None:
        with writing("--record", wanted.record):
            write_recording(wanted.record, ((cycle, shown.view(n)) for n, cycle in enumerate(cycles)), {"drive": shown.title})
        yield f"recording       {wanted.record}: open it in Foxglove, its 3D panel shows planner_scene"


def _named_moment(cycles: tuple[Cycle, ...], at_s: float) -> int:
    end_s = cycles[-1].seen.time_s + PLAN_PERIOD_S
    if at_s > end_s:
        raise ConfigurationError(f"--at {at_s:g}: the drive ended after {end_s:.1f} s; name a time before that")
    return cycle_at(cycles, at_s)


def _write_picture(path: Path, pixels: Pixels) -> None:
    encoded, data = cv2.imencode(".png", pixels)
    assert encoded  # of pixels that we made
    path.write_bytes(data.tobytes())
