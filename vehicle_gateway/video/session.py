"""The video session: one watcher at a time. The window offers, we answer; a new offer replaces the old connection.

The offer and the answer travel over the authenticated link and carry the DTLS fingerprints, so whoever answers the
handshake is who the link says. It decides nothing about pictures: it hands the coded ones to the tracks of the watcher.
"""

import asyncio
import logging
from collections.abc import Mapping
from concurrent.futures import TimeoutError as FutureTimeoutError

from aiortc import RTCPeerConnection, RTCSessionDescription

from vehicle_gateway.video.track import Feedback, PacketTrack, send_on
from wire.ice import DIRECT, Ways
from wire.messages.session import VideoAnswer, VideoOffer
from wire.picture import EncodedPicture
from wire.rtc import UNREADABLE, gather_in_time, new_connection

log = logging.getLogger(__name__)
_ANSWER_TIMEOUT_S = 1.5  # gathering takes some 20 ms; the window waits 2 s


class OfferRefused(Exception):
    """The offer cannot be answered; the text is the rule for the asker."""


class VideoSessions:
    """answer() and show() from any thread; everything else happens on `loop`."""

    def __init__(self, loop: asyncio.AbstractEventLoop, feedback: Mapping[str, Feedback], ways: Ways = DIRECT) -> None:
        self._loop = loop
        self._feedback = feedback
        self._ways = ways
        self._one_at_a_time = asyncio.Lock()
        self._connection: RTCPeerConnection | None = None
        self._tracks: dict[str, PacketTrack] = {}
        self._closing: set[asyncio.Task[None]] = set()

    @property
    def watching(self) -> int:
        """Connected watchers: 0 or 1."""
        connection = self._connection
        return int(connection is not None and connection.connectionState == "connected")

    @property
    def dropped(self) -> int:
        """Pictures that the present watcher did not get: before its first IDR, or because sending could not keep up."""
        return sum(track.backlog.dropped for track in self._tracks.values())

    def show(self, picture: EncodedPicture, now_ns: int) -> None:
        """Hand a coded picture to the watcher, if there is one."""
        track = self._tracks.get(picture.camera)
        if track is not None:
            track.put(picture, now_ns)

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
            unknown = [camera for camera in offer.cameras if camera not in self._feedback]
            if unknown or not offer.cameras:
                raise OfferRefused(f"unknown cameras {unknown}; this car has {', '.join(self._feedback)}")
            connection = new_connection(self._ways)
            try:
                tracks = await self._negotiate(connection, offer)
            except BaseException:
                await connection.close()
                raise
            self._replace(connection, tracks)
            return str(connection.localDescription.sdp)

    async def _negotiate(self, connection: RTCPeerConnection, offer: VideoOffer) -> dict[str, PacketTrack]:
        await connection.setRemoteDescription(RTCSessionDescription(offer.sdp, "offer"))
        transceivers = connection.getTransceivers()
        if [transceiver.kind for transceiver in transceivers] != ["video"] * len(offer.cameras):
            raise OfferRefused(f"{len(transceivers)} media sections for {len(offer.cameras)} cameras")
        tracks = {}
        for transceiver, camera in zip(transceivers, offer.cameras, strict=True):
            tracks[camera] = PacketTrack(self._loop, self._feedback[camera].request_idr)
            send_on(transceiver, tracks[camera], self._feedback[camera])
        gather_in_time(connection, self._ways.relay_only)
        await connection.setLocalDescription(await connection.createAnswer())
        return tracks

    def _replace(self, connection: RTCPeerConnection, tracks: dict[str, PacketTrack]) -> None:
        """The new watcher is served at once; the old connection closes in its own time."""
        old, self._connection, self._tracks = self._connection, connection, tracks
        for camera in tracks:
            self._feedback[camera].note_session(watched=True)
        connection.on("connectionstatechange", lambda: self._state_changed(connection))
        if old is not None:
            log.info("video: a new session replaces the old one")
            self._close_later(old)

    def _state_changed(self, connection: RTCPeerConnection) -> None:
        if connection is self._connection and connection.connectionState in ("failed", "closed"):
            log.info("video: the watcher is gone (%s)", connection.connectionState)
            for camera in self._tracks:
                self._feedback[camera].note_session(watched=False)
            self._connection, self._tracks = None, {}
            self._close_later(connection)

    def _close_later(self, connection: RTCPeerConnection) -> None:
        task = self._loop.create_task(connection.close())
        self._closing.add(task)
        task.add_done_callback(self._closing.discard)

    def close(self) -> None:
        """End the session. From any thread but the loop's."""
        asyncio.run_coroutine_threadsafe(self._close(), self._loop).result(timeout=5.0)

    async def _close(self) -> None:
        connection, self._connection, self._tracks = self._connection, None, {}
        if connection is not None:
            await connection.close()
        await asyncio.gather(*self._closing)
