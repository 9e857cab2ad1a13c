"""Samples as arrays: those to learn from and those to judge by, seen in a mirror, in batches. Pure, for a seed."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from autonomy.planning.horizon import STEPS
from autonomy.planning.learned.features import AHEAD_M, AT, CAR, LINE, PERSON, WAY, Singles
from autonomy.training.collect import Sample

JUDGED = 9  # every ninth drive is judged by, never learned from; with four streets in turn those are of every street


class Batch(NamedTuple):
    """As `collect.Sample`, with a first axis over b of them."""

    alone: Singles
    people: Singles
    there: Singles
    states: Singles
    inputs: Singles


def parted(drives: Sequence[Sequence[Sample]]) -> tuple[Batch, Batch]:
    """To learn from, with their mirror images, and to judge by: of different drives."""
    learned = batch_of([sample for number, drive in enumerate(drives) if number % JUDGED for sample in drive])
    judged = batch_of([sample for number, drive in enumerate(drives) if not number % JUDGED for sample in drive])
    both = Batch(*(np.concatenate(pair) for pair in zip(learned, mirrored(learned), strict=True)))
    return both, judged


def batch_of(samples: Sequence[Sample]) -> Batch:
    return Batch(*(np.stack(column) for column in zip(*samples, strict=True)))


def mirrored(batch: Batch) -> Batch:
    """Left for right: whatever holds for a street holds for its mirror image."""
    count = len(AHEAD_M)
    alone, people = batch.alone.copy(), batch.people.copy()
    alone[:, STEPS:WAY] *= -1.0
    alone[:, WAY + count : WAY + 2 * count] *= -1.0
    left, right = slice(WAY + 2 * count, WAY + 3 * count), slice(WAY + 3 * count, WAY + LINE)
    alone[:, left], alone[:, right] = batch.alone[:, right], batch.alone[:, left]
    alone[:, WAY + LINE + 1] *= -1.0
    people[..., len(AT) : 2 * len(AT)] *= -1.0
    assert (alone.shape[1], people.shape[2]) == (WAY + LINE + CAR, PERSON)
    of_states, of_inputs = np.array((1, -1, -1, 1, -1), np.float32), np.array((1, -1), np.float32)
    return Batch(alone, people, batch.there, batch.states * of_states, batch.inputs * of_inputs)


def batches(of: Batch, size: int, random: np.random.Generator) -> Iterator[Batch]:
    """All of it once, in any order; what does not fill a batch is left for another time."""
    order = random.permutation(len(of.alone))
    for begin in range(0, len(order) - size + 1, size):
        rows = order[begin : begin + size]
        yield Batch(*(column[rows] for column in of))
