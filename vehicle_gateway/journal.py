"""Every cycle goes to the recording, and none of them may wait for a recorder: a bounded queue and a thread of its own.

The thread's publishing blocks rather than loses (topic table: gateway_cycle travels as RECORD). A recorder that hangs fills
the queue; what then does not fit is counted, and the loop never notices. A shell: it decides nothing.
"""

import threading
from collections import deque
from typing import NamedTuple

import msgspec

from vehicle_gateway.state import Inputs, Outputs
from wire.link import Link
from wire.messages.vehicle import GatewayCycle

WAITING_MAX = 2500  # cycles: ten seconds at 250 Hz


class Entry(NamedTuple):
    number: int
    now_ns: int
    inputs: Inputs
    outputs: Outputs
    can_sent_ns: int
    command_sequence: int
    loop_age_ms: float


class Journal:
    """A context manager; leaving it publishes what still waits, for at most a second."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._waiting: deque[Entry] = deque()
        self._news = threading.Event()
        self._stop = False
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self.dropped = 0

    def __enter__(self) -> "Journal":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop = True
        self._news.set()
        self._thread.join(1.0)

    def keep(self, entry: Entry) -> None:
        if len(self._waiting) >= WAITING_MAX:
            self.dropped += 1
            return
        self._waiting.append(entry)
        self._news.set()

    def _run(self) -> None:
        while not self._stop or self._waiting:
            self._news.wait()
            self._news.clear()
            while self._waiting:
                self._link.publish("gateway_cycle", cycle_of(self._waiting.popleft()))


def cycle_of(entry: Entry) -> GatewayCycle:
    """The message of one cycle."""
    return GatewayCycle(
        number=entry.number,
        now_ns=entry.now_ns,
        inputs=msgspec.Raw(msgspec.json.encode(entry.inputs)),
        outputs=msgspec.Raw(msgspec.json.encode(entry.outputs)),
        can_sent_ns=entry.can_sent_ns,
        command_sequence=entry.command_sequence,
        new_command=entry.inputs.command is not None,
        loop_age_ms=entry.loop_age_ms,
        mode=entry.outputs.mode,
        rules=entry.outputs.rules,
    )
