"""The speed of the whole drives under test, chosen once."""

import pytest

from benchmarks.drive_speed import choose_speed


@pytest.fixture(scope="session", autouse=True)
def speed() -> float:
    """The drives' real time factor."""
    return choose_speed()
