"""Every cycle goes to the recording, and none of them may wait for a recorder: a bounded queue and a thread of its own.

The thread's publishing blocks rather than loses (topic table: gateway_cycle travels as RECORD). A recorder that hangs fills
the queue; what then does not fit is counted, and the loop never notices. A cycle that nobody heard the one before of is
published with what it started from, so that a replay can begin there. A shell: it decides nothing.
"""

import threading
from collections import deque
from typing import NamedTuple, Protocol

import msgspec

from vehicle_gateway.replay import START_EVERY, Start, told
from vehicle_gateway.state import GatewayLimits, Inputs, Outputs, State
from wire.messages.base import Message, encode
from wire.messages.vehicle import GatewayCycle, VehicleDescription
from wire.pace import raise_priority

WAITING_MAX = 2500  # cycles: ten seconds at 250 Hz


class JournalLink(Protocol):
    """What the journal needs of wire.link.Link."""

    def is_heard(self, name: str) -> bool: ...
    def publish(self, name: str, message: Message) -> None: ...


class Entry(NamedTuple):
    number: int
    now_ns: int
    before: State
    inputs: Inputs
    after: State
    outputs: Outputs
    can_sent_ns: int


class Journal:
    """A context manager; leaving it publishes what still waits, for at most a second."""

    def __init__(self, link: JournalLink, vehicle: VehicleDescription, limits: GatewayLimits, fifo_priority: int = 0) -> None:
        """fifo_priority: of its thread. It takes the interpreter's lock, for which the loop of the gateway would wait."""
        self._link, self._vehicle, self._limits = link, vehicle, limits
        self._fifo_priority = fifo_priority
        self._heard = 0  # number of the last cycle that somebody heard
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
        raise_priority(self._fifo_priority)
        while not self._stop or self._waiting:
            self._news.wait()
            self._news.clear()
            while self._waiting:
                self._publish(self._waiting.popleft())

    def _publish(self, entry: Entry) -> None:
        heard = self._link.is_heard("gateway_cycle")
        begins = heard and (self._heard != entry.number - 1 or entry.number % START_EVERY == 0)
        start = Start(state=entry.before, vehicle=self._vehicle, limits=self._limits) if begins or entry.number == 1 else None
        self._link.publish("gateway_cycle", cycle_of(entry, start))
        self._heard = entry.number if heard else 0


def cycle_of(entry: Entry, start: Start | None) -> GatewayCycle:
    """The message of one cycle; `start` where a replay may begin."""
    said = told(entry.after, entry.inputs, entry.outputs)
    return GatewayCycle(
        number=entry.number,
        now_ns=entry.now_ns,
        inputs=msgspec.Raw(encode(entry.inputs)),
        outputs=msgspec.Raw(encode(entry.outputs)),
        can_sent_ns=entry.can_sent_ns,
        command_sequence=said.command_sequence,
        new_command=said.new_command,
        loop_age_ms=said.loop_age_ms,
        mode=said.mode,
        rules=said.rules,
        start=msgspec.Raw(b"null" if start is None else encode(start)),
    )
