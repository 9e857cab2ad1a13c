"""Another tower for a car that has one: what an intruder (benchmarks.intruder) comes with, his wait for the word, his window."""

import signal
import threading
from contextlib import AbstractContextManager
from pathlib import Path

from msgspec.structs import replace

from tower.settings import TowerSettings
from tower.video.receiver import VideoReceiver
from tower.window.picture_layout import FRONT
from wire.clock import Clock, car_clock
from wire.configuration import read_sections
from wire.ice import ways
from wire.link import Link, open_link
from wire.ports import free_udp_ports
from wire.settings import LinkSettings, WireSettings
from wire.topics import Role

READY, LOOK_S = "ready", 0.01


def wait_for_the_word(stop: threading.Event) -> None:
    """Ready. Begins with SIGUSR1, or is ended before."""
    word = threading.Event()
    signal.signal(signal.SIGUSR1, lambda *_: word.set())
    print(READY, flush=True)
    while not word.wait(LOOK_S) and not stop.is_set():
        pass


def beside(config: Path) -> LinkSettings:
    """Those of another tower: at the cockpit's own hub nobody else speaks as it."""
    (port,) = free_udp_ports(1)
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    return replace(wire.link, tower_hub=f"127.0.0.1:{port}")


def another_tower(settings: LinkSettings, config: Path, clock: Clock, stop: threading.Event) -> AbstractContextManager[Link]:
    """A hub of its own that dials the car with the cockpit's certificate."""
    device = read_sections(config, {"tower": TowerSettings})["tower"].cockpit.device
    return open_link(settings, Role.TOWER_SCRIPT if device == "scripted" else Role.TOWER_HUB, clock, stop, hub=True)


def looking_on(config: Path, stop: threading.Event) -> int:
    """How many pictures another tower's window decoded."""
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    clock, settings, servers = car_clock(wire.clock), beside(config), ways(wire.ice)
    with (
        another_tower(settings, config, clock, stop),
        open_link(settings, Role.WINDOW, clock, stop) as link,
        VideoReceiver(link, clock, (), servers, "a looker-on") as video,
    ):
        wait_for_the_word(stop)
        video.watch((FRONT,))
        stop.wait()
        return video.decoded[FRONT]
