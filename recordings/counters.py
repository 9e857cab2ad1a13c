"""Counters "since start" over the restarts of their process. Pure."""

from collections.abc import Sequence
from itertools import pairwise


def counted(counts: Sequence[int]) -> int:
    """What a counter reached in all: a smaller value than before means that its process was restarted."""
    before_restarts = sum(before for before, now in pairwise(counts) if now < before)
    return before_restarts + (counts[-1] if counts else 0)
