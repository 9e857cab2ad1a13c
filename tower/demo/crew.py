"""The processes of a session: start, watch, start again, stop in order. A shell over subprocess: it decides nothing."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from wire.configuration import ConfigurationError
from wire.process import USER_ERROR

RESTARTS_MAX = 3  # of one process; something that dies more often is broken, not unlucky
STOP_PATIENCE_S = 5.0  # for SIGTERM, then SIGKILL
_LOOK_S = 0.05


@dataclass(frozen=True, slots=True)
class Member:
    name: str
    program: str  # console script
    command: str
    restarts: bool = True
    core: int | None = None  # of a machine with two: the one it keeps to


# In the order in which they are stopped: the recorder sees the others out, its hub (the gateway) goes last.
# Where two cores are all there is, what carries commands to the car keeps to one and the operator's programs to the other: who
# wanders finds its memory in the other core's cache, and pictures wash it out (benchmarks/results/reaches.md). Neither is full.
CAR = (
    Member("autonomy", "autonomy", "run"),
    Member("video", "vehicle-gateway", "video"),
    Member("recorder", "recordings", "record"),
    Member("simulate", "vehicle-gateway", "simulate", restarts=False),
    Member("ecu", "vehicle-gateway", "ecu", core=0),
    Member("watchdog", "vehicle-gateway", "watchdog", core=0),
    Member("gateway", "vehicle-gateway", "run", core=0),
)
TOWER = (Member("window", "tower", "window", core=1), Member("cockpit", "tower", "cockpit", core=1))


@dataclass(frozen=True, slots=True)
class Ended:
    """A process that ended without being asked."""

    name: str
    how: str
    started_again: bool


class Crew:
    def __init__(self, members: tuple[Member, ...], config: Path, folder: Path) -> None:
        self._members = {member.name: member for member in members}
        self._config, self._folder = config, folder
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._starts: dict[str, int] = {}
        self._paused: set[str] = set()

    def start(self, name: str) -> None:
        member = self._members[name]
        program = Path(sys.executable).parent / member.program
        if not program.is_file():
            raise ConfigurationError(f"{program}: not installed; run: make setup")
        log = self._folder / "logs" / f"{name}.log"
        log.parent.mkdir(exist_ok=True)
        with log.open("ab") as stream:
            self._processes[name] = subprocess.Popen(
                [
                    sys.executable,
                    "-m",
                    "tower.demo.child",
                    str(os.getpid()),
                    core_of(member, usable_cores()),
                    str(program),
                    member.command,
                    "--config",
                    str(self._config),
                ],
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=stream,
                start_new_session=True,
            )
        self._starts[name] = self._starts.get(name, 0) + 1
        pids = {each: process.pid for each, process in self._processes.items()}
        (self._folder / "processes.json").write_text(json.dumps(pids, indent=1) + "\n")

    def start_all(self) -> None:
        for name in reversed(self._members):
            self.start(name)

    def look_after(self) -> list[Ended]:
        """Who ended since the last call; those that may are started again. A user's error is never tried again."""
        ended = []
        for name, process in list(self._processes.items()):
            code = process.poll()
            if code is None:
                continue
            del self._processes[name]
            closed = name == "window" and code == 0
            again = self._members[name].restarts and not closed and code != USER_ERROR and self._starts[name] <= RESTARTS_MAX
            if again:
                self.start(name)
            ended.append(Ended(name, _how(code, self._folder / "logs" / f"{name}.log"), again))
        return ended

    def paused(self) -> list[str]:
        """Who was stopped (SIGSTOP) or went on since the last call, in words. Nothing where there is no /proc."""
        now = {name for name, process in self._processes.items() if _state(process.pid) == "T"}
        told = [f"{name} is stopped" for name in sorted(now - self._paused)]
        told += [f"{name} goes on" for name in sorted(self._paused - now) if name in self._processes]
        self._paused = now
        return told

    def stop_all(self) -> None:
        """Ask each in turn to end; what does not is killed. A stopped process cannot hear that, nor let go of who waits for it."""
        for process in self._processes.values():
            process.send_signal(signal.SIGCONT)
        for name in self._members:
            self.stop(name)

    def stop(self, name: str) -> None:
        process = self._processes.pop(name, None)
        if process is None:
            return
        process.terminate()
        try:
            process.wait(STOP_PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def core_of(member: Member, usable: Sequence[int]) -> str:
    """The number of the core that a program keeps to; "" for any of them. Three and more the system shares out better."""
    return str(usable[member.core]) if member.core is not None and len(usable) == 2 else ""


def usable_cores() -> list[int]:
    """The cores that this process may use; none where the system does not tell."""
    return sorted(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else []


def _state(pid: int) -> str:
    """The process's state letter (proc(5)); "" when it cannot be read."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except (OSError, IndexError):
        return ""


def _how(code: int, log: Path) -> str:
    if code < 0:
        return f"killed by {signal.Signals(-code).name}"
    said = log.read_text(errors="replace").strip().splitlines()
    return f"exit {code}" + (f": {said[-1]}" if said and code else "")


def compile_first(stop: threading.Event) -> None:
    """The planners' kernels, where nobody has compiled them yet: beside nine programs that drive it takes minutes, not one.

    It tells itself what it does. What fails here, the automation tries again.
    """
    program = Path(sys.executable).parent / "autonomy"
    if not program.is_file():
        return  # the crew says so
    with subprocess.Popen([program, "compile"], stdin=subprocess.DEVNULL) as compiler:
        while compiler.poll() is None:
            if stop.wait(_LOOK_S):
                compiler.terminate()
                return


@contextmanager
def crew(members: tuple[Member, ...], config: Path, folder: Path) -> Iterator[Crew]:
    """All started; leaving the context stops them in order, whatever happened."""
    started = Crew(members, config, folder)
    try:
        started.start_all()
        yield started
    finally:
        started.stop_all()
        (folder / "processes.json").unlink(missing_ok=True)  # these ids may soon belong to somebody else


def utc_folder(sessions: Path) -> Path:
    """A new folder sessions/<utc time>. Raises ConfigurationError when it cannot be made."""
    stamp = time.strftime("%Y-%m-%dT%H-%M-%SZ", time.gmtime())
    for attempt in range(100):
        folder = sessions / (stamp if attempt == 0 else f"{stamp}-{attempt + 1}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise ConfigurationError(f"{folder}: cannot be written: {error.strerror}; choose another with --sessions") from None
        return folder.resolve()
    raise ConfigurationError(f"{sessions}: a hundred sessions in one second; choose another with --sessions")
