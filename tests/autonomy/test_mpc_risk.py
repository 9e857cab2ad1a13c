"""The shares add up to the risk, the quantiles are the textbook's, and who moves as predicted is met no more often than asked."""

from statistics import NormalDist

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from autonomy.planning.horizon import STEPS
from autonomy.planning.mpc.risk import allocate, quantile, quantiles, widest

GROWING = np.arange(STEPS + 1)[:, None, None, None] * 0.0036 * np.eye(2)


def covariances(count: int) -> np.ndarray:
    return np.tile(GROWING, (1, count, 1, 1))


@given(st.floats(1e-12, 0.5))
def test_a_quantile_is_that_of_the_normal_distribution(share: float) -> None:
    assert quantile(share) == pytest.approx(-NormalDist().inv_cdf(share), abs=1e-7)


def test_a_share_too_small_for_numbers_still_has_a_finite_quantile() -> None:
    assert 37 < quantile(1e-300) < 39


@given(st.integers(0, 12), st.floats(1e-6, 0.49), st.integers(0, 10))
def test_shares_are_no_more_than_the_risk_and_all_of_it_where_anything_is_uncertain(count: int, risk: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    roots = random.normal(0.0, random.uniform(0.0, 2.0), (STEPS + 1, count, 2, 2))
    shares = allocate(roots @ roots.swapaxes(-1, -2), risk)
    assert (shares >= 0.0).all() and shares[0].sum() == 0.0
    assert shares.sum() == pytest.approx(risk if count else 0.0)


def test_what_is_known_exactly_has_no_share_and_no_quantile() -> None:
    both = covariances(2)
    both[:, 0] = 0.0
    shares = allocate(both, 0.05)
    assert shares[:, 0].sum() == 0.0 and not quantiles(shares)[:, 0].any()
    assert shares[:, 1].sum() == pytest.approx(0.05)


def test_shares_follow_the_widest_axis() -> None:
    assert widest(np.array([[4.0, 0.0], [0.0, 1.0]])) == 2.0
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    assert widest(turn @ np.diag([9.0, 1.0]) @ turn.T) == pytest.approx(3.0)


def test_distances_are_shorter_than_under_equal_shares() -> None:
    deviations = np.sqrt(covariances(4)[1:, :, 0, 0])
    ours = (quantiles(allocate(covariances(4), 0.05))[1:] * deviations).sum()
    assert ours < quantile(0.05 / deviations.size) * deviations.sum()


@pytest.mark.parametrize("walk", [True, False])
def test_people_at_their_distance_are_met_no_more_often_than_asked(walk: bool) -> None:
    """Each is exactly at its distance at every stage. Errors of one person: a random walk, or independent (the worst)."""
    count, rollouts, risk = 6, 20_000, 0.05
    random = np.random.default_rng(7)
    deviations = np.sqrt(covariances(count)[1:, :, 0, 0])
    distances = quantiles(allocate(covariances(count), risk))[1:] * deviations
    steps = random.normal(size=(rollouts, STEPS, count), scale=0.06)
    errors = steps.cumsum(axis=1) if walk else steps * np.sqrt(np.arange(1, STEPS + 1))[:, None]
    met = (errors > distances).any(axis=(1, 2)).mean()
    assert met <= risk + 3 * np.sqrt(risk / rollouts)
    assert met > (0.2 if walk else 0.9) * risk  # it is no bound for the sake of a bound
