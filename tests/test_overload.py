"""Which failures of whole drives are laid to the machine: those whose own cameras gave way as far as they can, and no others."""

import pytest

from tests.overload import overloaded

TEST = """
def test_a_drive(tmp_path):
    log = tmp_path / "drive" / "logs" / "video.log"
    log.parent.mkdir(parents=True)
    log.write_text("cameras: level {level} of 3 of giving way to the rest of the car")
    assert {holds}
"""
pytest_plugins = ["pytester"]


@pytest.mark.parametrize(
    ("level", "holds", "outcome"),
    [(3, False, {"skipped": 1}), (2, False, {"failed": 1}), (3, True, {"passed": 1})],
)
def test_only_a_drive_that_failed_and_whose_cameras_had_nothing_left_to_give_is_skipped(pytester, level, holds, outcome):
    pytester.makepyfile(TEST.format(level=level, holds=holds))
    pytester.runpytest("-p", "tests.overload", "-p", "no:xdist").assert_outcomes(**outcome)


def test_an_overload_of_another_drive_excuses_nothing(pytester):
    other = TEST.format(level=3, holds=True).replace("test_a_drive", "test_before")
    pytester.makepyfile(other + "\ndef test_after():\n    assert False\n")
    pytester.runpytest("-p", "tests.overload", "-p", "no:xdist").assert_outcomes(passed=1, failed=1)


def test_a_drive_without_cameras_log_kept_up(tmp_path):
    assert not overloaded(tmp_path)
