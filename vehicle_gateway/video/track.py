"""The seam to aiortc: our coded pictures as a track, and the receiver's request for an IDR. `wire.rtc` has what both ends share.

- The track returns ready packets, so aiortc neither encodes nor clamps the rate (public interface).
- After every picture follow two lone end-of-sequence NAL units with the next time stamps. The stock receiver releases a
  picture only when the first packet of the NEXT time stamp arrives, one picture interval late; now that packet comes at
  once. Two, because the last packet of all is missed only when the next picture comes, and may be lost like any other.
  Only towards our own tower: browsers were not tried.
- aiortc tells a packet track nothing of what the receiver reports: `RTCRtpSender._send_keyframe` (PLI and FIR) is replaced
  and `_handle_rtcp_packet` (estimate and loss) listened to, on the instance.

Tested against aiortc 1.16.0, aioice 0.13.0.
"""

import asyncio
from collections.abc import Callable
from fractions import Fraction
from typing import Any, Protocol, TypeAlias

import av
from aiortc import MediaStreamTrack, RTCRtpTransceiver
from aiortc.mediastreams import MediaStreamError
from aiortc.rtcrtpsender import RTCRtpSender
from aiortc.rtp import RTCP_PSFB_APP, RtcpPsfbPacket, RtcpRrPacket, RtcpSrPacket, unpack_remb_fci

from vehicle_gateway.video.backlog import Backlog
from vehicle_gateway.video.sei import END_OF_SEQUENCE
from wire.picture import EncodedPicture

Packet: TypeAlias = "av.Packet[Any]"
_VIDEO_CLOCK_HZ = 90_000
_TIME_BASE = Fraction(1, _VIDEO_CLOCK_HZ)


class PacketTrack(MediaStreamTrack):  # aiortc accepts nothing but its own class
    """The coded pictures of one camera for one watcher. put() from any thread, recv() by aiortc."""

    kind = "video"

    def __init__(self, loop: asyncio.AbstractEventLoop, request_idr: Callable[[], None]) -> None:
        super().__init__()
        self.backlog = Backlog()
        self._on_loop = loop  # not `_loop`, which pyee uses
        self._request_idr = request_idr
        self._arrived = asyncio.Event()
        self._ends: list[Packet] = []  # of sequence, that belong to the picture just sent
        self._watched = False
        self._pts = 0

    def put(self, picture: EncodedPicture, now_ns: int) -> None:
        self._on_loop.call_soon_threadsafe(self._take, picture, now_ns)

    def _take(self, picture: EncodedPicture, now_ns: int) -> None:
        if not self._watched or self.readyState != "live":
            return  # the connection is not up yet, or gone
        if self.backlog.offer(picture):
            self._request_idr()
        self._pts = max(self._pts, now_ns * _VIDEO_CLOCK_HZ // 1_000_000_000)
        self._arrived.set()

    async def recv(self) -> Packet:
        if not self._watched:
            self._watched = True
            self._request_idr()
        if self._ends:
            return self._ends.pop(0)
        while not self.backlog.waiting:
            if self.readyState != "live":
                raise MediaStreamError
            self._arrived.clear()
            await self._arrived.wait()
        packet = self._packet(self.backlog.waiting.popleft().annex_b, self._pts)
        self._ends = [self._packet(END_OF_SEQUENCE, self._pts + number) for number in (1, 2)]
        self._pts += 3  # time stamps grow, even when two pictures come in the same tick
        return packet

    def _packet(self, data: bytes, pts: int) -> Packet:
        packet = av.Packet(data)
        packet.pts, packet.time_base = pts, _TIME_BASE
        return packet


class Feedback(Protocol):
    """Who is told what the receivers of one camera report, each under its watcher's name. Called on the session's thread."""

    def request_idr(self) -> None: ...

    def note_session(self, watcher: str, watched: bool) -> None: ...

    def note_leader(self, watcher: str) -> None: ...

    def note_estimate(self, watcher: str, estimate_bps: float) -> None: ...

    def note_loss(self, watcher: str, lost: float) -> None: ...


def send_on(
    transceiver: RTCRtpTransceiver, track: PacketTrack, feedback: Feedback, watcher: str, note_heard: Callable[[], None]
) -> None:
    """Send the track on that transceiver as H.264, and pass on what the watcher's receiver reports, and that it does."""
    codecs = RTCRtpSender.getCapabilities("video").codecs
    transceiver.setCodecPreferences([codec for codec in codecs if codec.mimeType in ("video/H264", "video/rtx")])
    transceiver.sender.replaceTrack(track)
    transceiver.direction = "sendonly"
    sender: Any = transceiver.sender
    sender._send_keyframe = feedback.request_idr
    handle = sender._handle_rtcp_packet

    async def handle_and_listen(packet: object) -> None:
        note_heard()
        _listen(packet, sender._ssrc, feedback, watcher)
        await handle(packet)

    sender._handle_rtcp_packet = handle_and_listen


def _listen(packet: object, ssrc: int, feedback: Feedback, watcher: str) -> None:
    """Receiver reports give the loss (RFC 3550 6.4.2, in 1/256), REMB the estimate of what the path carries."""
    if isinstance(packet, RtcpRrPacket | RtcpSrPacket):
        for report in packet.reports:
            if report.ssrc == ssrc:
                feedback.note_loss(watcher, report.fraction_lost / 256)
    elif isinstance(packet, RtcpPsfbPacket) and packet.fmt == RTCP_PSFB_APP:
        try:
            estimate_bps, ssrcs = unpack_remb_fci(packet.fci)
        except ValueError:
            return  # another application's message
        if ssrc in ssrcs:
            feedback.note_estimate(watcher, estimate_bps)
