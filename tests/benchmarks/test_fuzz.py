"""A short, always equal slice of `make fuzz`; and that the fuzzer's rules can be broken."""

import random
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from benchmarks.proof.noise import changed
from benchmarks.proof.targets import Broken, must_be_finite, targets

FOLDER = TemporaryDirectory(prefix="fuzz-")
TARGETS = {target.name: target for target in targets(Path(FOLDER.name))}


@pytest.mark.parametrize("name", TARGETS)
def test_what_is_almost_right_gets_a_documented_error_or_is_right(name):
    target, source = TARGETS[name], random.Random(name)
    for seed in target.seeds:
        target.try_one(seed)
    for _ in range(12 * target.share):
        target.try_one(changed(source, source.choice(target.seeds)))


def test_a_number_that_is_none_is_found_wherever_it_hides():
    for value in (float("nan"), [1.0, float("inf")], {"a": (0.0, float("-inf"))}):
        with pytest.raises(Broken):
            must_be_finite(value)
    must_be_finite({"a": [1.0, 2, "text"]})
