"""The outbox of the simulated car: what the loop puts in arrives, by threads that do not stand behind somebody's pictures."""

import json
import subprocess
import sys
import threading
from pathlib import Path

import msgspec

from tests.scheduling import needs_fifo
from wire import certificates
from wire.clock import Clock
from wire.link import open_link
from wire.ports import free_addresses
from wire.settings import LinkSettings
from wire.topics import Role

PATIENCE_S = 20.0
PRIORITY = 2
CAR = """
import json, sys, threading
from pathlib import Path
import msgspec
from vehicle_gateway.simulation.outbox import Outbox
from wire.clock import Clock
from wire.messages.sensing import Gnss
from wire.settings import LinkSettings
from wire.topics import Role

stands = dict(deviation_m=0.07, heading_rad=0.1, heading_deviation_rad=0.006)
over = threading.Event()
threading.Thread(target=lambda: (sys.stdin.read(), over.set())).start()
with Outbox(msgspec.json.decode(sys.argv[1], type=LinkSettings), Role.SIMULATE, Clock(), int(sys.argv[2])) as outbox:
    while not over.wait(0.01):
        outbox.put("gnss", Gnss(stamp_ns=1, x_m=1.25, y_m=2.5, **stands))
    priorities = {}
    for thread in Path("/proc/self/task").iterdir():
        name, _, rest = (thread / "stat").read_text().partition("(")[2].rpartition(")")
        priorities[name] = int(rest.split()[37])  # real-time priority, 0: plain (proc_pid_stat(5), field 40)
print(json.dumps(priorities))
"""


@needs_fifo
def test_what_is_put_arrives_by_threads_that_do_not_wait_behind_pictures(tmp_path: Path):
    certificates.make(tmp_path / "certificates")
    settings = LinkSettings(certificates=str(tmp_path / "certificates"), car_hub=free_addresses(1)[0])
    came = threading.Event()
    with open_link(settings, Role.VEHICLE_HUB, Clock(), threading.Event(), hub=True) as hub:
        hub.on("gnss", lambda _, __: came.set())
        command = [sys.executable, "-c", CAR, msgspec.json.encode(settings).decode(), str(PRIORITY)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as car:
            arrived = came.wait(PATIENCE_S)
            told, _ = car.communicate("")
    assert arrived
    link = {name: priority for name, priority in json.loads(told).items() if name.startswith(("app-", "tx-", "rx-"))}
    assert len(link) >= 3 and set(link.values()) == {PRIORITY}
