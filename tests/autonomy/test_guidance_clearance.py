"""Clearance at equal time: exact, beside a plain one that looks at very many instants; and NaN is never clear."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from autonomy.planning.guidance.clearance import Crowd, clear, free
from autonomy.planning.horizon import STEPS, Floats

DENSE = 40  # instants within a step; nobody moves more than 0.1 m between two


def crowd_of(tracks: Floats, clearances: Floats) -> Crowd:
    paces = np.hypot(*np.diff(tracks, axis=1).T).max(axis=0, initial=0.0)
    return Crowd(tracks, np.zeros(tracks.shape[:2]), clearances, clearances, paces)


def walks(chance: np.random.Generator, people: int) -> Floats:
    """People who change their minds at every step."""
    places = chance.uniform(-8.0, 8.0, (people, 1, 2))
    steps = chance.uniform(-0.5, 0.5, (people, STEPS, 2)) + chance.uniform(-0.3, 0.3, (people, 1, 2))
    return np.concatenate((places, places + np.cumsum(steps, axis=1)), axis=1)


def least_distance(first: Floats, last: Floats, tracks: Floats) -> Floats:
    """Over both moving, at the same instants, as they are looked up one by one."""
    stages = np.linspace(first[2], last[2], int((last[2] - first[2]) * DENSE) + 2)
    shares = (stages - first[2]) / (last[2] - first[2])
    car = first[:2] + shares[:, None] * (last[:2] - first[:2])
    at = [np.stack([np.interp(stages, np.arange(STEPS + 1), track[:, k]) for k in (0, 1)], axis=1) for track in tracks]
    return np.array([np.hypot(*(car - places).T).min() for places in at])


@given(st.integers(0, 2**32), st.integers(1, 4))
@settings(max_examples=300, deadline=None)
def test_it_is_clear_exactly_when_no_instant_comes_too_near(seed: int, people: int) -> None:
    chance = np.random.default_rng(seed)
    tracks = walks(chance, people)
    half_stages = np.sort(chance.choice(2 * STEPS + 1, 2, replace=False)) / 2
    first, last = (np.array([*chance.uniform(-8.0, 8.0, 2), stage]) for stage in half_stages)
    distances = chance.uniform(0.2, 3.0, people)
    spare = (least_distance(first, last, tracks) - distances).min()
    if abs(spare) > 0.02:  # the plain rule is no nearer to the truth than that
        crowd = crowd_of(tracks, distances)
        assert clear(first, last, crowd, distances) == (spare > 0)
        assert clear(last, first, crowd, distances) == (spare > 0)


def test_two_who_cross_at_different_times_are_clear_and_at_the_same_time_are_not() -> None:
    walk = np.stack((np.full(STEPS + 1, 5.0), np.linspace(-3.5, 3.5, STEPS + 1)), axis=1)[None]
    crowd = crowd_of(walk, np.array([1.0]))
    start = np.zeros(3)
    assert not clear(start, np.array([10.0, 0.0, float(STEPS)]), crowd, crowd.clearances)  # both in the middle at half time
    assert clear(start, np.array([10.0, 0.0, STEPS / 2]), crowd, crowd.clearances)  # twice as fast: gone before


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_what_is_not_a_number_is_never_clear(wrong: int) -> None:
    crowd = crowd_of(np.full((1, STEPS + 1, 2), 100.0), np.array([1.0]))
    node, end = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 5.0])
    assert clear(node, end, crowd, crowd.clearances) and free(node, crowd)
    node[wrong] = np.nan
    assert not clear(node, end, crowd, crowd.clearances)
    if wrong < 2:
        assert not free(node, crowd)


def test_nodes_of_the_same_time_do_not_see_each_other() -> None:
    crowd = crowd_of(np.empty((0, STEPS + 1, 2)), np.empty(0))
    assert not clear(np.array([0.0, 0.0, 3.0]), np.array([0.0, 0.0, 3.0]), crowd, crowd.clearances)
