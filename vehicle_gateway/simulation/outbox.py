"""Publishing for a loop that must never wait: messages go through a bounded queue to a thread that owns the link.

The world goes on whether there is a hub or not: while it is away what does not fit falls out, oldest first, counted.
A shell: it decides nothing.
"""

import threading
from collections import Counter, deque

from wire.clock import Clock
from wire.link import Stopped, open_link
from wire.messages.base import Message
from wire.pace import raise_priority
from wire.settings import LinkSettings
from wire.topics import Role
from wire.transport import session_configuration

_WAITING_MAX = 256  # messages; about one second of everything the simulated car says
_JOIN_S = 1.5  # longer than one attempt of the link to reach its hub; the thread ends with the process anyway


class Outbox:
    """Context manager. `put` never blocks and never raises."""

    def __init__(self, settings: LinkSettings, role: Role, clock: Clock, fifo_priority: int = 0) -> None:
        """Raises LinkError when the certificates are missing.

        fifo_priority  of its thread, which takes the interpreter's lock while it encodes: the loop would wait for it; and of the
                       link's own: behind everybody's pictures they would keep what the car senses
        """
        session_configuration(settings, role, hub=False)
        self._settings, self._role, self._clock = settings, role, clock
        self._fifo_priority = fifo_priority
        self._waiting: deque[tuple[str, Message]] = deque(maxlen=_WAITING_MAX)
        self._news = threading.Event()
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._publish, name="outbox", daemon=True)
        self.dropped: Counter[str] = Counter()

    def put(self, name: str, message: Message) -> None:
        if len(self._waiting) >= _WAITING_MAX:
            self.dropped["link away"] += 1
        self._waiting.append((name, message))
        self._news.set()

    def _publish(self) -> None:
        raise_priority(self._fifo_priority)
        try:
            opening = open_link(self._settings, self._role, self._clock, self._stop, fifo_priority=self._fifo_priority)
            with opening as link:
                self._waiting.clear()  # what was said before anybody could hear it is stale
                while not self._stop.is_set():
                    self._news.wait()
                    self._news.clear()
                    while self._waiting:
                        link.publish(*self._waiting.popleft())
                    self.dropped["link closed"] = link.dropped["link closed"]
        except Stopped:
            return

    def __enter__(self) -> "Outbox":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._news.set()
        self._thread.join(_JOIN_S)
