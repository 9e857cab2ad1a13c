"""A whole drive that fails on a machine that cannot keep up says nothing of the code: it is skipped, with the line that says so.

The evidence is the drive's own, and only of a drive that the failing test itself began: its cameras have given way to the rest of
the car as far as they can (vehicle_gateway.video.load). One that holds all the same has passed. The folders of whole drives take
the hook into their conftest.py.
"""

import re
from collections.abc import Generator
from pathlib import Path

import pytest

BEGUN_BEFORE = pytest.StashKey[frozenset[Path]]()
GAVE_WAY = re.compile(r"cameras: level (\d+) of (\d+) of giving way")


def overloaded(session: Path) -> bool:
    """Whether the cameras of a drive gave way as far as they can. session: its folder."""
    log = session / "logs" / "video.log"
    said = log.read_text(errors="replace") if log.exists() else ""
    return any(level == lowest for level, lowest in GAVE_WAY.findall(said))


def sessions(item: pytest.Item) -> frozenset[Path]:
    """All drives that were begun in this run of the tests."""
    base = item.config._tmp_path_factory.getbasetemp()
    return frozenset(log.parent.parent for log in base.glob("*/*/logs/video.log"))


def sessions_of(item: pytest.Item) -> list[Path]:
    """The drives that a test looks at: finished by its fixture, or begun since it was set up."""
    finished = getattr(item, "funcargs", {}).get("finished")
    return [finished[0]] if finished else sorted(sessions(item) - item.stash[BEGUN_BEFORE])


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    item.stash[BEGUN_BEFORE] = sessions(item)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    slow = next((each for each in sessions_of(item) if overloaded(each)), None) if report.failed else None
    if slow is not None:
        why = f"the machine could not keep up with the whole drive {slow.name}: its cameras gave way as far as they can"
        report.outcome, report.longrepr = "skipped", (str(item.path), 0, f"Skipped: {why}; run it again on a quiet one")
    return report
