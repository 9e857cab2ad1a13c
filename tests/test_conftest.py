"""The profile of hypothesis that `make test` runs with."""

import sys
from subprocess import run

from hypothesis import given
from hypothesis import strategies as st

ASKED = """
import sys
import pytest
from hypothesis import settings

class Told:
    def pytest_collection_finish(self):
        print("derandomized" if settings.default.derandomize else "new every time")

pytest.main([*sys.argv[1:], "--collect-only", "-qq", "tests/test_conftest.py"], plugins=[Told()])
"""


def told(*options):
    return run([sys.executable, "-c", ASKED, *options], capture_output=True, text=True, check=True).stdout.splitlines()


def examples():
    seen = []

    @given(st.lists(st.integers()))
    def look(numbers):
        seen.append(numbers)

    look()
    return seen


def test_two_runs_make_up_the_same_examples():
    assert examples() == examples()


def test_only_who_asks_for_new_examples_gets_them():
    assert "derandomized" in told()
    assert "new every time" in told("--hypothesis-profile=new")
