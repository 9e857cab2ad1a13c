"""The newest picture of every camera, for the window: asks the car for a session, receives, decodes, drains.

aiortc lives on one asyncio thread; the window's thread only calls newest(). A session that fails or falls silent is
asked for anew, so a restart of either side heals by itself. It never shows a picture that misses a part, and never
judges a picture's age. Stamps: capture_ns is the vehicle's clock (from inside the picture), decoded_ns the tower's.
"""

import asyncio
import logging
import secrets
import threading
from collections import Counter
from concurrent.futures import Future
from contextlib import ExitStack
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from aiortc import MediaStreamTrack, RTCPeerConnection
from aiortc.mediastreams import MediaStreamError
from av import VideoFrame
from numpy.typing import NDArray

from tower.video.connection import Missing, mend, receiving_connection, take_answer, user_data
from tower.video.continuity import Continuity, follow
from tower.video.convert import Part, to_bgra
from tower.video.reconnect import Session, Step, asked, delivered, next_step
from wire.clock import Clock
from wire.ice import DIRECT, Ways
from wire.loop_thread import loop_in_thread
from wire.messages.base import Message
from wire.messages.session import VideoOffer
from wire.stamp import read_stamp

log = logging.getLogger(__name__)
_LOOK_S = 0.03  # how often the session is looked at, and packets that are still missing are asked for again
_ASK_TIMEOUT_S = 2.0
Readers = list["asyncio.Task[None]"]


class AskingLink(Protocol):
    """What the receiver needs of wire.link.Link."""

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class DecodedFrame:
    camera: str
    capture_ns: int  # vehicle clock, from inside the picture
    sequence: int
    decoded_ns: int  # tower clock
    frame: VideoFrame  # as the decoder gave it: converted only when, and as large as, it is shown

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height as it came."""
        return self.frame.width, self.frame.height

    def pixels(self, part: Part | None, size: tuple[int, int]) -> NDArray[np.uint8]:
        """(H, W, 4) BGRA, contiguous, of a part of the picture (None: all) at that size: for pygame.image.frombuffer."""
        return to_bgra(self.frame, part, size)

    @property
    def image(self) -> NDArray[np.uint8]:
        """The whole picture as it came, (H, W, 4) BGRA, contiguous."""
        return to_bgra(self.frame)


class VideoReceiver:
    """`with VideoReceiver(link, clock, cameras) as video: video.newest("front")` - from the window's thread."""

    def __init__(self, link: AskingLink, clock: Clock, cameras: tuple[str, ...], ways: Ways = DIRECT, operator: str = "") -> None:
        """operator: who sits before the window."""
        self.cameras = cameras
        self.decoded: Counter[str] = Counter()  # pictures, by camera, since start
        self.replaced: Counter[str] = Counter()  # of them, replaced by a newer one before newest() fetched them
        self.withheld: Counter[str] = Counter()  # pictures that missed a part, or carried no stamp
        self.refused = ""  # why the last offer came to nothing; "" when it was answered, or none was made
        self.sessions = 0  # answered by the car, since start
        self._newest_ns: int | None = None  # when the newest picture of any camera was decoded
        self._link, self._clock, self._ways = link, clock, ways
        self._operator = operator
        self._watcher = secrets.token_hex(8)  # the car keeps one place for it, whatever becomes of its connections
        self._slots: dict[str, DecodedFrame] = {}
        self._shown: dict[str, DecodedFrame] = {}
        self._lock = threading.Lock()
        self._halt = threading.Event()
        self._keeper: Future[None] | None = None
        self._stack = ExitStack()

    def __enter__(self) -> "VideoReceiver":
        loop = self._stack.enter_context(loop_in_thread("video-receiver"))
        self._keeper = asyncio.run_coroutine_threadsafe(self._keep_session(), loop)
        return self

    def __exit__(self, *_: object) -> None:
        self._halt.set()
        with self._stack:
            if self._keeper is not None:
                self._keeper.result(timeout=_ASK_TIMEOUT_S + 3.0)  # raises what went wrong on the loop, if anything did

    def watch(self, cameras: tuple[str, ...]) -> None:
        """The cameras wanted from now on; a change asks for a new session, () for none."""
        self.cameras = cameras

    def newest(self, camera: str) -> DecodedFrame | None:
        """The newest whole picture, the same until a newer one comes (compare `sequence`); None before the first."""
        if self._keeper is not None and self._keeper.done():
            self._keeper.result()  # the loop ended: raises why
        with self._lock:
            fresh = self._slots.pop(camera, None)
        if fresh is not None:
            self._shown[camera] = fresh
        return self._shown.get(camera)

    async def _keep_session(self) -> None:
        """Until the end: look at the session, and ask for a new one when the rule says so."""
        state, asked_for = Session(), self.cameras
        connection: RTCPeerConnection | None = None
        readers: Readers = []
        missing: Missing = []
        try:
            while not self._halt.is_set():
                has_failed = connection is not None and connection.connectionState in ("failed", "closed")
                if asked_for != self.cameras:
                    state, asked_for = Session(), self.cameras
                if asked_for and next_step(state, self._clock.now_ns(), self._newest_ns, has_failed) is Step.ASK:
                    await _end(connection, readers)
                    connection, readers = await self._open(asked_for)
                    state = asked(state, self._clock.now_ns(), bool(readers))
                elif self._newest_ns is not None and self._newest_ns > state.opened_ns:
                    state = delivered(state)
                missing = await mend(connection, missing) if connection is not None else []
                await asyncio.sleep(_LOOK_S)
        finally:
            await _end(connection, readers)

    async def _open(self, cameras: tuple[str, ...]) -> tuple[RTCPeerConnection | None, Readers]:
        """Offer, ask, take the answer: (connection, a reader per camera), or (None, []) without an answer."""
        connection = await receiving_connection(len(cameras), self._ways)
        offer = VideoOffer(sdp=connection.localDescription.sdp, cameras=cameras, watcher=self._watcher, operator=self._operator)
        answer = await asyncio.get_running_loop().run_in_executor(None, self._link.ask, "video_session", offer, _ASK_TIMEOUT_S)
        refused = self.refused = (
            "the car did not answer" if answer is None else answer.rule or await take_answer(connection, answer.sdp)
        )
        if refused:
            log.info("no video session: %s", refused)
            await connection.close()
            return None, []
        self.sessions += 1
        tracks = [transceiver.receiver.track for transceiver in connection.getTransceivers()]
        return connection, [asyncio.ensure_future(self._read(camera, track)) for camera, track in zip(cameras, tracks, strict=True)]

    async def _read(self, camera: str, track: MediaStreamTrack) -> None:
        """Every decoded picture of one camera into its slot, until the track ends."""
        state = Continuity()
        try:
            while True:
                frame = await track.recv()
                if isinstance(frame, VideoFrame):
                    state = self._take(camera, frame, state)
        except MediaStreamError:
            log.info("video of %s ended", camera)

    def _take(self, camera: str, frame: VideoFrame, state: Continuity) -> Continuity:
        decoded_ns = self._clock.now_ns()
        stamp = read_stamp(user_data(frame))
        self.decoded[camera] += 1
        self._newest_ns = decoded_ns
        if stamp is None:
            self.withheld[camera] += 1
            return replace(state, whole=False)
        state = follow(state, stamp.sequence, bool(frame.key_frame), frame.is_corrupt)
        if not state.whole:
            self.withheld[camera] += 1
            return state
        with self._lock:
            self.replaced[camera] += camera in self._slots
            self._slots[camera] = DecodedFrame(
                camera=camera, capture_ns=stamp.capture_ns, sequence=stamp.sequence, decoded_ns=decoded_ns, frame=frame
            )
        return state


async def _end(connection: RTCPeerConnection | None, readers: Readers) -> None:
    for reader in readers:
        reader.cancel()
    if connection is not None:
        await connection.close()
