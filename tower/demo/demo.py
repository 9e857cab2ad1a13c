"""`tower demo`: start every program of car and tower, watch the drive, stop them, and tell what the recording says happened."""

import threading
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from tower.demo.aftermath import make_whole, summarize
from tower.demo.crew import CAR, TOWER, Crew, Ended, crew, utc_folder
from tower.demo.observer import Observer
from tower.demo.report import table_of
from tower.demo.session import choose, write_session
from tower.demo.story import Story
from wire.configuration import read_sections
from wire.messages.vehicle import Mode
from wire.scenario import Scenario, read_scenario
from wire.settings import WireSettings

LOOK_S = 0.1
START_PATIENCE_S = 60.0  # until the simulated world runs: a cold disk and two cores
END_SCREEN_S = 3.0  # how long the end screen stays before the window is closed
REFUSED_S = 5.0  # with a file as camera: how long the car stands refused before the demo has shown what it shows


@dataclass(frozen=True, slots=True, kw_only=True)
class Choices:
    """What the command line chose."""

    scenario: str
    front_camera: str
    sessions: Path


def run(config: Path, stop: threading.Event, choices: Choices) -> int:
    """The demo from start to report. 0 when it went as it should, 1 when not; user errors raise ConfigurationError."""
    console = Console(highlight=False, soft_wrap=True)
    tables = choose(config, choices.scenario, choices.front_camera)
    scenario, _ = read_scenario(Path(tables["vehicle_gateway"]["simulation"]["scenario"]))
    folder = utc_folder(choices.sessions)
    written = write_session(tables, folder)
    wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
    console.print(f"{scenario.name}: a drive of at most {scenario.time_limit_s:g} s, kept in {folder}")
    story = Story()
    with crew((*TOWER, *CAR), written, folder) as people, Observer(wire.link) as observer:
        failure = _watch(story, observer, people, stop, console, scenario, bool(choices.front_camera))
    make_whole(folder, console)
    summary = summarize(folder)
    if summary is not None:
        console.print(table_of(summary, folder))
    if failure:
        console.print(f"the demo failed: {failure}", style="bold red")
    return 1 if failure else 0


def _watch(
    story: Story,
    observer: Observer,
    people: Crew,
    stop: threading.Event,
    console: Console,
    scenario: Scenario,
    refuses: bool,
) -> str:
    """Look until the drive is over. Why it failed; "" when it went as it should."""
    waited_s = 0.0
    while not stop.wait(LOOK_S):
        waited_s += LOOK_S
        for line in story.look(observer.status, observer.referee):
            console.print(f"{story.elapsed_s:6.1f} s  {line}")
        for ended in people.look_after():
            console.print(f"{story.elapsed_s:6.1f} s  {_told(ended)}", style="yellow")
            if _ends_the_demo(ended):
                return _told(ended)
        if story.started_s is None and waited_s > START_PATIENCE_S:
            return f"the simulated world did not start within {START_PATIENCE_S:g} s; see the logs in the session's folder"
        over = _over(story, scenario, refuses)
        if over is not None:
            stop.wait(END_SCREEN_S)
            return over
    return "asked to stop"


def _over(story: Story, scenario: Scenario, refuses: bool) -> str | None:
    """None while the drive goes on; "" when it ended well; otherwise why it failed."""
    if story.collisions:
        return "the car collided"
    if story.goal_reached:
        return "the hand-over was granted although a file was the camera" if refuses and story.was_remote else ""
    stood_s = 0.0 if story.stopped_since_s is None else story.elapsed_s - story.stopped_since_s
    if refuses and story.mode is Mode.STOPPED and stood_s > REFUSED_S:
        return "" if story.refused and not story.was_remote else "the hand-over was not refused"
    if story.elapsed_s > scenario.time_limit_s:
        return f"the goal was not reached within {scenario.time_limit_s:g} s"
    return None


def _ends_the_demo(ended: Ended) -> bool:
    """The world is gone, something is broken for good, or the person closed the window."""
    return not ended.started_again and ended.name != "recorder"


def _told(ended: Ended) -> str:
    return f"{ended.name} ended ({ended.how}){': started again' if ended.started_again else ''}"
