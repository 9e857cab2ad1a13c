"""A short slice of `make fuzz`, always equal but for the keys of what is signed; and that the fuzzer's rules can be broken."""

import random
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from benchmarks.proof.fuzz import LEAST, WANTED, Tally, chosen, missing, order_of, page_of
from benchmarks.proof.noise import changed
from benchmarks.proof.rules import Broken, Target, must_be_finite
from benchmarks.proof.targets import targets

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


def test_a_decoder_that_lacks_inputs_comes_before_the_others():
    known = [Target("much", print, (), 2), Target("little", print, (), 1), Target("none", print, (), 3)]
    counts = Counter(much=WANTED, little=LEAST - 3)
    assert order_of(counts, known) == [1, 2]
    assert missing(counts, [target.name for target in known]) == LEAST + 3
    counts.update(little=3, none=LEAST)
    assert order_of(counts, known) == [0, 0, 1, 2, 2, 2]
    assert missing(counts, [target.name for target in known]) == 0
    assert missing(Counter(much=WANTED - 7), ["much"]) == 7


def test_a_clone_without_counts_goes_on_from_the_committed_table(tmp_path: Path):
    counts = Counter({"CAN ECU command": 1_234_567, "stamp": 7})
    (tmp_path / "fuzz.md").write_text(page_of(counts, True, "abc1234"))
    tally = Tally(tmp_path / "kept", tmp_path / "fuzz.md")
    assert tally.counts == counts
    tally.add("stamp")
    tally.save()
    assert Tally(tmp_path / "kept", tmp_path / "fuzz.md").counts == counts + Counter(stamp=1)


def test_decoders_are_chosen_by_a_part_of_their_name():
    known = [Target("CAN plant", print, (), 2), Target("message Gnss", print, (), 1)]
    assert chosen(known, "") == tuple(known) and chosen(known, "CAN") == (known[0],)
    with pytest.raises(SystemExit, match="lidar: no such decoder; there are: CAN plant, message Gnss"):
        chosen(known, "lidar")
