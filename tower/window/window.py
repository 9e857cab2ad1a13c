"""Program `tower window`: opens link, video receiver and screen, and runs the loop. Decides nothing.

A picture is put on screen within about 4 ms of its decoding; without one the window is drawn 25 times a second.
"""

import threading
from pathlib import Path

import cv2

from tower.devices import store
from tower.settings import TowerSettings
from tower.video.receiver import VideoReceiver
from tower.window.display_loop import DisplayLoop
from tower.window.screen import Screen
from tower.window.settings import WindowSettings
from tower.window.snapshot import SnapshotWriter
from tower.window.sounds import Player
from wire.clock import tower_clock
from wire.configuration import read_sections
from wire.ice import ways
from wire.link import open_link
from wire.link_threads import for_pictures, threads_with
from wire.pace import Pace, share_interpreter
from wire.settings import WireSettings
from wire.topics import PROGRAMS, Role

_LOOK_S = 1 / 240  # how often the loop looks for a new picture and keys
_HEALTH_NS = 1_000_000_000


def run(config: Path, stop: threading.Event) -> int:
    """Until `stop` is set or the operator quits. Exit code 0.

    Raises ConfigurationError (ScreenError when no window can be opened is one), LinkError, Stopped.
    """
    sections = read_sections(config, {"wire": WireSettings, "tower": TowerSettings})
    wire, settings = sections["wire"], sections["tower"].window
    servers, pictures = ways(wire.ice), for_pictures(wire.pace.fifo_priority)
    clock = tower_clock(wire.clock)
    share_interpreter()
    cv2.setNumThreads(1)  # a window must not take the cores of the control loops beside it
    with (
        threads_with(pictures),
        open_link(wire.link, Role.WINDOW, clock, stop) as link,
        Screen(settings, store.load(store.folder())) as screen,
        VideoReceiver(link, clock, (), servers, sections["tower"].cockpit.operator) as video,
        SnapshotWriter(_snapshot_path(wire, settings)) as writer,
        Pace(_LOOK_S, clock, stop, fifo_priority=pictures) as pace,
    ):
        loop = DisplayLoop(
            recording=Path(wire.session.folder).name,
            vehicle_id=wire.link.vehicle_id,
            operator_name="" if settings.replay else sections["tower"].cockpit.operator,
            full_screen=settings.full_screen,
            replay=settings.replay,
            real_time_factor=wire.clock.real_time_factor,
            scan_out_ms=(settings.scan_out_delay_ms, settings.scan_out_bound_ms),
            checklist=settings.checklist and sections["tower"].cockpit.device != "scripted" and not settings.replay,
            link=link,
            video=video,
            screen=screen,
            writer=writer,
            player=Player(settings.sound, settings.volume),
            clock=clock,
        )
        health_ns = 0
        for now_ns in pace:
            if loop.step(now_ns):
                break
            if now_ns - health_ns >= _HEALTH_NS:
                health_ns = now_ns
                link.publish("tower_health", pace.health(PROGRAMS[Role.WINDOW], "display", link.dropped))
    return 0


def _snapshot_path(wire: WireSettings, settings: WindowSettings) -> Path | None:
    """None when no session's folder is named, or no snapshot is wanted."""
    return Path(wire.session.folder) / settings.snapshot if wire.session.folder and settings.snapshot else None
