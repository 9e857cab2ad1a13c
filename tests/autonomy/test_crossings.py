"""Crossing files, the people in them, and recorded ones: the same seed, the same people; they keep off each other and the car."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.planning.crossings.people import STEP_S, Outline, People, at_start, gaps_m, step
from autonomy.planning.crossings.replayed import read_tracks
from autonomy.planning.crossings.scenario import find_crossing, read_crossing, world_of
from wire.configuration import ConfigurationError, shipped

NAMES = sorted(path.stem for path in shipped("crossings").glob("*.toml"))
FAR = Outline(-500.0, 0.0, 0.0, 3.6, 0.9, 0.9)


def walked(world, car=FAR, seconds=20.0):
    """(steps, n, 2) places."""
    people, places = at_start(world), []
    for _ in range(round(seconds / STEP_S)):
        people = step(people, world, car)
        places.append(people.places_m)
    return np.array(places)


def crossing(name="crossers_12", seed=7):
    return world_of(read_crossing(find_crossing(name))[0], seed)


@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_crossing_can_be_walked(name: str) -> None:
    world = crossing(name)
    places = walked(world)
    assert np.isfinite(places).all()
    assert world.road.length_m >= world.crossing.goal_m > 20.0


def test_the_set_has_what_the_study_asks_for() -> None:
    read = [read_crossing(find_crossing(name))[0] for name in NAMES]
    assert {0, 2, 4, 8, 12} <= {each.crossers.count for each in read}
    assert any(each.occluders for each in read) and any(each.riders for each in read) and any(each.things for each in read)
    assert min(each.half_width_m for each in read) < 2.5


def test_a_seed_gives_the_same_people_and_another_seed_others() -> None:
    assert np.array_equal(walked(crossing(seed=3)), walked(crossing(seed=3)))
    assert not np.allclose(crossing(seed=3).positions_m, crossing(seed=4).positions_m)


def test_they_start_beside_the_road_on_either_side_walk_at_the_papers_speeds_and_reach_the_other_side() -> None:
    sides = []
    for seed in range(20):
        world = crossing(seed=seed)
        begin, end = (
            [world.road.to_road(*place).offset_m for place in places] for places in (world.positions_m, walked(world)[-1])
        )
        assert all(abs(offset) > world.crossing.half_width_m for offset in (*begin, *end))
        assert all(a * b < 0 for a, b in zip(begin, end, strict=True))
        assert (world.speeds_m_s >= 1.14).all() and (world.speeds_m_s <= 1.66).all()
        sides += [offset > 0 for offset in begin]
    assert 0.3 < np.mean(sides) < 0.7


def test_those_who_are_to_meet_the_car_are_on_the_line_when_it_would_be_there() -> None:
    for seed in range(20):
        world = crossing("meeting_8", seed)
        blind = replace(world, reacts=np.zeros(len(world.reacts), bool))
        walks = walked(blind, seconds=25.0)
        offsets = np.array([[world.road.to_road(*place) for place in places] for places in walks])  # station, offset, heading
        for person in range(8):
            at = int(np.argmin(np.abs(offsets[:, person, 1])))
            assert abs(offsets[at, person, 1]) < 0.1
            passing_s = offsets[at, person, 0] / world.crossing.speed_m_s
            assert abs((at + 1) * STEP_S - passing_s) < 1.5 + 0.2
        assert all(abs(world.road.to_road(*place).offset_m) > world.crossing.half_width_m for place in world.positions_m)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10_000))
def test_people_do_not_walk_through_each_other(seed: int) -> None:
    world = crossing("crossers_4", seed)
    if np.min([np.linalg.norm(a - b) for i, a in enumerate(world.positions_m) for b in world.positions_m[:i]]) < 1.0:
        return  # they start in each other's arms
    apart = walked(world, seconds=10.0)
    distance = np.linalg.norm(apart[:, :, None] - apart[:, None], axis=3) + 9.0 * np.eye(4)
    assert distance.min() > 0.25  # shoulders may touch


@pytest.mark.parametrize("heading", [0.0, 0.7, 2.5])
def test_they_walk_round_a_car_that_stands_in_their_way_and_those_who_do_not_react_walk_into_it(heading: float) -> None:
    world = crossing("crossers_8", 5)
    middle = world.road.to_world(20.0, 0.0)
    car = Outline(middle[0], middle[1], heading, 3.6, 0.9, 0.9)
    outside = gaps_m(world.positions_m, world.radii_m, car) > 0.3
    nearest = np.min([gaps_m(places, world.radii_m, car) for places in walked(world, car)], axis=0)
    assert (nearest[outside] > -0.15).all()
    blind = replace(world, reacts=np.zeros(len(world.reacts), bool))
    nearest = np.min([gaps_m(places, blind.radii_m, car) for places in walked(blind, car)], axis=0)
    assert nearest.min() < -0.15


def test_the_gap_to_the_car_is_that_to_its_rectangle() -> None:
    car = Outline(1.0, 2.0, np.pi / 2, 3.0, 1.0, 0.9)  # it looks along y
    places = np.array([[1.0, 7.0], [3.0, 3.0], [1.0, 0.0], [2.9, 6.0], [1.2, 3.0]])
    expected = [2.0, 1.1, 1.0, np.hypot(1.0, 1.0), 0.0]
    assert np.allclose(gaps_m(places, np.zeros(5), car), expected)


def test_nobody_is_a_crowd_too() -> None:
    world = crossing("crossers_0")
    assert step(People(np.zeros((0, 2)), np.zeros((0, 2))), world, FAR).places_m.shape == (0, 2)


def write(path: Path, text: str) -> Path:
    path.write_text(text, encoding="utf-8")
    return path


def test_recorded_people_walk_as_they_walked(tmp_path: Path) -> None:
    tracks = read_tracks(write(tmp_path / "a.csv", "frame,id,x_m,y_m\n10,1,0,0\n20,1,4,2\n15,2,5,5\n20,2,5,6\n30,3,9,9\n"), 2.5)
    numbers, places, velocities = tracks.at(3.0)
    assert numbers == (1, 2)
    assert np.allclose(places, [[3.0, 1.5], [5.0, 5.5]]) and np.allclose(velocities, [[1.0, 0.5], [0.0, 0.5]])
    assert tracks.at(0.0)[0] == (1,) and tracks.at(4.1)[0] == ()


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("", "first line"),
        ("frame,id,x\n1,2,3\n", "first line"),
        ("frame,id,x_m,y_m\n1,2,3,nan\n", "line 2"),
        ("frame,id,x_m,y_m\n1,2,3,4\n1,two,3,4\n", "line 3"),
    ],
)
def test_what_is_no_recording_is_told_with_its_line(tmp_path: Path, text: str, told: str) -> None:
    with pytest.raises(ConfigurationError, match=told):
        read_tracks(write(tmp_path / "a.csv", text), 2.5)


def test_a_crossing_that_is_wrong_is_told(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="crossers_12"):
        find_crossing("nowhere")
    with pytest.raises(ConfigurationError, match="goal_m"):
        read_crossing(write(tmp_path / "a.toml", 'name="a"\npieces_m=[[10.0,0.0]]\nhalf_width_m=3.0\ngoal_m=40.0\n'))
    with pytest.raises(ConfigurationError, match="people.csv"):
        read_crossing(
            write(tmp_path / "b.toml", 'name="a"\npieces_m=[[50.0,0.0]]\nhalf_width_m=3.0\ngoal_m=40.0\ntracks="people.csv"\n')
        )
