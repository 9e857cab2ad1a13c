"""The learned guess: what it sees, that it can be driven, and that the planner does without it what it always did."""

from dataclasses import replace
from math import cos, sin, tan
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from msgspec.structs import replace as changed

from autonomy.planning.crossings.driver import CAR
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from autonomy.planning.guidance.state import Guidance
from autonomy.planning.horizon import STEP_S, STEPS, CarState, Predictions, Trajectory
from autonomy.planning.learned import features as seen
from autonomy.planning.learned import network
from autonomy.planning.learned.features import PEOPLE, features
from autonomy.planning.learned.guesses import guesses
from autonomy.planning.learned.network import SHAPES, Weights, inputs
from autonomy.planning.learned.warm_up import warm_up
from autonomy.planning.learned.weights import SHIPPED, read, shipped_weights, write
from autonomy.planning.mpc.problem import Problem
from autonomy.planning.mpc.settings import MpcSettings
from autonomy.planning.reference_path import through
from autonomy.planning.topology import Around, TopologySettings, TopologyState, plan
from autonomy.training.batches import Batch, mirrored
from autonomy.training.collect import samples_of

START = CarState(x_m=5.0, y_m=0.5, heading_rad=0.1, speed_m_s=1.6, road_wheel_angle_rad=0.05, station_m=5.0)
SETTINGS = MpcSettings()


def path(turn: float = 0.0, shift=(0.0, 0.0), side: float = 1.0):
    x = np.linspace(0.0, 60.0, 13)
    points = np.stack((x, side * np.sin(x / 10.0)), axis=1)
    headings = np.arctan(side * np.cos(x / 10.0) / 10.0)
    left, right = (np.full(len(x), room) for room in ((3.0, 2.5) if side > 0 else (2.5, 3.0)))
    return through(turned(points, turn, shift), headings + turn, left, right)


def turned(points, turn: float, shift):
    c, s = cos(turn), sin(turn)
    return points @ np.array(((c, s), (-s, c))) + np.array(shift)


def people(places, side: float = 1.0) -> Predictions:
    n = len(places)
    walked = STEP_S * np.arange(STEPS + 1)[:, None, None] * np.array((0.1, side * 0.7))
    return Predictions(
        numbers=tuple(range(n)),
        positions_m=np.array(places, float).reshape(1, n, 2) * np.array((1.0, side)) + walked,
        covariances_m2=np.tile(0.01 * np.eye(2), (STEPS + 1, n, 1, 1)),
        radii_m=np.linspace(0.3, 0.6, n),
    )


def way(side: float = 1.0) -> Guidance:
    """Straight on from the start and a little aside."""
    t = STEP_S * np.arange(STEPS + 1)
    places = np.stack((START.x_m + 1.6 * t, side * (START.y_m + 0.3 * np.sin(t))), axis=1)
    return Guidance(
        identity=0,
        code=(),
        middle_m=places,
        speeds_m_s=np.full(STEPS + 1, 1.6),
        rear_axle_m=places,
        headings_rad=side * 0.1 * np.cos(t),
        points_m=places[:10],
        cost_m=0.0,
    )


def some_weights(seed: int, loud: float) -> Weights:
    random = np.random.default_rng(seed)
    return Weights(**{name: random.normal(0.0, loud, shape).astype(np.float32) for name, shape in SHAPES.items()})


CROWD = [(9.0, -4.0), (12.0, 3.0), (17.0, -6.0)]


def test_where_the_street_lies_on_the_map_does_not_matter() -> None:
    told = features([way()], START, path(), people(CROWD), 2.0)
    turn, shift = 2.1, (300.0, -70.0)
    there = people(CROWD)
    moved_way = replace(way(), rear_axle_m=turned(way().rear_axle_m, turn, shift), headings_rad=way().headings_rad + turn)
    x, y = turned(np.array((START.x_m, START.y_m)), turn, shift)
    car = replace(START, x_m=x, y_m=y, heading_rad=START.heading_rad + turn)
    moved = features([moved_way], car, path(turn, shift), replace(there, positions_m=turned(there.positions_m, turn, shift)), 2.0)
    for one, other in zip(told, moved, strict=True):
        assert one == pytest.approx(other, abs=1e-5)


def test_a_mirror_image_of_the_street_is_told_as_the_mirror_image_of_what_is_told() -> None:
    told = features([way()], START, path(), people(CROWD), 2.0)
    car = replace(START, y_m=-START.y_m, heading_rad=-START.heading_rad, road_wheel_angle_rad=-START.road_wheel_angle_rad)
    other = features([way(-1.0)], car, path(side=-1.0), people(CROWD, -1.0), 2.0)
    nothing = np.zeros((1, 1), np.float32)
    image = mirrored(Batch(told.alone, told.people, nothing, np.zeros((1, STEPS + 1, 5), np.float32), np.zeros((1, STEPS, 2))))
    assert other.alone == pytest.approx(image.alone, abs=1e-5)
    assert other.people == pytest.approx(image.people, abs=1e-5)


def test_neither_the_order_of_people_nor_those_far_off_change_a_guess() -> None:
    weights = some_weights(1, 0.05)
    crowd = [(8.0 + k, -5.0 + 0.3 * k) for k in range(PEOPLE)]
    told = inputs(weights, features([way()], START, path(), people(crowd), 2.0))
    there = people([*crowd, (-200.0, 50.0)])
    order = np.random.default_rng(2).permutation(PEOPLE + 1)
    radii = np.append(people(crowd).radii_m, 0.3)
    shuffled = replace(there, positions_m=there.positions_m[:, order], radii_m=radii[order], numbers=tuple(order.tolist()))
    assert inputs(weights, features([way()], START, path(), shuffled, 2.0)) == pytest.approx(told, abs=1e-5)


@pytest.mark.parametrize("loud", [0.02, 1.0])
def test_a_guess_is_what_the_car_would_do_inside_its_bounds_whatever_the_weights(loud: float) -> None:
    problem = Problem(car=CAR, start=START, path=path(), predictions=people(CROWD), speed_m_s=2.0)
    (guess,) = guesses(some_weights(3, loud), [way()], problem, SETTINGS) or ()
    x, y, heading, speed, angle = guess.states[0, :5]
    parts = 50
    for k in range(STEPS):
        acceleration, rate = guess.inputs[k]
        assert abs(acceleration) <= 3.0 + 1e-9 and abs(rate) <= 1.5 + 1e-9
        for _ in range(parts):  # midpoints, in small steps
            dt = STEP_S / parts
            speed, angle = speed + acceleration * dt / 2, angle + rate * dt / 2
            heading += speed * tan(angle) / CAR.wheelbase_m * dt / 2
            x, y = x + speed * cos(heading) * dt, y + speed * sin(heading) * dt
            heading += speed * tan(angle) / CAR.wheelbase_m * dt / 2
            speed, angle = speed + acceleration * dt / 2, angle + rate * dt / 2
        assert guess.states[k + 1, :5] == pytest.approx((x, y, heading, speed, angle), abs=2e-3)
        assert speed >= -1e-9 and abs(angle) <= CAR.road_wheel_angle_max_rad + 1e-9


def test_ways_together_get_the_guesses_that_each_gets_alone() -> None:
    weights, ways = some_weights(4, 0.05), [way(), way(-1.0)]
    problem = Problem(car=CAR, start=START, path=path(), predictions=people(CROWD), speed_m_s=2.0)
    together = guesses(weights, ways, problem, SETTINGS) or ()
    for each, guess in zip(ways, together, strict=True):
        (alone,) = guesses(weights, [each], problem, SETTINGS) or ()
        assert alone.states == pytest.approx(guess.states, abs=1e-4)


def test_weights_that_are_missing_broken_or_no_numbers_are_none(tmp_path: Path) -> None:
    file = tmp_path / "weights.npz"
    assert read(file) is None
    weights = some_weights(5, 0.1)
    write(file, weights)
    kept = read(file)
    assert kept is not None and kept.into == pytest.approx(weights.into, abs=1e-3)
    write(file, weights._replace(out_bias=np.full_like(weights.out_bias, np.nan)))
    assert read(file) is None
    write(file, weights._replace(out_bias=weights.out_bias[:-1]))
    assert read(file) is None
    file.write_bytes(b"PK\x03\x04 of an archive that ends here")
    assert read(file) is None
    np.save(file.with_suffix(".npy"), np.zeros(3))
    assert read(file.with_suffix(".npy")) is None


@pytest.mark.filterwarnings("ignore:invalid escape sequence")  # in what is left of an array's header
def test_weights_with_any_bit_flipped_are_read_or_are_none(tmp_path: Path) -> None:
    file, shipped = tmp_path / "weights.npz", SHIPPED.read_bytes()
    headers = (at for part in ZipFile(SHIPPED).infolist() for at in range(part.header_offset, part.header_offset + 260, 5))
    for at in (*headers, *range(len(shipped) - 600, len(shipped), 7)):
        file.write_bytes(shipped[:at] + bytes([shipped[at] ^ 1 << at % 8]) + shipped[at + 1 :])
        weights = read(file)
        assert weights is None or np.isfinite(weights.into).all()


def test_the_weights_that_are_shipped_are_small_and_say_how_they_were_made() -> None:
    assert shipped_weights() is not None
    assert SHIPPED.stat().st_size < 300_000
    assert "autonomy train-guess --drives" in SHIPPED.with_suffix(".md").read_text()


BAD = {
    "nobody looked": {"predictions": None},
    "a start that is no number": {"start": replace(START, x_m=np.nan)},
    "predictions that are none": {"predictions": replace(people(CROWD), positions_m=np.full((STEPS + 1, 3, 2), np.nan))},
    "a speed that was never learned": {"speed_m_s": 7.0},
    "covariances of another shape": {"predictions": replace(people(CROWD), covariances_m2=np.zeros((3, 2)))},
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_asked_has_no_guess(name: str) -> None:
    fine = Problem(car=CAR, start=START, path=path(), predictions=people(CROWD), speed_m_s=2.0)
    assert guesses(some_weights(6, 0.05), [way()], replace(fine, **BAD[name]), SETTINGS) is None
    assert guesses(None, [way()], fine, SETTINGS) is None
    assert guesses(some_weights(6, 0.05)._replace(out_bias=np.full(2 * STEPS, np.nan, np.float32)), [way()], fine, SETTINGS) is None


def test_the_switch_turns_it_on_in_new_classes_only() -> None:
    around = Around(car=START, path=path(), predictions=people([(15.0, 0.0)]), speed_m_s=2.0)
    decided = {on: plan(TopologyState(), around, CAR, TopologySettings(learned_guess=on)) for on in (True, False)}
    first = {on: trajectories(decided[on][1]) for on in decided}
    assert any(first[True][i].states.tobytes() != first[False][i].states.tobytes() for i in first[True] if i >= 0)
    after = {on: plan(decided[True][0], around, CAR, TopologySettings(learned_guess=on), 0.0)[1] for on in (True, False)}
    known = decided[True][0].found
    one, other = (trajectories(after[on]) for on in (True, False))
    assert any(identity >= 0 for identity in known)
    assert all(one[i].states.tobytes() == other[i].states.tobytes() for i in one if i in known)


def trajectories(decision) -> dict[int, Trajectory]:
    return {each.identity: each.trajectory for each in decision.candidates}


def test_after_the_warm_up_no_guess_waits_for_the_compiler() -> None:
    warm_up()
    kernels = (seen._alone, seen._people, network.driven)
    crossing, tracks = read_crossing(find_crossing("training_wide_10"))
    samples_of(world_of(changed(crossing, time_limit_s=0.5), crossing.first_seed, tracks))
    around = Around(car=START, path=path(), predictions=people([(15.0, 0.0)]), speed_m_s=2.0)
    plan(TopologyState(), around, CAR, TopologySettings())
    assert all(len(kernel.signatures) == 1 for kernel in kernels)  # type: ignore[attr-defined]


def test_what_is_collected_begins_at_the_car_and_can_be_driven() -> None:
    crossing, tracks = read_crossing(find_crossing("training_bend_6"))
    world = world_of(changed(crossing, time_limit_s=1.2), crossing.first_seed, tracks)
    found = samples_of(world)
    assert len(found) >= 4
    for sample in found:
        assert sample.states[0, :3] == pytest.approx(0.0, abs=1e-6)
        assert np.diff(sample.states[:, 3]) == pytest.approx(sample.inputs[:, 0] * STEP_S, abs=1e-5)
        assert np.diff(sample.states[:, 4]) == pytest.approx(sample.inputs[:, 1] * STEP_S, abs=1e-5)
        walked = np.hypot(*np.diff(sample.states[:, :2], axis=0).T)
        assert walked == pytest.approx((sample.states[1:, 3] + sample.states[:-1, 3]) / 2 * STEP_S, abs=0.01)
        nobody = sample.there == 0.0
        assert (sample.people[nobody] == 0.0).all() and (sample.people[~nobody] != 0.0).any()
