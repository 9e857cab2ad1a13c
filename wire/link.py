"""The Zenoh link: QUIC with mixed reliability and mutual TLS, the only mode, also on loopback.

A thin shell over one Zenoh session. Callbacks run on library threads and only decode, check and put; what fails is dropped
and counted by reason. Nothing here decides anything. Facts and measurements behind the settings: ARCHITECTURE.md, "The link".
"""

import sys
import threading
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import partial
from typing import Any

import zenoh

from wire import farewell
from wire.clock import Clock
from wire.endpoint import Endpoint
from wire.failures import LinkError as LinkError
from wire.failures import Stopped as Stopped
from wire.latest import EventQueue, Latest
from wire.link_threads import Known, receive_on_one_thread, threads_with
from wire.messages.base import UNDECODABLE, Message, decoder, encode
from wire.order import Newest, has_room, is_old, is_ordered, stream_of
from wire.reach import told_why
from wire.settings import LinkSettings
from wire.site import dialled, listened, own_hub, site_of
from wire.topics import QUERIES, TOPICS, Kind, Role, Travel, key
from wire.transport import session_configuration, tls_of, warn_of_unnamed

_TRIES_BEFORE_TOLD = 5  # of about a second each
_MESSAGE_MAX_BYTES = 1_000_000  # ours: ten times the largest message seen (one IDR picture)
_KNOWN = Known()

_TRAVEL: dict[Travel, tuple[zenoh.Priority, zenoh.Reliability, zenoh.CongestionControl]] = {
    Travel.COMMAND: (zenoh.Priority.REAL_TIME, zenoh.Reliability.BEST_EFFORT, zenoh.CongestionControl.DROP),
    Travel.STATE: (zenoh.Priority.INTERACTIVE_HIGH, zenoh.Reliability.BEST_EFFORT, zenoh.CongestionControl.DROP),
    Travel.EVENT: (zenoh.Priority.INTERACTIVE_LOW, zenoh.Reliability.RELIABLE, zenoh.CongestionControl.BLOCK),
    Travel.RECORD: (zenoh.Priority.DATA_LOW, zenoh.Reliability.RELIABLE, zenoh.CongestionControl.BLOCK),
    Travel.BULK: (zenoh.Priority.DATA, zenoh.Reliability.RELIABLE, zenoh.CongestionControl.DROP),
}


@contextmanager
def open_link(
    settings: LinkSettings,
    role: Role,
    clock: Clock,
    stop: threading.Event,
    *,
    hub: bool = False,
    waits: bool = True,
    fifo_priority: int = 0,
) -> Iterator["Link"]:
    """The link of one process; leaving the context closes it.

    A client waits for its hub until `stop` is set (raises Stopped). A hub raises LinkError at once when its port is taken.
    waits  whether a hub can be joined by others; one that only looks at other sites need not take a port
    fifo_priority  of the library's threads, where the system allows it (wire.link_threads); 0: as everybody else
    """
    configuration = session_configuration(settings, role, hub, waits)
    site = site_of(role)
    places = dialled(settings, site) if hub else ()
    with threads_with(fifo_priority):
        session = _open_hub(configuration, settings, site) if hub else _open_client(configuration, stop, own_hub(settings, site))
    if hub and waits:
        warn_of_unnamed(settings, role)
    link = Link(session, settings.vehicle_id, role, clock)
    try:
        with told_why(tls_of(settings, role), places, lambda: link.sites, fifo_priority=fifo_priority):
            yield link
    finally:
        farewell.say(partial(_say_goodbye, session))


def _say_goodbye(session: zenoh.Session) -> None:
    with suppress(zenoh.ZError):  # nobody answered: they will notice by their own leases
        session.close()  # type: ignore[no-untyped-call]


def _open_hub(configuration: zenoh.Config, settings: LinkSettings, site: str) -> zenoh.Session:
    try:
        return zenoh.open(configuration)
    except zenoh.ZError as error:
        places = " and ".join(str(each) for each in listened(settings, site))
        raise LinkError(
            f"cannot listen on {places}: {str(error).partition(' at /')[0]}; is another drive running, and is the address this "
            f"machine's? choose a free one with [wire.link] {site}_hub or listen"
        ) from None


def _open_client(configuration: zenoh.Config, stop: threading.Event, hub: Endpoint) -> zenoh.Session:
    receive_on_one_thread()
    tries = 0
    while not stop.is_set():
        try:
            return zenoh.open(configuration)
        except zenoh.ZError:
            tries += 1
            if tries == _TRIES_BEFORE_TOLD:
                print(
                    f"still waiting for the hub at {hub}; is it running, and with certificates of the same authority?",
                    file=sys.stderr,
                )
            stop.wait(0.1)  # the hub is not there yet
    raise Stopped("asked to stop while waiting for the hub")


class Link:
    """One process's view of the link. Publishing never blocks for a level; `dropped` counts what was refused, by reason."""

    def __init__(self, session: zenoh.Session, vehicle_id: str, role: Role, clock: Clock) -> None:
        self._session = session
        self._vehicle_id = vehicle_id
        self._role = role
        self._clock = clock
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._kept: list[Any] = []  # Zenoh undeclares what is no longer referenced
        self.dropped: Counter[str] = Counter()

    def of(self, vehicle_id: str) -> "Link":
        """The same session's view of another vehicle; access control decides what of it may be seen."""
        return Link(self._session, vehicle_id, self._role, self._clock)

    @property
    def sites(self) -> int:
        """How many hubs of other sites are joined to this one now."""
        return len(self._session.info.routers_zid())

    def publish(self, name: str, message: Message | bytes) -> None:
        """Send on a topic of the table. Raises KeyError for a topic that is not in it."""
        publisher = self._publishers.get(name) or self._declare(name)
        try:
            publisher.put(message if isinstance(message, bytes) else encode(message))
        except zenoh.ZError:
            self.dropped["link closed"] += 1

    def is_heard(self, name: str) -> bool:
        """Whether anybody is subscribed to what we publish on a topic. Asks no one: the answer is in our own tables."""
        publisher = self._publishers.get(name) or self._declare(name)
        status: Any = publisher.matching_status  # against its own declaration
        return bool(status.matching)

    def _declare(self, name: str) -> zenoh.Publisher:
        priority, reliability, congestion = _TRAVEL[TOPICS[name].travel]
        publisher = self._session.declare_publisher(
            key(self._vehicle_id, name),
            priority=priority,
            reliability=reliability,
            congestion_control=congestion,
            express=True,
        )
        self._publishers[name] = publisher
        return publisher

    def level(self, name: str) -> Latest[Any]:
        """The newest message of a level topic, always; what is repeated or out of order is dropped and counted."""
        if TOPICS[name].kind is not Kind.LEVEL:
            raise ValueError(f"{name} is an event topic: every one counts, use events()")
        slot: Latest[Any] = Latest()
        self.on(name, self._only_newer(name, slot.put))
        return slot

    def events(self, name: str, limit: int = 1024) -> EventQueue[Any]:
        """Every message of a topic, in order, bounded and counted."""
        queue: EventQueue[Any] = EventQueue(limit)
        self.on(name, self._only_newer(name, queue.put) if TOPICS[name].kind is Kind.LEVEL else queue.put)
        return queue

    def _only_newer(self, name: str, callback: Callable[[Any, int], None]) -> Callable[[Any, int], None]:
        """`callback` without what is repeated or out of order, where the topic's messages can be ordered."""
        message_type, newest = TOPICS[name].type, dict[str, Newest]()
        if message_type is None or not is_ordered(message_type):
            return callback

        def receive(message: Any, received_ns: int) -> None:
            stream = stream_of(message)
            if not has_room(stream, newest):
                self.dropped[f"{name} unknown source"] += 1
                return
            if is_old(message.stamp_ns, received_ns, newest.get(stream)):
                self.dropped[f"{name} out of order"] += 1
                return
            newest[stream] = Newest(message.stamp_ns, received_ns)
            callback(message, received_ns)

        return receive

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None:
        """callback(message, received_ns) on a library thread for everything valid that arrives."""
        message_type = TOPICS[name].type
        if message_type is None:
            raise ValueError(f"{name} carries bytes: use on_raw()")
        decode = decoder(message_type).decode

        def receive(_: str, payload: bytes, received_ns: int) -> None:
            try:
                message = decode(payload)
            except UNDECODABLE:
                self.dropped[f"{name} undecodable"] += 1
                return
            callback(message, received_ns)

        self.on_raw(name, receive)

    def on_raw(self, name: str, callback: Callable[[str, bytes, int], None]) -> None:
        """callback(topic name, payload, received_ns) on a library thread, nothing decoded."""

        def receive(sample: zenoh.Sample) -> None:
            received_ns = self._clock.now_ns()
            _ = _KNOWN.here
            payload = sample.payload
            if len(payload) > _MESSAGE_MAX_BYTES:
                self.dropped[f"{name} too large"] += 1
                return
            callback(name, bytes(payload), received_ns)

        self._kept.append(
            self._session.declare_subscriber(key(self._vehicle_id, name), zenoh.handlers.Callback(receive, indirect=False))
        )

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None:
        """The reply to a query, or None when nobody answered in time. Blocks: never in a control loop."""
        query = QUERIES[name]
        try:
            priority, _, congestion = _TRAVEL[Travel.STATE]  # the answer travels as the question does: nobody waits to give it
            answers = self._session.get(
                key(self._vehicle_id, name),
                payload=encode(request),
                timeout=timeout_s,
                priority=priority,
                congestion_control=congestion,
                express=True,
            )
            for answer in answers:
                if answer.ok is not None:
                    return decoder(query.reply).decode(bytes(answer.ok.payload))
        except zenoh.ZError:
            self.dropped["link closed"] += 1
        except UNDECODABLE:
            self.dropped[f"{name} reply undecodable"] += 1
        return None

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None:
        """Answer a query; handler(request) -> reply runs on a thread of its own. An undecodable request gets no answer."""

        def answer(request: Any, reply: Callable[[Message], None]) -> None:
            threading.Thread(target=lambda: reply(handler(request)), name=f"answer {name}", daemon=True).start()

        self.serve_later(name, answer)

    def serve_later(self, name: str, handler: Callable[[Any, Callable[[Message], None]], None]) -> None:
        """Like `serve`, but handler(request, reply) returns at once and reply(message) is called later, on any thread.

        A library thread that waited for the answer would hold up everything else that arrives over the same link.
        """
        expression, decode = key(self._vehicle_id, name), decoder(QUERIES[name].request).decode

        def receive(query: zenoh.Query) -> None:
            try:
                request = decode(bytes(query.payload) if query.payload is not None else b"")
            except UNDECODABLE:
                self.dropped[f"{name} undecodable"] += 1
                query.drop()  # type: ignore[no-untyped-call]
                return

            def reply(message: Message) -> None:
                with query, suppress(zenoh.ZError):  # whoever asked is gone
                    query.reply(expression, encode(message))

            handler(request, reply)

        self._kept.append(self._session.declare_queryable(expression, zenoh.handlers.Callback(receive, indirect=False)))
