"""Whole drives: on a slow machine in slow motion; what fails on one that cannot keep up even so says nothing (tests.overload)."""

from benchmarks.rig import real_time_factor
from tests.overload import pytest_runtest_makereport


def pytest_report_header() -> str:
    return f"drives: {real_time_factor():.0%} of real time"


__all__ = ["pytest_runtest_makereport"]
