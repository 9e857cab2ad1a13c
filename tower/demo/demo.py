"""`tower demo`: start every program of car and tower, watch the drive, stop them, and tell what the recording says happened."""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console

from tower.demo.aftermath import make_whole, summarize
from tower.demo.crew import CAR, TOWER, Crew, Ended, compile_first, crew, utc_folder
from tower.demo.keeps_up import SLOWER, KeepsUp
from tower.demo.observer import Observer
from tower.demo.report import table_of
from tower.demo.session import choose, write_session
from tower.demo.story import Story
from wire.clock import Clock, car_clock
from wire.configuration import read_sections
from wire.messages.vehicle import Mode
from wire.scenario import Scenario, read_scenario
from wire.settings import WireSettings

LOOK_S = 0.1
START_PATIENCE_S = 60.0  # until the simulated world runs: a cold disk and two cores
END_SCREEN_S = 3.0  # how long the end screen stays before the window is closed
SILENT_S = 20.0  # without any word from the referee: longer than a gateway takes to be started again
REFUSED_S = 5.0  # with a file as camera: how long the car stands refused before the demo has shown what it shows


FAILED, INTERRUPTED = 1, 130


@dataclass(frozen=True, slots=True)
class Verdict:
    code: int
    text: str = ""
    ran_out_of_time: bool = False


PASSED = Verdict(0)
TOO_SLOW = Verdict(FAILED, "this machine cannot keep up with the pictures")


def failed(why: str) -> Verdict:
    return Verdict(FAILED, f"the demo failed: {why}")


def out_of_time(limit_s: float) -> Verdict:
    return replace(failed(f"the goal was not reached within {limit_s:g} s"), ran_out_of_time=True)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """What the command line chose."""

    scenario: str
    front_camera: str
    sessions: Path
    real_time_factor: float | None = None  # as configured, and slower when the machine cannot keep up


def run(config: Path, stop: threading.Event, choices: Choices) -> int:
    """The demo from start to report. 0 when it went as it should, 1 when not; user errors raise ConfigurationError."""
    console = Console(highlight=False, soft_wrap=True)
    verdict = _drive(config, stop, choices, console)
    if verdict is TOO_SLOW:
        console.print(f"{verdict.text}: once more, at {SLOWER:.0%} of real time (--real-time-factor 1 insists)", style="yellow")
        verdict = _drive(config, stop, replace(choices, real_time_factor=SLOWER), console)
    if verdict.text:
        console.print(verdict.text, style="bold red" if verdict.code == FAILED else "yellow", markup=False)
    return verdict.code


def _drive(config: Path, stop: threading.Event, choices: Choices, console: Console) -> Verdict:
    """One drive in a folder of its own. TOO_SLOW: not good enough for the machine's sake, and nobody said how fast it has to be."""
    tables = choose(config, choices.scenario, choices.front_camera)
    if choices.real_time_factor is not None:
        tables.setdefault("wire", {}).setdefault("clock", {})["real_time_factor"] = choices.real_time_factor
    scenario, _ = read_scenario(Path(tables["vehicle_gateway"]["simulation"]["scenario"]))
    folder = utc_folder(choices.sessions)
    written = write_session(tables, folder)
    wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
    console.print(f"{scenario.name}: a drive of at most {scenario.time_limit_s:g} s, kept in {folder}")
    story, clock = Story(), car_clock(wire.clock)
    compile_first(stop)
    may_be_slower = choices.real_time_factor is None and clock.real_time_factor == 1.0
    with crew((*TOWER, *CAR), written, folder) as people, Observer(wire.link, clock=clock) as observer:
        watch = Watch(story, observer, people, console, scenario, bool(choices.front_camera), KeepsUp() if may_be_slower else None)
        verdict = _watch(watch, clock, stop)
    make_whole(folder, console)
    if verdict is TOO_SLOW:
        return verdict
    summary = summarize(folder, console)
    if summary is not None:
        console.print(table_of(summary, folder, clock.real_time_factor))
    if may_be_slower and verdict.ran_out_of_time and could_not_keep_up(summary):
        return TOO_SLOW
    return with_slow_machine(missing_files(verdict, folder, story.was_remote), summary)


def could_not_keep_up(summary: dict[str, Any] | None) -> bool:
    """Whether a drive's cameras had nothing left to give up."""
    return summary is not None and any(camera.get("halved_s") for camera in summary["cameras"].values())


def with_slow_machine(verdict: Verdict, summary: dict[str, Any] | None) -> Verdict:
    """A drive that failed on a machine that could not keep up says so, with what to do."""
    if verdict.code == 0 or not could_not_keep_up(summary):
        return verdict
    fix = (
        "end what else runs on it, drive slower with --real-time-factor, "
        "or give it smaller pictures: [[vehicle.cameras]] in a copy of simulated.toml, with --config"
    )
    return Verdict(verdict.code, f"{verdict.text}; this machine could not keep up with the pictures: {fix}")


def missing_files(verdict: Verdict, folder: Path, was_remote: bool) -> Verdict:
    """A drive that went well but did not leave what it promises has failed all the same."""
    promised = ("drive.mcap", "summary.json", *(("window.png",) if was_remote else ()))
    missing = [name for name in promised if not (folder / name).is_file()]
    return failed(f"no {', '.join(missing)} in {folder}; see its logs") if missing and verdict.code == 0 else verdict


def _watch(watch: Watch, clock: Clock, stop: threading.Event) -> Verdict:
    """Look until the drive is over."""
    started_ns = seen_ns = clock.now_ns()
    stamp_ns = 0
    while not stop.wait(LOOK_S):
        now_ns = clock.now_ns()
        referee = watch.observer.referee
        if referee is not None and referee.stamp_ns != stamp_ns:
            started_ns = started_ns if stamp_ns else now_ns
            stamp_ns, seen_ns = referee.stamp_ns, now_ns
        watch.tell()
        verdict = watch.processes() or watch.unseen() or watch.too_slow() or over(watch.story, watch.scenario, watch.refuses)
        verdict = verdict or late(stamp_ns > 0, (now_ns - started_ns) / 1e9, (now_ns - seen_ns) / 1e9, watch.scenario.time_limit_s)
        if verdict is not None:
            if verdict.code == 0:
                stop.wait(END_SCREEN_S)
            return verdict
    return Verdict(INTERRUPTED, "stopped before the end")


@dataclass(frozen=True, slots=True)
class Watch:
    """What the supervisor looks at, and how it tells."""

    story: Story
    observer: Observer
    people: Crew
    console: Console
    scenario: Scenario
    refuses: bool  # a file is the camera: the hand-over has to be refused
    keeps_up: KeepsUp | None = None  # None: however slow the machine is

    def tell(self) -> None:
        for line in self.story.look(self.observer.status, self.observer.referee):
            self.console.print(f"{self.story.elapsed_s:6.1f} s  {line}")

    def unseen(self) -> Verdict | None:
        """The verdict when nothing can be seen of the drive, and why."""
        return failed(self.observer.error) if self.observer.error else None

    def too_slow(self) -> Verdict | None:
        status = self.observer.status
        mode = status.mode if status is not None else None
        if self.keeps_up is None or self.keeps_up.look(self.observer.cameras, mode, self.story.elapsed_s):
            return None
        return TOO_SLOW

    def processes(self) -> Verdict | None:
        """Tell of every process that ended, stopped or went on; the verdict when one of them ends the demo."""
        for line in self.people.paused():
            self.console.print(f"{self.story.elapsed_s:6.1f} s  {line}", style="yellow")
        for ended in self.people.look_after():
            self.console.print(f"{self.story.elapsed_s:6.1f} s  {told(ended)}", style="yellow")
            if ended.name == "window" and ended.how == "exit 0":
                return Verdict(INTERRUPTED, "the window was closed before the end")
            if not ended.started_again and ended.name != "recorder":
                return failed(told(ended))
        return None


def over(story: Story, scenario: Scenario, refuses: bool) -> Verdict | None:
    """None while the drive goes on."""
    if story.collisions:
        return failed("the car collided")
    if story.goal_reached:
        return failed("the hand-over was granted although a file was the camera") if refuses and story.was_remote else PASSED
    stood_s = 0.0 if story.stopped_since_s is None else story.elapsed_s - story.stopped_since_s
    if refuses and story.mode is Mode.STOPPED and stood_s > REFUSED_S:
        return PASSED if story.refused and not story.was_remote else failed("the hand-over was not refused")
    if story.elapsed_s > scenario.time_limit_s:
        return out_of_time(scenario.time_limit_s)
    return None


def late(started: bool, running_s: float, silent_s: float, limit_s: float) -> Verdict | None:
    """What the supervisor's own clock says, when the world's cannot be heard: a stopped hub must not hold the demo for ever."""
    if not started:
        return (
            failed("the simulated world did not start; see the logs in the session's folder")
            if running_s > START_PATIENCE_S
            else None
        )
    if silent_s > SILENT_S:
        return failed(f"nothing was heard of the simulated world for {SILENT_S:g} s")
    return out_of_time(limit_s) if running_s > limit_s + SILENT_S else None


def told(ended: Ended) -> str:
    return f"{ended.name} ended ({ended.how}){': started again' if ended.started_again else ''}"
