"""The real cockpit with a G920 whose events come as datagrams instead of from evdev.

    python -m benchmarks.datagram_wheel CONFIG PORT

Everything behind the device file is as in `tower cockpit`: the profile, the touch that selects, the arming, the loop at 250 Hz.
What is missing is the kernel's part: USB, the driver, evdev's read.
"""

import json
import secrets
import socket
import sys
import threading
from collections import deque
from collections.abc import Mapping
from pathlib import Path
from time import monotonic_ns

from haptics.force_feedback import Abilities
from haptics.settings import HapticsSettings
from tower.cockpit.asker import Asker
from tower.cockpit.cockpit import TICK_S, Cockpit
from tower.cockpit.wheel import WheelDevice
from tower.devices.known import KNOWN, through_evdev
from tower.devices.source import Readings
from tower.settings import TowerSettings
from wire.certificates import folder_of
from wire.clock import Clock
from wire.configuration import read_sections
from wire.identity import signer_of
from wire.link import open_link
from wire.link_threads import beneath
from wire.pace import Pace
from wire.process import run_until_stopped
from wire.settings import WireSettings
from wire.topics import Role

PROFILE = through_evdev(KNOWN["046d:c262"])


class DatagramSource:
    """Each datagram is [sent_ns, [[input, value], ...]] in JSON: what one read of the device file would bring."""

    def __init__(self, port: int) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", port))
        self._socket.setblocking(False)

    def read(self, levels: Mapping[str, float]) -> tuple[Readings, int | None]:
        readings: list[tuple[str, float]] = []
        newest_ns: int | None = None
        try:
            while True:
                newest_ns, events = json.loads(self._socket.recv(4096))
                readings += [(name, value) for name, value in events]
        except BlockingIOError:
            return tuple(readings), None if newest_ns is None else max(monotonic_ns() - newest_ns, 0)

    def close(self) -> None:
        self._socket.close()


class Plugged:
    """One wheel that is there from the start."""

    note = ""

    def __init__(self, wheel: WheelDevice) -> None:
        self.arrived = deque((wheel,))


def main() -> int:
    config, port = Path(sys.argv[1]), int(sys.argv[2])
    wheel = WheelDevice(PROFILE, DatagramSource(port), Abilities(), None)

    def run(path: Path, stop: threading.Event) -> int:
        sections = read_sections(path, {"wire": WireSettings, "tower": TowerSettings, "haptics": HapticsSettings})
        wire: WireSettings = sections["wire"]
        clock = Clock(wire.clock.tower_offset_ns)
        served = beneath(wire.pace.fifo_priority)
        link_of_hub = open_link(wire.link, Role.TOWER_HUB, clock, stop, hub=True, fifo_priority=served)
        with link_of_hub as link, Asker(link.ask, clock) as asker:
            settings = sections["tower"].cockpit
            signer = signer_of(folder_of(wire.link.certificates), Role.TOWER_HUB)
            cockpit = Cockpit(settings, sections["haptics"], link, asker, secrets.token_hex(8), signer.sign, Plugged(wheel))
            with Pace(TICK_S, clock, stop, fifo_priority=wire.pace.fifo_priority) as pace:
                for now_ns in pace:
                    cockpit.cycle(now_ns)
            cockpit.close()
        return 0

    return run_until_stopped(run, config)


if __name__ == "__main__":
    sys.exit(main())
