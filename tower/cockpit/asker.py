"""One thread that asks the car: a question at a time, its answer into a queue. Owns `link.ask`, which blocks; decides nothing."""

import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from wire.clock import Clock
from wire.latest import EventQueue
from wire.messages.base import Message
from wire.messages.session import HandOverReply, LeaseReply

TIMEOUT_S = 0.5  # "no answer" after this


@dataclass(frozen=True, slots=True)
class Answer:
    query: str
    reply: LeaseReply | HandOverReply | None  # None: nobody answered in time


Ask = Callable[[str, Message, float], Message | None]


class Asking(Protocol):
    """What the cockpit's loop needs: put a question, hear later."""

    @property
    def busy(self) -> bool: ...

    @property
    def answers(self) -> EventQueue[Answer]: ...

    def offer(self, query: str, request: Message) -> bool: ...


class Asker:
    """`offer` never blocks: False while the last question is still out."""

    def __init__(self, ask: Ask, clock: Clock) -> None:
        self.answers: EventQueue[Answer] = EventQueue()
        self._ask = ask
        self._clock = clock
        self._slot: tuple[str, Message] | None = None
        self._offered = threading.Event()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="asker", daemon=True)

    def __enter__(self) -> "Asker":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._offered.set()
        self._thread.join(timeout=2 * TIMEOUT_S)

    @property
    def busy(self) -> bool:
        return self._slot is not None

    def offer(self, query: str, request: Message) -> bool:
        if self.busy:
            return False
        self._slot = (query, request)
        self._offered.set()
        return True

    def _run(self) -> None:
        while True:
            self._offered.wait()
            self._offered.clear()
            if self._ended:
                return
            if self._slot is not None:
                query, request = self._slot
                reply = self._ask(query, request, TIMEOUT_S)
                answer = Answer(query, reply if isinstance(reply, LeaseReply | HandOverReply) else None)
                self.answers.put(answer, self._clock.now_ns())
                self._slot = None
