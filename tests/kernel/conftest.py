"""What the tests of this folder share: they run in the guest's kernel only (`make test-kernel`), and print their figures."""

import json
import os
import shlex
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
REASON = "needs the guest kernel: make test-kernel"
STARTER = "/run/starter"  # guest.sh
LOOK_S = 0.03  # each look is emulated too, and beside a test's own threads
PATIENCE_S = 150.0  # emulated, everything takes twelve times as long, on a slow machine twice that: a helper starts for a minute
_figures: list[str] = []


def _in_guest() -> bool:
    command_line = Path("/proc/cmdline")
    return command_line.is_file() and "tower.kernel-guest" in command_line.read_text()


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if not _in_guest():
        for item in items:
            if item.path.parent == HERE:
                item.add_marker(pytest.mark.skip(reason=REASON))


def pytest_terminal_summary(terminalreporter: Any) -> None:
    if _figures:
        terminalreporter.section("measured in the guest, emulated")
        for line in _figures:
            terminalreporter.line(line)


@pytest.fixture(scope="session")
def figure() -> Callable[[str], None]:
    """Say a measured figure at the end."""
    return _figures.append


@pytest.fixture(scope="session")
def system() -> Callable[..., str]:
    """Run a command of the system with these lines as its input; what it printed. A failing one fails the test and says why."""

    def run(command: str, *lines: str) -> str:
        given = "".join(f"{line}\n" for line in lines)
        done = subprocess.run(shlex.split(command), input=given, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}: {done.stderr.strip()}"
        return done.stdout

    return run


@pytest.fixture(scope="session")
def until() -> Callable[..., Any]:
    """until(done, what): what `done` says as soon as it is true; fails with `what` after a long time."""

    def wait(done: Callable[[], Any], what: str, seconds: float = PATIENCE_S) -> Any:
        pause = threading.Event()
        for _ in range(round(seconds / LOOK_S)):
            found = done()
            if found:
                return found
            pause.wait(LOOK_S)
        raise AssertionError(f"not within {seconds:g} s: {what}")

    return wait


@pytest.fixture(scope="session")
def start(until) -> Callable[..., "Started"]:
    """start("vehicle-gateway", "ecu", "--config", path): one of ours, or a file of this folder; whoever starts it ends it."""

    def connected() -> socket.socket | None:
        connection = socket.socket(socket.AF_UNIX)
        if connection.connect_ex(STARTER) == 0:
            return connection
        connection.close()
        return None

    def begin(name: str, *arguments: object, namespace: str = "", piped: bool = False) -> Started:
        place = HERE / name if name.endswith(".py") else Path(sys.executable).parent / name
        return Started(until(connected, "the starter has loaded"), [str(place), *map(str, arguments)], namespace, piped)

    return begin


class Started:
    """A program begun by the guest's starter (starter.py), in the manner of subprocess.Popen."""

    def __init__(self, connection: socket.socket, command: list[str], namespace: str, piped: bool) -> None:
        self._connection = connection
        (its_input, our_end), (output, its_output) = (os.pipe(), os.pipe()) if piped else ((0, -1), (-1, 1))
        request = json.dumps({"command": command, "namespace": namespace}).encode()
        socket.send_fds(connection, [request], [its_input, its_output, 2])
        if piped:
            os.close(its_input)
            os.close(its_output)
            self.stdin, self.stdout = os.fdopen(our_end, "w", buffering=1), os.fdopen(output)
        told = connection.recv(20)
        assert told, f"{command[0]} did not start"
        self.pid = int(told)

    def kill(self) -> None:
        with suppress(ProcessLookupError):
            os.kill(self.pid, signal.SIGKILL)

    def wait(self) -> None:
        self._connection.recv(1)  # ends with the process
        self._connection.close()


@pytest.fixture(scope="session")
def program(start) -> Callable[..., Any]:
    """`with program("vehicle-gateway", "ecu", "--config", path) as process:` - one of ours, killed at the end."""

    @contextmanager
    def running(*command: object) -> Iterator[Started]:
        process = start(*command)
        try:
            yield process
        finally:
            process.kill()
            process.wait()

    return running
