"""Whole drives: what fails on a machine that cannot keep up says nothing (tests.overload)."""

from tests.overload import pytest_runtest_makereport

__all__ = ["pytest_runtest_makereport"]
