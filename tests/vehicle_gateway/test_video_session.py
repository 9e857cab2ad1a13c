"""Who watches the car at once: real connections on loopback, each window on a loop of its own that can end as if it was killed."""

import asyncio
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
from aiortc import RTCPeerConnection

from tests.messages import gateway_status
from tests.tower.filmed_car import camera
from tower.video.connection import receiving_connection, take_answer
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.picture import from_bgr
from vehicle_gateway.video.sender import Wishes
from vehicle_gateway.video.session import WATCHERS_MAX, VideoSessions, Watcher
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.ice import DIRECT
from wire.loop_thread import loop_in_thread
from wire.messages.session import VideoOffer
from wire.messages.vehicle import Succession
from wire.picture import EncodedPicture

CAMERAS = ("front", "left")
WAIT_S = 30.0


class Told:
    """What one camera is told of its watchers, and a wait for it."""

    def __init__(self) -> None:
        self.watching: set[str] = set()
        self.reports: list[str] = []
        self.leaders: list[str] = []
        self._news = threading.Condition()

    def request_idr(self) -> None:
        """Every picture here is one."""

    def note_session(self, watcher: str, watched: bool) -> None:
        with self._news:
            self.watching = self.watching | {watcher} if watched else self.watching - {watcher}
            self._news.notify_all()

    def note_leader(self, watcher: str) -> None:
        with self._news:
            self.leaders.append(watcher)
            self._news.notify_all()

    def note_estimate(self, watcher: str, estimate_bps: float) -> None:
        """The loss is enough to know who reports."""

    def note_loss(self, watcher: str, lost: float) -> None:
        with self._news:
            self.reports.append(watcher)
            self._news.notify_all()

    def wait_until(self, happened: Callable[[], bool]) -> None:
        with self._news:
            assert self._news.wait_for(happened, WAIT_S), f"watching {self.watching}, reports of {self.reports}"


class Window:
    """One connection of a window's, connected; afterwards on a thread of its own."""

    def __init__(self, sessions: VideoSessions, name: str) -> None:
        self.loop = asyncio.new_event_loop()
        self.closed = threading.Event()
        self.connection = self.loop.run_until_complete(self._connect(sessions, name))
        self._thread = threading.Thread(target=self.loop.run_forever, name=name)
        self._thread.start()

    async def _connect(self, sessions: VideoSessions, name: str) -> RTCPeerConnection:
        connection = await receiving_connection(len(CAMERAS), DIRECT)
        changed = asyncio.Event()

        def change() -> None:
            changed.set()
            if connection.connectionState == "closed":
                self.closed.set()

        connection.on("connectionstatechange", change)
        offer = VideoOffer(sdp=connection.localDescription.sdp, cameras=CAMERAS, watcher=name, operator=name)
        answer = await asyncio.to_thread(sessions.answer, offer)
        while "ask again" in answer.rule:  # on a busy machine; a window does the same
            answer = await asyncio.to_thread(sessions.answer, offer)
        assert not answer.rule and not await take_answer(connection, answer.sdp)
        while connection.connectionState != "connected":
            changed.clear()
            await asyncio.wait_for(changed.wait(), WAIT_S)
        return connection

    def kill(self) -> None:
        """From now on it sends nothing, no goodbye either."""
        self.loop.call_soon_threadsafe(self.loop.stop)
        self._thread.join()

    def __enter__(self) -> "Window":
        return self

    def __exit__(self, *_: object) -> None:
        if self._thread.is_alive():
            self.kill()
        self.loop.run_until_complete(self.connection.close())
        self.loop.close()


@contextmanager
def filming() -> Iterator[tuple[VideoSessions, Told, Told]]:
    """A car that sends the same key picture ten times a second: a receiver reports only on what it receives."""
    told, halt = {name: Told() for name in CAMERAS}, threading.Event()
    annex_b = Encoder(camera("front"), VideoSettings()).encode(from_bgr(np.full((180, 320, 3), 90, np.uint8)), 0).annex_b
    pictures = [EncodedPicture(camera=name, capture_ns=1, sequence=1, is_idr=True, annex_b=annex_b) for name in CAMERAS]

    def film(sessions: VideoSessions) -> None:
        while not halt.wait(0.1):
            for picture in pictures:
                sessions.show(picture, Clock().now_ns())

    with loop_in_thread("car") as loop:
        sessions = VideoSessions(loop, told)
        thread = threading.Thread(target=film, args=(sessions,))
        thread.start()
        try:
            yield sessions, *told.values()
        finally:
            halt.set()
            thread.join()
            sessions.close()


def rule(sessions: VideoSessions, name: str) -> str:
    """Why an offer is refused, "" when it is answered. The window then dies before it connects."""

    async def offered() -> str:
        connection = await receiving_connection(1, DIRECT)
        try:
            return str(connection.localDescription.sdp)
        finally:
            await connection.close()

    offer = VideoOffer(sdp=asyncio.run(offered()), cameras=("front",), watcher=name, operator=name)
    while "ask again" in (refused := sessions.answer(offer).rule):  # on a busy machine
        pass
    return refused


def test_one_window_too_many_is_refused_with_what_to_do_and_comes_in_when_another_closes():
    with filming() as (sessions, front, _), Window(sessions, "ann"):
        with Window(sessions, "ben"):
            front.wait_until(lambda: {"ann", "ben"} <= set(front.reports))
            assert sessions.watching == WATCHERS_MAX == 2
            assert rule(sessions, "cem") == "offer refused: 2 windows watch this car already; close one, and its place is free"
            assert sessions.watching == 2
        front.wait_until(lambda: front.watching == {"ann"})
        assert rule(sessions, "cem") == ""


def test_a_window_s_new_offer_replaces_its_own_connection_and_no_other():
    with (
        filming() as (sessions, front, _),
        Window(sessions, "ann") as before,
        Window(sessions, "ben") as other,
        Window(sessions, "ann"),
    ):
        assert before.closed.wait(WAIT_S)
        reports = len(front.reports)
        front.wait_until(lambda: {"ann", "ben"} <= set(front.reports[reports:]))
        assert (sessions.watching, other.closed.is_set()) == (2, False)
        assert front.watching == {"ann", "ben"}


def test_of_a_killed_window_the_place_comes_free_and_who_is_heard_keeps_his_whoever_asks():
    with filming() as (sessions, front, _), Window(sessions, "ann") as killed, Window(sessions, "ben") as living:
        front.wait_until(lambda: {"ann", "ben"} <= set(front.reports))
        killed.kill()
        assert "close one" in rule(sessions, "cem")
        front.wait_until(lambda: "ann" not in front.watching)
        assert rule(sessions, "cem") == ""
        assert "close one" in rule(sessions, "dan")
        front.wait_until(lambda: "cem" not in front.watching)  # it never connected
        assert front.watching == {"ben"}
        assert (sessions.watching, living.closed.is_set()) == (1, False)


def test_a_window_that_has_just_connected_counts_as_heard():
    with filming() as (sessions, _, _):
        watcher = Watcher("ann", SimpleNamespace(connectionState="connecting"))
        sessions._state_changed(watcher)
        assert watcher.heard_s == 0.0
        watcher.connection.connectionState = "connected"
        sessions._state_changed(watcher)
        assert watcher.heard_s > 0.0


def test_a_camera_that_a_window_no_longer_asks_for_is_told_so():
    with filming() as (sessions, front, left), Window(sessions, "ann"):
        assert front.watching == left.watching == {"ann"}
        rule(sessions, "ann")  # asks for the front camera alone
        assert (front.watching, left.watching) == ({"ann"}, set())


def test_the_window_of_whoever_holds_the_lease_leads_from_then_on_and_when_it_connects_anew():
    with filming() as (sessions, front, left), Window(sessions, "ann"):
        sessions.follow(("ann",))
        front.wait_until(lambda: front.leaders == ["ann"])
        with Window(sessions, "ben"):
            sessions.follow(("ben",))
            front.wait_until(lambda: front.leaders[-1] == "ben")
            rule(sessions, "ben")
        front.wait_until(lambda: "ben" not in front.watching)
        told = len(front.leaders)
        sessions.follow(())
        sessions.follow(("ann",))
        front.wait_until(lambda: front.leaders[told:] == ["ann"])
        assert set(left.leaders) == {"ann", "ben"}


def test_who_drives_or_is_next_takes_the_place_of_one_who_only_looks_on_and_of_nobody_else():
    with filming() as (sessions, front, _), Window(sessions, "cem"), Window(sessions, "ann") as hers:
        sessions.follow(("ann", "ben"))
        front.wait_until(lambda: bool(front.leaders))
        assert "close one" in rule(sessions, "dan")
        assert rule(sessions, "ben") == ""
        assert front.watching == {"ann", "ben"} and not hers.closed.is_set()
        assert "close one" in rule(sessions, "cem"), "both are wanted more than he is"


def test_the_cameras_hear_who_holds_the_lease_and_who_is_next_whenever_that_changes():
    heard, wanted = {}, []
    Wishes(SimpleNamespace(on=heard.__setitem__), wanted.append)
    for holder, named in (("ann", ""), ("ann", ""), ("ann", "ben"), ("ben", ""), ("", "")):
        heard["gateway_status"](gateway_status(lease_holder=holder, succession=Succession(operator=named)), 0)
    assert wanted == [("ann",), ("ann", "ben"), ("ben",), ()]
