"""Whole drives: on a slow machine in slow motion; what fails on one that cannot keep up even so says nothing."""

from tests.drive_speed import speed
from tests.overload import pytest_runtest_makereport, pytest_runtest_setup

__all__ = ["pytest_runtest_makereport", "pytest_runtest_setup", "speed"]
