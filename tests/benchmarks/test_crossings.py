"""Table I's own arithmetic, and that a run is made once."""

from contextlib import chdir
from pathlib import Path

import numpy as np
import pytest
from msgspec.structs import replace

from autonomy.planning.crossings.drive import Asked, Verdict, drive
from autonomy.planning.crossings.driver import CAR, TUNED
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.training.collect import CROSSINGS
from benchmarks.crossings.methods import BRISK_M_S2, GAP_M, METHODS, street_as_lane
from benchmarks.crossings.runs import Run, Runs
from benchmarks.crossings.table import RESULT, SEEDS, difference, flipped, head, interval, main, reported, told, written_to
from benchmarks.crossings.tuning import candidates
from wire.configuration import shipped


def run(seed: int, duration_s: float, collided: bool = False, timed_out: bool = False) -> Run:
    verdict = Verdict(
        duration_s=duration_s, collided=collided, timed_out=timed_out, mean_speed_m_s=1.5, closest_m=0.7, off_road_m=0.0, braked=1
    )
    return Run(crossing="a", method="b", seed=seed, sources="c", verdict=verdict)


def test_the_interval_of_a_mean_is_what_the_normal_distribution_says() -> None:
    values = np.random.default_rng(1).normal(3.0, 2.0, 400)
    low, high = interval(values)
    half = 1.96 * values.std(ddof=1) / 20.0
    assert (low, high) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.02)


def test_pairs_of_which_one_collided_have_no_difference_of_durations() -> None:
    ours = [run(seed, 20.0 + seed % 2) for seed in range(10)] + [run(10, 3.0, collided=True)]
    theirs = [run(seed, 21.0 + seed % 2) for seed in range(10)] + [run(10, 40.0)]
    assert difference(ours, theirs) == "-1.00 s [-1.00, -1.00], p 0.0020, shorter; another duration in 10 of 10 seeds"
    assert "no difference" in difference(ours[:10], ours[:10])


def test_a_few_pairs_among_equal_ones_are_no_sure_difference() -> None:
    """Four of one sign among a hundred: the bootstrap's interval leaves out 0, but one in eight such quartets has one sign."""
    values = np.zeros(100)
    values[:4] = -0.2
    assert interval(values)[1] < 0.0 and flipped(values) == 0.125
    ours, theirs = [run(k, 20.0 + values[k]) for k in range(100)], [run(k, 20.0) for k in range(100)]
    assert "p 0.1250, no difference that is sure; another duration in 4 of 100 seeds" in difference(ours, theirs)


def test_the_sign_flip_test_calls_as_many_sure_as_it_should() -> None:
    random = np.random.default_rng(2)
    for zeros in (0, 88):
        values = [np.append(random.normal(0.0, 1.0, 100 - zeros), np.zeros(zeros)) for _ in range(300)]
        assert 0.02 < np.mean([flipped(each) < 0.05 for each in values]) < 0.09
    assert flipped(np.zeros(5)) == 1.0 and flipped(random.normal(1.0, 1.0, 100)) < 0.001


def test_a_row_counts_collisions_and_time_outs_and_gives_durations_of_the_others() -> None:
    assert told([run(0, 20.0), run(1, 22.0), run(2, 5.0, collided=True), run(3, 40.0, timed_out=True)]) == (
        "27.3 (11.0) | 1 | 1 | 1.50 | 0.70 | 0.000 | 1.0"
    )


def test_a_run_is_made_once_and_again_only_for_another_seed(tmp_path: Path) -> None:
    made: list[int] = []

    def off_at_once(world):
        made.append(1)
        return lambda seen: Asked(2.0 - seen.car.speed_m_s, 0.5)

    first = list(Runs(tmp_path).of("crossers_0", {"m": off_at_once}, range(2)))
    with (tmp_path / "crossers_0.jsonl").open("ab") as file:
        file.write(b'{"crossing":"cross')  # it was killed here
    again = list(Runs(tmp_path).of("crossers_0", {"m": off_at_once}, range(3)))
    assert again[:2] == first
    assert len(made) == 3
    assert all(each.verdict.collided for each in again)


def test_a_part_of_the_table_never_stands_where_the_whole_is_read(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    whole = tmp_path / RESULT
    whole.parent.mkdir(parents=True)
    whole.write_text("the whole")
    with chdir(tmp_path):
        main(["--crossings", "crossers_0", "--seeds", "1"])
        assert "## crossers_0" in capsys.readouterr().out
        assert list(tmp_path.rglob("*.md")) == [whole] and whole.read_text() == "the whole"
        main(["--crossings", "crossers_0", "--seeds", "1", "--out", "part.md"])
    part = (tmp_path / "part.md").read_text()
    assert "1 seeds of crossers_0, the same" in part and "every crossing" not in part and "## crossers_0" in part


def test_only_every_crossing_with_all_seeds_is_the_whole_table() -> None:
    assert written_to(SEEDS, reported()) == RESULT
    assert written_to(SEEDS - 1, reported()) is None
    assert written_to(SEEDS, reported()[1:]) is None
    assert "100 seeds of every crossing" in head(100, reported())


def test_the_table_says_that_the_tuned_values_lie_at_the_edge_of_what_was_tried() -> None:
    tuned = TUNED.weights
    for name, settings in candidates().items():
        mine = (BRISK_M_S2, GAP_M) if name == "braking planner" else (tuned.acceleration, tuned.speed)
        best = f"acceleration {mine[0]}, {'gap' if name == 'braking planner' else 'speed'} {mine[1]}"
        accelerations, others = ({text.split(", ")[k].split()[1] for text in settings} for k in (0, 1))
        assert best in settings  # and each of its two values is the least or the most of its column
        assert mine[0] in (min(map(float, accelerations)), max(map(float, accelerations)))
        assert mine[1] in (min(map(float, others)), max(map(float, others)))
    assert "the edge of what was tried" in head(100, reported())


def test_nothing_is_reported_that_was_tuned_or_trained_on() -> None:
    assert "crossers_4" in reported() and "meeting_4" in reported()
    others = {path.stem: read_crossing(path)[0].first_seed for path in shipped("crossings").glob("*.toml")}
    for name in reported():
        assert not name.startswith(("tuning", "training"))
        assert others.pop(name) == 0
    assert {"tuning_5", *CROSSINGS} == set(others) and min(others.values()) >= 100_000


@pytest.mark.parametrize("name", ["crossers_4", "occluded_4"])
def test_the_braking_planners_lane_is_the_street(name: str) -> None:
    world = world_of(read_crossing(find_crossing(name))[0], 0)
    lane = street_as_lane(world)
    half = world.crossing.half_width_m
    for station in np.arange(1.0, world.road.length_m, 3.0):
        x, y, heading = world.road.to_world(float(station))
        at = lane.to_road(x, y, float(station))
        assert at.offset_m == pytest.approx(-half, abs=1e-6)
        assert at.heading_rad == pytest.approx(heading, abs=1e-6)
    assert CAR.half_width_m < half


@pytest.mark.parametrize("seed", [2, 53])
def test_the_car_has_a_way_past_a_cyclist_who_comes_round_the_bend(seed: int) -> None:
    """Predicted straight on he crossed its lane: it stood turned to the left without a plan until, at 8 to 9 s, he rode into it."""
    crossing = replace(read_crossing(find_crossing("cyclist"))[0], time_limit_s=10.0)
    world = world_of(crossing, seed)
    verdict, _ = drive(world, CAR, METHODS["T-MPC++"](world))
    assert not verdict.collided and verdict.closest_m is not None and verdict.closest_m > 0.5
    assert verdict.braked < 5
