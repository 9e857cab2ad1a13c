"""The floor of the recorder: hears all that it hears and writes nothing. `python -m benchmarks.unwritten CONFIG`."""

import sys
import threading
from pathlib import Path

from wire.clock import Clock
from wire.configuration import read_sections
from wire.link import open_link
from wire.messages.health import LoopHealth
from wire.pace import Pace
from wire.process import run_until_stopped
from wire.settings import WireSettings
from wire.topics import PROGRAMS, TOPICS, Role

TELL_S = 1.0


def run(config: Path, stop: threading.Event) -> int:
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    clock, heard = Clock(), [0]

    def hear(_: str, __: bytes, ___: int) -> None:
        heard[0] += 1

    with open_link(wire.link, Role.RECORDER, clock, stop) as link, Pace(TELL_S, clock, stop) as pace:
        for topic in TOPICS.values():
            if topic.recorded:
                link.on_raw(topic.name, hear)
        for _ in pace:
            health: LoopHealth = pace.health(PROGRAMS[Role.RECORDER], "floor")
            link.publish("car_health", health)
    return 0


if __name__ == "__main__":
    sys.exit(run_until_stopped(run, Path(sys.argv[1])))
