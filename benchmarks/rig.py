"""A real demo under test: started as a user would, watched at the car's hub and in the referee's own log, hurt on purpose."""

import io
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec
import tomli_w
from rich.console import Console

from tower.demo.aftermath import make_whole
from tower.demo.crew import CAR, TOWER, Member, crew, utc_folder
from tower.demo.observer import Observer
from tower.demo.session import choose, write_session
from wire.configuration import read_sections, read_tables, shipped
from wire.messages.sensing import Referee
from wire.messages.vehicle import Mode
from wire.settings import WireSettings

LOOK_S = 0.02
_decode = msgspec.json.Decoder(Referee).decode


class RigError(Exception):
    """The drive did not come to where the test needs it; the text says what it waited for and where the logs are."""


def real_time_factor() -> float:
    """Of the drives and rigs that are begun, whose patience is in their own time: what REAL_TIME_FACTOR says, else real time."""
    return float(os.environ.get("REAL_TIME_FACTOR", "1"))


class RefereeLog:
    """The referee's own log as it grows: each line is read once, whoever looks how often."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / "referee.jsonl"
        self._read = 0  # bytes
        self._entries: list[Referee] = []

    def entries(self) -> list[Referee]:
        """Everything logged so far; a line that is not whole yet comes the next time."""
        if self._path.exists():
            with self._path.open("rb") as stream:
                stream.seek(self._read)
                whole, end, _ = stream.read().rpartition(b"\n")
            self._read += len(whole) + len(end)
            self._entries += map(_decode, whole.splitlines())
        return self._entries


@dataclass(slots=True)
class Drive:
    """A running `tower demo`."""

    process: subprocess.Popen[bytes]
    folder: Path
    observer: Observer
    log: RefereeLog

    def pid(self, name: str) -> int:
        return int(json.loads((self.folder / "processes.json").read_text())[name])

    def hurt(self, name: str, how: signal.Signals) -> None:
        os.kill(self.pid(name), how)

    @property
    def mode(self) -> Mode | None:
        status = self.observer.status
        return status.mode if status else None

    def referee(self) -> list[Referee]:
        """Everything the referee has logged so far; its log outlives the hub."""
        return self.log.entries()

    def wait_until(self, what: str, condition: Callable[[], bool], patience_s: float) -> None:
        """Look until `condition` holds. Raises RigError after `patience_s` or when the demo ended before."""
        until = time.monotonic() + patience_s / real_time_factor()
        while not condition():
            if self.process.poll() is not None or time.monotonic() > until:
                ended = self.process.poll() is not None
                raise RigError(
                    f"{'the demo ended' if ended else f'{patience_s:g} s passed'} before: {what}; mode {self.mode}, "
                    f"logs in {self.folder}\n{self.said()[-2000:]}"
                )
            self.observer.news.wait(LOOK_S)
            self.observer.news.clear()

    def wait(self, patience_s: float) -> int:
        """Until the demo has ended by itself; its exit code."""
        return self.process.wait(patience_s / real_time_factor())

    def said(self) -> str:
        """What the demo has printed so far."""
        return (self.folder.parent / "demo.log").read_text(errors="replace")

    def end(self) -> int:
        """Ask the demo to end; its exit code."""
        self.process.send_signal(signal.SIGTERM)
        return self.process.wait(60)


def read_referee(folder: Path) -> list[Referee]:
    """All of a log at once."""
    return RefereeLog(folder).entries()


@contextmanager
def driving(sessions: Path, *arguments: str, environment: dict[str, str] | None = None, lighter: bool = False) -> Iterator[Drive]:
    """`tower demo ARGUMENTS` from its start; leaving the context ends it and everything it started.

    lighter  with the front camera alone, half its width and height and the window's: about the drive, not about how fast this
             machine encodes
    """
    log = sessions / "demo.log"
    program = Path(sys.executable).parent / "tower"
    arguments = (*arguments, "--config", str(with_lighter_pictures(sessions))) if lighter else arguments
    variables = os.environ | {"SDL_VIDEODRIVER": "dummy"} if environment is None else environment
    with log.open("wb") as stream:
        process = subprocess.Popen(
            [str(program), "demo", "--sessions", str(sessions), "--real-time-factor", f"{real_time_factor():g}", *arguments],
            stdout=stream,
            stderr=stream,
            stdin=subprocess.DEVNULL,
            env=variables,
        )
    try:
        folder = _folder(sessions, process, log)
        wire: WireSettings = read_sections(folder / "session.toml", {"wire": WireSettings})["wire"]
        with Observer(wire.link) as observer:
            yield Drive(process, folder, observer, RefereeLog(folder))
    finally:
        if process.poll() is None:
            process.terminate()
            try:
                process.wait(60)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def halved(camera: dict[str, Any]) -> dict[str, Any]:
    """The same view, half as wide and high."""
    sizes = {name: camera[name] // 2 for name in ("width_px", "height_px")}
    return camera | sizes | {"focal_length_px": camera["focal_length_px"] / 2}


def with_lighter_pictures(folder: Path) -> Path:
    """The shipped simulated car with its front camera alone, a quarter of the pixels, in the window too; the same view."""
    tables = read_tables(shipped("simulated.toml"))
    tables["tower"].setdefault("window", {}).update(width_px=640, height_px=360)
    tables["vehicle"]["cameras"] = [halved(camera) for camera in tables["vehicle"]["cameras"] if camera["name"] == "front"]
    written = folder / "lighter.toml"
    written.write_bytes(tomli_w.dumps(tables).encode())
    return written


def _folder(sessions: Path, process: subprocess.Popen[bytes], log: Path) -> Path:
    """The session's folder, as soon as its processes run."""
    until = time.monotonic() + 30.0
    while time.monotonic() < until and process.poll() is None:
        found = [path.parent for path in sessions.glob("*/processes.json")]
        if found:
            return found[0]
        time.sleep(LOOK_S)
    raise RigError(f"the demo did not start:\n{log.read_text(errors='replace')}")


@contextmanager
def driving_with(sessions: Path, scenario: str, window: Path) -> Iterator[tuple[Path, Observer]]:
    """Every process of a demo, but with the script `window` in the window's place; the session's folder and an observer."""
    tables = choose(shipped("simulated.toml"), scenario, "")
    folder = utc_folder(sessions)
    written = write_session(tables, folder)
    wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
    members = (Member("window", "python", str(window)), *(member for member in (*TOWER, *CAR) if member.name != "window"))
    with crew(members, written, folder), Observer(wire.link) as observer:
        yield folder, observer
    make_whole(folder, Console(file=io.StringIO()))


@contextmanager
def standing_car(sessions: Path, scenario: str) -> Iterator[tuple[Path, Observer]]:
    """Every program of a car that stands and waits for somebody, and nothing of the tower; its folder and an observer.

    The configuration, also for the tower, is `folder`/session.toml: a person drives, not the scripted operator. Pictures of half
    the size at 13.5 a second: this is about what a person does, not about encoding.
    """
    tables = choose(shipped("simulated.toml"), scenario, "")
    tables["vehicle"]["cameras"] = [halved(camera) | {"frame_rate_hz": 13.5} for camera in tables["vehicle"]["cameras"]]
    tables["vehicle_gateway"]["limits"]["authority"]["engage_autonomously"] = False
    tables["tower"]["cockpit"] |= {"device": "keyboard", "operator": "ann"}
    folder = utc_folder(sessions)
    written = write_session(tables, folder)
    wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
    with crew(CAR, written, folder), Observer(wire.link) as observer:
        yield folder, observer
    make_whole(folder, Console(file=io.StringIO()))


@contextmanager
def tower_drive(config: Path, sessions: Path, environment: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """`tower drive` as a user starts it; what it prints is in `sessions`/drive.log. Leaving the context ends it."""
    program = Path(sys.executable).parent / "tower"
    with (sessions / "drive.log").open("wb") as log:
        process = subprocess.Popen(
            [str(program), "drive", "--config", str(config), "--sessions", str(sessions)],
            stdout=log,
            stderr=log,
            stdin=subprocess.DEVNULL,
            env=environment,
        )
    try:
        yield process
    finally:
        process.terminate()
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
