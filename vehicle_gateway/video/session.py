"""The video sessions: a few watchers at a time. A window offers, we answer; its new offer replaces its own old connection.

The offer and the answer travel over the authenticated link and carry the DTLS fingerprints, so whoever answers the
handshake is who the link says. It decides nothing about pictures: it hands the coded ones to the tracks of every watcher.
A place comes free when its watcher goes or falls silent; who drives or is next takes that of one who only looks on.
"""

import asyncio
import logging
from collections.abc import Iterable, Mapping
from concurrent.futures import TimeoutError as FutureTimeoutError
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial

from aiortc import RTCPeerConnection, RTCSessionDescription

from vehicle_gateway.video.track import Feedback, PacketTrack, send_on
from wire.ice import DIRECT, Ways
from wire.messages.session import VideoAnswer, VideoOffer
from wire.picture import EncodedPicture
from wire.rtc import UNREADABLE, gather_in_time, new_connection

log = logging.getLogger(__name__)
_ANSWER_TIMEOUT_S = 1.5  # gathering takes some 20 ms; the window waits 2 s
WATCHERS_MAX = 2  # who drives and who is next; each more would take as much of the car's way out again, from the driver
_SILENT_S = 3.0  # a living receiver reports every 0.5 to 1.5 s for each camera, and asks anew after 1.5 s without a picture


class OfferRefused(Exception):
    """The offer cannot be answered; the text is the rule for the asker."""


@dataclass(slots=True, eq=False)
class Watcher:
    """One window's place: its connection, and when it was heard last (the loop's time)."""

    name: str
    connection: RTCPeerConnection
    operator: str = ""  # who sits before it
    heard_s: float = 0.0
    tracks: dict[str, PacketTrack] = field(default_factory=dict)


class VideoSessions:
    """answer() and show() from any thread; everything else happens on `loop`."""

    def __init__(self, loop: asyncio.AbstractEventLoop, feedback: Mapping[str, Feedback], ways: Ways = DIRECT) -> None:
        self._loop = loop
        self._feedback = feedback
        self._ways = ways
        self._one_at_a_time = asyncio.Lock()
        self._watchers: Mapping[str, Watcher] = {}  # never changed, only replaced: cameras' threads read it
        self._wanted: tuple[str, ...] = ()  # who holds the lease, and who is next
        self._closing: set[asyncio.Task[None]] = set()

    @property
    def watching(self) -> int:
        """Connected watchers."""
        return sum(watcher.connection.connectionState == "connected" for watcher in self._watchers.values())

    @property
    def dropped(self) -> int:
        """Pictures that the present watchers did not get: before their first IDR, or because sending could not keep up."""
        return sum(track.backlog.dropped for watcher in self._watchers.values() for track in watcher.tracks.values())

    def show(self, picture: EncodedPicture, now_ns: int) -> None:
        """Hand a coded picture to every watcher of its camera."""
        for watcher in self._watchers.values():
            track = watcher.tracks.get(picture.camera)
            if track is not None:
                track.put(picture, now_ns)

    def follow(self, wanted: tuple[str, ...]) -> None:
        """Who holds the lease of the car now, and who is next: the first one's path decides what the pictures may use."""
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._follow, wanted)

    def answer(self, offer: VideoOffer) -> VideoAnswer:
        """The answer to an offer, or the rule that refuses it. Blocks for some 20 ms; not on the loop's own thread."""
        answering = self._answer(offer)
        try:
            future = asyncio.run_coroutine_threadsafe(answering, self._loop)
        except RuntimeError:  # the loop is closed
            answering.close()
            return VideoAnswer(sdp="", cameras=(), rule="the car's cameras are ending; ask again")
        try:
            return VideoAnswer(sdp=future.result(_ANSWER_TIMEOUT_S), cameras=offer.cameras, rule="")
        except (OfferRefused, *UNREADABLE) as error:
            return VideoAnswer(sdp="", cameras=(), rule=f"offer refused: {error or type(error).__name__}"[:2000])
        except FutureTimeoutError:
            future.cancel()
            return VideoAnswer(sdp="", cameras=(), rule=f"no answer within {_ANSWER_TIMEOUT_S} s; ask again")

    async def _answer(self, offer: VideoOffer) -> str:
        async with self._one_at_a_time:
            self._refuse(offer)
            watcher = Watcher(offer.watcher, new_connection(self._ways), offer.operator)
            try:
                await self._negotiate(watcher, offer)
            except BaseException:
                await watcher.connection.close()
                raise
            self._serve(watcher, self._looker_on(offer))
            return str(watcher.connection.localDescription.sdp)

    def _refuse(self, offer: VideoOffer) -> None:
        unknown = [camera for camera in offer.cameras if camera not in self._feedback]
        if unknown or not offer.cameras:
            raise OfferRefused(f"unknown cameras {unknown}; this car has {', '.join(self._feedback)}")
        if offer.watcher not in self._watchers and len(self._watchers) >= WATCHERS_MAX and self._looker_on(offer) is None:
            raise OfferRefused(f"{WATCHERS_MAX} windows watch this car already; close one, and its place is free")

    def _looker_on(self, offer: VideoOffer) -> Watcher | None:
        """Whose place somebody takes who drives, or is next: that of one who is neither."""
        if offer.operator not in self._wanted or offer.watcher in self._watchers or len(self._watchers) < WATCHERS_MAX:
            return None
        return next((one for one in self._watchers.values() if one.operator not in self._wanted), None)

    async def _negotiate(self, watcher: Watcher, offer: VideoOffer) -> None:
        connection = watcher.connection
        await connection.setRemoteDescription(RTCSessionDescription(offer.sdp, "offer"))
        transceivers = connection.getTransceivers()
        if [transceiver.kind for transceiver in transceivers] != ["video"] * len(offer.cameras):
            raise OfferRefused(f"{len(transceivers)} media sections for {len(offer.cameras)} cameras")
        for transceiver, camera in zip(transceivers, offer.cameras, strict=True):
            watcher.tracks[camera] = PacketTrack(self._loop, self._feedback[camera].request_idr)
            send_on(transceiver, watcher.tracks[camera], self._feedback[camera], watcher.name, partial(self._heard, watcher))
        gather_in_time(connection, self._ways.relay_only)
        await connection.setLocalDescription(await connection.createAnswer())

    def _heard(self, watcher: Watcher) -> None:
        watcher.heard_s = self._loop.time()

    def _serve(self, watcher: Watcher, displaced: Watcher | None) -> None:
        """The new connection is served at once; the watcher's old one closes in its own time."""
        old = self._watchers.get(watcher.name)
        if displaced is not None:
            self._end(displaced, "its place is wanted by who drives or is next")
        self._watchers = {**self._watchers, watcher.name: watcher}
        if old is not None:
            log.info("video: a new session of a watcher replaces its old one")
            self._leave(watcher.name, old.tracks.keys() - watcher.tracks.keys())
            self._close_later(old.connection)
        for camera in watcher.tracks:
            self._feedback[camera].note_session(watcher.name, watched=True)
        watcher.connection.on("connectionstatechange", partial(self._state_changed, watcher))
        self._lead()
        self._heard(watcher)
        self._look(watcher)

    def _follow(self, wanted: tuple[str, ...]) -> None:
        self._wanted = wanted
        self._lead()

    def _lead(self) -> None:
        """The window of whoever drives leads; while there is none, whoever has watched longest."""
        driver = next((one for one in self._watchers.values() if one.operator in self._wanted[:1]), None)
        if driver is not None:
            for camera in driver.tracks:
                self._feedback[camera].note_leader(driver.name)

    def _state_changed(self, watcher: Watcher) -> None:
        state = watcher.connection.connectionState
        if state in ("failed", "closed"):
            self._end(watcher, state)
        elif state == "connected":
            self._heard(watcher)  # its answers to ICE and DTLS; the first report comes a while after them

    def _look(self, watcher: Watcher) -> None:
        """Now, and again whenever it could have become too silent: aioice itself notices a killed window after 30 s only."""
        left_s = watcher.heard_s + _SILENT_S - self._loop.time()
        if left_s <= 0:
            self._end(watcher, f"not heard for {_SILENT_S:g} s")
        elif self._watchers.get(watcher.name) is watcher:
            self._loop.call_later(left_s, self._look, watcher)

    def _end(self, watcher: Watcher, why: str) -> None:
        if self._watchers.get(watcher.name) is watcher:
            log.info("video: a watcher is gone (%s)", why)
            self._watchers = {name: other for name, other in self._watchers.items() if other is not watcher}
            self._leave(watcher.name, watcher.tracks.keys())
            self._close_later(watcher.connection)

    def _leave(self, name: str, cameras: Iterable[str]) -> None:
        for camera in cameras:
            self._feedback[camera].note_session(name, watched=False)

    def _close_later(self, connection: RTCPeerConnection) -> None:
        task = self._loop.create_task(connection.close())
        self._closing.add(task)
        task.add_done_callback(self._closing.discard)

    def close(self) -> None:
        """End all sessions. From any thread but the loop's."""
        asyncio.run_coroutine_threadsafe(self._close(), self._loop).result(timeout=5.0)

    async def _close(self) -> None:
        watchers, self._watchers = self._watchers, {}
        await asyncio.gather(*(watcher.connection.close() for watcher in watchers.values()), *self._closing)
