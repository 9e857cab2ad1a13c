"""What the tests of this folder share: they run in the guest's kernel only (`make test-kernel`), and print their figures."""

import shlex
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

HERE = Path(__file__).parent
REASON = "needs the guest kernel: make test-kernel"
PATIENCE_S = 60.0  # emulated, everything takes some twelve times as long; counted in looks: a busy machine stretches it
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
def system() -> Callable[[str], str]:
    """Run a command of the system; what it printed. A failing one fails the test and says why."""

    def run(command: str) -> str:
        done = subprocess.run(shlex.split(command), capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"{command}: {done.stderr.strip()}"
        return done.stdout

    return run


@pytest.fixture(scope="session")
def until() -> Callable[..., Any]:
    """until(done, what): what `done` says as soon as it is true; fails with `what` after a long time."""

    def wait(done: Callable[[], Any], what: str, seconds: float = PATIENCE_S) -> Any:
        pause = threading.Event()
        for _ in range(round(seconds / 0.01)):
            found = done()
            if found:
                return found
            pause.wait(0.01)
        raise AssertionError(f"not within {seconds:g} s: {what}")

    return wait


@pytest.fixture(scope="session")
def program() -> Callable[..., Any]:
    """`with program("vehicle-gateway", "ecu", "--config", path) as process:` - one of ours, killed at the end."""

    @contextmanager
    def running(name: str, *arguments: str, prefix: tuple[str, ...] = ()) -> Iterator[subprocess.Popen[bytes]]:
        command = [*prefix, str(Path(sys.executable).parent / name), *map(str, arguments)]
        process = subprocess.Popen(command)
        try:
            yield process
        finally:
            process.kill()
            process.wait()

    return running
