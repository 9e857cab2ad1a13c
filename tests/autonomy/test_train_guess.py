"""Training: the network that learns is the one that is asked, and it learns. Skips where the extra `train` is not installed."""

import numpy as np
import pytest

pytest.importorskip("jax", reason="training wants JAX: pip install --constraint constraints.txt '.[train]'")

from autonomy.planning.horizon import STEPS  # noqa: E402
from autonomy.planning.learned import network  # noqa: E402
from autonomy.planning.learned.features import CAR, LINE, PEOPLE, PERSON, WAY, Features  # noqa: E402
from autonomy.training import model  # noqa: E402
from autonomy.training.batches import Batch, parted  # noqa: E402
from autonomy.training.collect import Sample  # noqa: E402
from autonomy.training.train import SIZE, at_first, judged, trained  # noqa: E402


def made(count: int) -> Batch:
    """The car does what one number of its way says, and that alone."""
    random = np.random.default_rng(1)
    alone = random.normal(0.0, 0.3, (count, WAY + LINE + CAR)).astype(np.float32)
    asked = np.repeat(np.stack((alone[:, 0], 0.1 * alone[:, STEPS]), axis=1)[:, None], STEPS, axis=1).astype(np.float32)
    start = np.tile(np.array((0.0, 0.0, 0.0, 2.0, 0.0), np.float32), (count, 1))
    states, used = (np.asarray(each) for each in model.driven(start, asked))
    people = random.normal(0.0, 0.3, (count, PEOPLE, PERSON)).astype(np.float32)
    there = (np.arange(PEOPLE) < random.integers(0, PEOPLE, count)[:, None]).astype(np.float32)
    return Batch(alone, people * there[..., None], there, states, used)


def test_the_network_that_learns_is_the_one_that_is_asked() -> None:
    weights, batch = at_first(np.random.default_rng(2)), made(6)
    learned = np.asarray(model.inputs(weights, batch))
    for row in range(6):
        people = batch.people[row : row + 1, batch.there[row] > 0.0]
        assert network.inputs(weights, Features(batch.alone[row : row + 1], people))[0] == pytest.approx(learned[row], abs=1e-5)


def test_its_decoder_drives_as_the_local_planner_does() -> None:
    batch = made(5)
    asked = np.random.default_rng(3).normal(0.0, 2.0, (5, STEPS, 2))
    theirs, used = (np.asarray(each) for each in model.driven(batch.states[:, 0], asked.astype(np.float32)))
    ours = np.empty((5, STEPS + 1, 6))
    network.driven(np.array((0.0, 0.0, 0.0, 2.0, 0.0, 0.0)), asked, model.WHEELBASE_M, model.ANGLE_MAX_RAD, 100.0, ours)
    assert ours[..., :5] == pytest.approx(theirs, abs=1e-3)
    assert asked == pytest.approx(used, abs=1e-3)


def test_what_can_be_learned_is_learned_and_comes_out_the_same_again() -> None:
    drives = [[Sample(*each) for each in zip(*made(SIZE // 4), strict=True)] for _ in range(4)]
    learned, kept = parted(drives)
    before = float(judged(at_first(np.random.default_rng(0)), kept)[0])
    weights = trained(learned, 30, lambda number, weights: None)
    assert float(judged(weights, kept)[0]) < 0.5 * before
    again = trained(learned, 30, lambda number, weights: None)
    assert all(one.tobytes() == other.tobytes() for one, other in zip(weights, again, strict=True))
