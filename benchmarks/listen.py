"""`python -m benchmarks.listen [--tower] CONFIG TOPIC...`: what arrives at a site's hub, a JSON line each.

At the car's as the recorder hears it, at the tower's as an observer does.

For tests that look into a network namespace from outside: run in there, read here. Ends with its parent's pipe or SIGTERM.
"""

import sys
import threading
from pathlib import Path

from wire.clock import car_clock
from wire.configuration import read_sections
from wire.link import open_link
from wire.process import run_until_stopped
from wire.settings import WireSettings
from wire.topics import Role


def run(config: Path, stop: threading.Event, role: Role, topics: list[str]) -> int:
    wire: WireSettings = read_sections(config, {"wire": WireSettings})["wire"]
    lock = threading.Lock()

    def tell(name: str, payload: bytes, received_ns: int) -> None:
        with lock:
            sys.stdout.buffer.write(b'{"topic":"%b","received_ns":%d,"message":%b}\n' % (name.encode(), received_ns, payload))
            sys.stdout.buffer.flush()

    with open_link(wire.link, role, car_clock(wire.clock), stop) as link:
        for topic in topics:
            link.on_raw(topic, tell)
        stop.wait()
    return 0


if __name__ == "__main__":
    at_tower = sys.argv[1] == "--tower"
    config, *topics = sys.argv[2:] if at_tower else sys.argv[1:]
    role = Role.TOWER_OBSERVER if at_tower else Role.RECORDER
    sys.exit(run_until_stopped(lambda path, stop: run(path, stop, role, topics), Path(config)))
