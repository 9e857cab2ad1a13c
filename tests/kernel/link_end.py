"""One end of the real link, a process of its own in a network namespace: `link_end.py car|tower SETTINGS` (LinkSettings as JSON).

The car's end prints what arrives, a line each: what, number, when sent, when received [ns, the one monotonic clock of the
kernel]. The tower's end sends a command every 20 ms, and for each line of its standard input presses the cockpit's STOP.
"""

import os
import sys
import threading

import msgspec

from tower.cockpit import stop_button
from tower.cockpit.stop_button import StopButton
from wire.clock import Clock
from wire.link import Link, open_link
from wire.messages.base import Gear, Indicators
from wire.messages.operating import DriveCommand, TowerStop
from wire.pace import Pace
from wire.settings import LinkSettings
from wire.topics import Role

PERIOD_S = 0.02


def say(what: str, number: int, sent_ns: int, received_ns: int) -> None:
    os.write(1, f"{what} {number} {sent_ns} {received_ns}\n".encode())  # whole lines, whichever thread


def car(link: Link, _: threading.Event) -> None:
    link.on("drive_command", lambda command, at_ns: say("command", command.sequence, command.sent_ns, at_ns))
    link.on("tower_stop", lambda stop, at_ns: say("stop", stop.number, stop.sent_ns, at_ns))
    sys.stdin.read()


def tower(link: Link, stop: threading.Event) -> None:
    presses = Presses(stop)
    button = StopButton()
    with Pace(PERIOD_S, Clock(), stop) as pace:
        for sequence, now_ns in enumerate(pace):
            link.publish("drive_command", command(sequence, now_ns))
            if presses.count > button.number:
                button = stop_button.pressed(button, None, now_ns)
            button, due = stop_button.step(button, None, now_ns)  # no status comes: it is repeated for ever
            if due:
                link.publish("tower_stop", TowerStop(number=button.number, sent_ns=now_ns, operator="ann"))


class Presses:
    """Lines of the standard input so far; its end is ours."""

    def __init__(self, stop: threading.Event) -> None:
        self.count = 0
        threading.Thread(target=self._read, args=(stop,), daemon=True).start()

    def _read(self, stop: threading.Event) -> None:
        for _ in sys.stdin:
            self.count += 1
        stop.set()


def command(sequence: int, now_ns: int) -> DriveCommand:
    return DriveCommand(
        lease_epoch=1,
        sequence=sequence,
        sent_ns=now_ns,
        event_ns=now_ns,
        echoed_vehicle_ns=0,
        echoed_boot_id="",
        displayed_capture_ns={},
        road_wheel_angle_rad=0.1,
        acceleration_m_s2=-0.5,
        gear=Gear.DRIVE,
        indicators=Indicators.OFF,
        hazard=False,
        horn=False,
        dead_man=True,
        hmac="0" * 64,  # as long as a real one
    )


ENDS = {"car": (Role.VEHICLE_HUB, car), "tower": (Role.TOWER_HUB, tower)}

if __name__ == "__main__":
    role, live = ENDS[sys.argv[1]]
    stop = threading.Event()
    with open_link(msgspec.json.decode(sys.argv[2], type=LinkSettings), role, Clock(), stop, hub=True) as opened:
        live(opened, stop)
