"""A whole drive that fails on a machine that cannot keep up says nothing of the code: it is skipped, with the line that says so.

The evidence is the drive's own, and only of a drive that the failing test itself began: its cameras have given way to the rest of
the car as far as they can (vehicle_gateway.video.load). One that holds all the same has passed. The folders of whole drives take
the hook into their conftest.py.
"""

import re
from collections.abc import Generator
from pathlib import Path

import pytest

GAVE_WAY = re.compile(r"cameras: level (\d+) of (\d+) of giving way")


def overloaded(session: Path) -> bool:
    """Whether the cameras of a drive gave way as far as they can. session: its folder."""
    log = session / "logs" / "video.log"
    said = log.read_text(errors="replace") if log.exists() else ""
    return any(level == lowest for level, lowest in GAVE_WAY.findall(said))


def sessions_of(item: pytest.Item, since_s: float) -> list[Path]:
    """The drives that a test looks at: begun in this phase of it, or finished by its fixture."""
    finished = getattr(item, "funcargs", {}).get("finished")
    base = item.config._tmp_path_factory.getbasetemp()
    begun = [log.parent.parent for log in base.glob("*/*/logs/video.log") if log.stat().st_mtime >= since_s]
    return [finished[0]] if finished else begun


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    slow = next((each for each in sessions_of(item, call.start) if overloaded(each)), None) if report.failed else None
    if slow is not None:
        why = f"the machine could not keep up with the whole drive {slow.name}: its cameras gave way as far as they can"
        report.outcome, report.longrepr = "skipped", (str(item.path), 0, f"Skipped: {why}; run it again on a quiet one")
    return report
