"""What the service manager hears, on a real socket of the kind it opens; and what happens where there is none."""

import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from wire.notify import NOBODY, notifier


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[str, socket.socket]]:
    address = str(tmp_path / "notify") if request.param == "path" else f"@{tmp_path}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listening:
        listening.bind("\0" + address[1:] if request.param == "abstract" else address)
        listening.settimeout(5.0)
        yield address, listening


def test_lines_arrive_together_and_leaving_says_so(manager):
    address, listening = manager
    with notifier({"NOTIFY_SOCKET": address}) as told:
        told.tell("READY=1", "STATUS=safe stop: no\ncamera")
        assert listening.recv(4096) == b"READY=1\nSTATUS=safe stop: no camera"
    assert listening.recv(4096) == b"STOPPING=1"


def test_a_manager_that_has_gone_is_counted_and_never_waited_for(tmp_path):
    with notifier({"NOTIFY_SOCKET": str(tmp_path / "gone")}) as told:
        told.tell("WATCHDOG=1")
        assert told.failed == 1


def test_a_manager_that_does_not_read_is_never_waited_for(manager):
    address, _ = manager
    with notifier({"NOTIFY_SOCKET": address}) as told:
        for _ in range(100_000):
            told.tell("WATCHDOG=1")
            if told.failed:
                break
        assert told.failed


def test_where_there_is_none_nothing_happens():
    with notifier({}) as told:
        told.tell("READY=1")
        assert told.failed == NOBODY.failed == 0
