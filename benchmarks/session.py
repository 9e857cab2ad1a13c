"""A session's real processes without a whole demo: a configuration of its own and the programs that are asked for."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tower.demo.session import choose, write_session
from wire import certificates
from wire.configuration import shipped

PROGRAMS = Path(sys.executable).parent
END_S = 5.0  # patience for a process that was asked to end


def session(folder: Path, fifo_priority: int, **cockpit: Any) -> Path:
    """A session.toml in `folder` with certificates of its own."""
    tables = choose(shipped("simulated.toml"), "short", "")
    certificates.ensure(folder / "certificates")
    tables["wire"]["link"]["certificates"] = str(folder / "certificates")
    tables["wire"]["pace"] = {"fifo_priority": fifo_priority}
    tables["tower"]["cockpit"] |= cockpit
    return write_session(tables, folder)


@contextmanager
def running(folder: Path, *commands: tuple[str, ...]) -> Iterator[list[subprocess.Popen[bytes]]]:
    """The commands as processes, each with a log in `folder`; leaving the context ends them, last first."""
    processes = []
    try:
        for number, command in enumerate(commands):
            with (folder / f"process-{number}.log").open("wb") as log:
                processes.append(subprocess.Popen(command, stdout=log, stderr=log, stdin=subprocess.DEVNULL))
        yield processes
    finally:
        for process in reversed(processes):
            _end(process)


def _end(process: subprocess.Popen[bytes]) -> None:
    process.terminate()
    try:
        process.wait(END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def program(name: str, *arguments: str) -> tuple[str, ...]:
    """One of our programs as it is installed."""
    return (str(PROGRAMS / name), *arguments)
