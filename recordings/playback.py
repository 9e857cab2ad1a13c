"""`recordings replay`: a recorded drive onto a link of its own, message by message as it came, for a window to show.

Every recorded topic is said at the site it came from; pictures go to `vehicle-gateway video --played`, which sends them on
unchanged. What the watching window itself says (window_status) is not played but listened to. It drives nothing and decides
nothing: see `recordings.stage` for what keeps a replay apart from any car.
"""

import threading
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from datetime import UTC, datetime
from pathlib import Path

from recordings.read import Recording
from recordings.stage import Program, stage_folder, stage_tables, write_configuration
from recordings.timeline import Timeline, timeline
from recordings.writer import VIDEO
from wire.clock import Clock
from wire.configuration import read_sections, read_tables
from wire.link import Link, open_link
from wire.messages.operating import WindowStatus
from wire.settings import WireSettings
from wire.topics import TOPICS, Role

LEAD_MIN_S, LEAD_MAX_S = 3.0, 20.0  # until the first message: the window opens, the video session is agreed upon
FAREWELL_S = 1.0  # after the last message
_REPEAT_S = 0.2  # of the first pictures while the window opens
_PLAYED_VIDEO = "played_video"
_WATCHER_SAYS = "window_status"


@dataclass(slots=True)
class Shown:
    """How old the pictures were that the watching window showed, by the clocks of the recording."""

    ages_ms: list[float] = field(default_factory=list)

    def add(self, status: WindowStatus, vehicle_minus_tower_ns: int) -> None:
        self.ages_ms += [(frame.shown_ns + vehicle_minus_tower_ns - frame.capture_ns) / 1e6 for frame in status.shown]


@dataclass(slots=True)
class Played:
    """What a replay came to."""

    messages: Counter[str] = field(default_factory=Counter)  # by topic
    unknown: Counter[str] = field(default_factory=Counter)  # of topics that this version does not have
    latest_ms: float = 0.0  # how late the latest message was said
    whole: bool = False  # to its end
    shown: Shown = field(default_factory=Shown)


class Player:
    """Says recorded messages at the right hub. `car` and `tower` are the hubs' links."""

    def __init__(self, car: Link, tower: Link) -> None:
        self._car, self._tower = car, tower
        self.played = Played()

    def hold(self, plan: Timeline) -> None:
        """What to begin with, as often as one likes: a window that has just come asks for the car's cameras, and shows them."""
        self._car.publish("vehicle_description", plan.vehicle)
        for payload in plan.first_pictures.values():
            self._car.publish(_PLAYED_VIDEO, payload)

    def say(self, topic: str, payload: bytes) -> None:
        if topic == VIDEO:
            self._car.publish(_PLAYED_VIDEO, payload)
        elif topic not in TOPICS:
            self.played.unknown[topic] += 1
            return
        elif topic != _WATCHER_SAYS:
            (self._car if TOPICS[topic].origin_is_car else self._tower).publish(topic, payload)
        self.played.messages[topic] += 1


def label_of(recording: Recording) -> str:
    """What the window says all the time."""
    span = recording.span_ns
    when = datetime.fromtimestamp(span[0] / 1e9, UTC).strftime("%Y-%m-%d %H:%M:%S UTC") if span else "nothing"
    return f"{recording.path.parent.name}/{recording.path.name}, recorded {when}"


def play(
    recording: Recording, config: Path, from_s: float, with_window: bool, stop: threading.Event, tell: Callable[[str], None]
) -> Played:
    """Play from `from_s` to the end, until `stop`, or until the window is closed.

    config  whose [tower.window] the watcher wants
    Raises RecordingError, ConfigurationError, LinkError.
    """
    plan, clock = timeline(recording, from_s), Clock()
    with ExitStack() as stack:
        folder = stack.enter_context(stage_folder())
        vehicle_id = recording.metadata.get("drive", {}).get("vehicle_id") or plan.vehicle.vehicle_id
        tables = stage_tables(read_tables(config), plan.vehicle, vehicle_id, label_of(recording), folder)
        written = write_configuration(tables, 0, folder / "video.toml")
        wire: WireSettings = read_sections(written, {"wire": WireSettings})["wire"]
        car, tower = (
            stack.enter_context(open_link(wire.link, role, clock, stop, hub=True)) for role in (Role.VEHICLE_HUB, Role.TOWER_HUB)
        )
        player = Player(car, tower)
        tower.on(_WATCHER_SAYS, lambda status, _: player.played.shown.add(status, plan.vehicle_minus_tower_ns))
        video = stack.enter_context(Program(folder, "vehicle-gateway", "video", "--played", "--config", str(written)))
        video_s = _seconds_until_heard(car, Waiting(clock, stop, [video]))
        leads_ns = leads_for(video_s if with_window else LEAD_MAX_S)  # somebody has to type the command
        for lead_ns in leads_ns:
            begin_ns, window = clock.now_ns() + lead_ns, folder / "window.toml"
            write_configuration(tables, plan.tower_ns(plan.start_ns) - begin_ns, window)
            with ExitStack() as opened:
                programs = [video]
                if with_window:
                    programs.append(opened.enter_context(Program(folder, "tower", "window", "--config", str(window))))
                else:
                    tell(f"watch within {lead_ns / 1e9:.0f} s with: tower window --config {window}")
                waiting = Waiting(clock, stop, programs)
                if not _hold(player, plan, begin_ns, waiting):
                    break
                if player.played.shown.ages_ms or not plan.first_pictures or lead_ns == leads_ns[-1]:
                    _run(player, recording, plan, begin_ns, waiting)
                    break
            tell(f"the window shows nothing after {lead_ns / 1e9:.0f} s: opened once more, with more time")
        return player.played


def leads_for(video_s: float) -> list[int]:
    """Nanoseconds until the first message, of each try: the window's clock is set to that moment before it starts, so one that
    shows nothing by then has to be opened anew."""
    leads_ns = [lead_for(video_s)]
    while leads_ns[-1] < LEAD_MAX_S * 1e9:
        leads_ns.append(min(2 * leads_ns[-1], round(LEAD_MAX_S * 1e9)))
    return leads_ns


def lead_for(video_s: float) -> int:
    """Of the first try, from the time that the video program took to start: the window loads the same libraries, opens a screen
    and agrees on a video session."""
    return round(min(max(LEAD_MIN_S, 2.5 * video_s), LEAD_MAX_S) * 1e9)


def _seconds_until_heard(car: Link, waiting: "Waiting") -> float:
    begin_ns = waiting.clock.now_ns()
    while not car.is_heard(_PLAYED_VIDEO) and waiting.until(waiting.clock.now_ns() + 50_000_000):
        pass
    return (waiting.clock.now_ns() - begin_ns) / 1e9


@dataclass(frozen=True, slots=True)
class Waiting:
    """Until a moment comes, or nobody wants to see more."""

    clock: Clock
    stop: threading.Event
    programs: Sequence[Program]

    def until(self, due_ns: int) -> bool:
        """False when it is over: asked to stop, or the window was closed. Raises RecordingError when a program failed."""
        while (rest_ns := due_ns - self.clock.now_ns()) > 0:
            if self.stop.wait(min(rest_ns / 1e9, _REPEAT_S)) or not all(program.runs() for program in self.programs):
                return False
        return True


def _hold(player: Player, plan: Timeline, begin_ns: int, waiting: Waiting) -> bool:
    """The car and its first pictures again and again until `begin_ns`. False when nobody wants to see more."""
    clock = waiting.clock
    while clock.now_ns() < begin_ns:
        player.hold(plan)
        if not waiting.until(min(clock.now_ns() + round(_REPEAT_S * 1e9), begin_ns)):
            return False
    return True


def _run(player: Player, recording: Recording, plan: Timeline, begin_ns: int, waiting: Waiting) -> None:
    """Every message at its time."""
    clock, played = waiting.clock, player.played
    for topic, log_ns, payload in recording.payloads(plan.start_ns):
        due_ns = begin_ns + log_ns - plan.start_ns
        if not waiting.until(due_ns):
            return
        player.say(topic, payload)
        played.latest_ms = max(played.latest_ms, (clock.now_ns() - due_ns) / 1e6)
    played.whole = True
    waiting.until(clock.now_ns() + round(FAREWELL_S * 1e9))


def told_of(played: Played) -> list[str]:
    """What a replay came to, in words."""
    end = "to its end" if played.whole else "and ended early"
    lines = [f"played {sum(played.messages.values())} messages {end}, the latest {played.latest_ms:.0f} ms late"]
    ages, pictures = sorted(played.shown.ages_ms), played.messages[VIDEO]
    if ages:
        lines.append(f"the window showed {len(ages)} pictures of {pictures}, {ages[len(ages) // 2]:.0f} ms old at the median")
    elif pictures:
        lines.append(
            f"no window showed any of {pictures} pictures: none was open in time; close what else runs here and play it again"
        )
    lines += [f"{count} messages of {topic}: a topic that this version does not have" for topic, count in played.unknown.items()]
    return lines
