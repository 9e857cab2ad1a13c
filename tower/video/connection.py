"""The seam to aiortc on the tower's side: a connection that only receives H.264, one section per camera.

All use of its inside that is the tower's alone is here (`wire.rtc` has the rest): a lost packet holds everything back until 512
more have come, although the sender can resend only the last 128; of several cameras no packet that is sent again is known; one
whose repetition is lost as well is not asked for again; and what a hole has held up stays late.

Tested against aiortc 1.16.0, aioice 0.13.0.
"""

from collections.abc import Iterator
from typing import Any

from aiortc import RTCBundlePolicy, RTCPeerConnection, RTCRtpReceiver, RTCSessionDescription
from aiortc.jitterbuffer import JitterBuffer, JitterFrame
from aiortc.rtp import RTP_HISTORY_SIZE, RtpPacket
from av import VideoFrame
from av.sidedata.sidedata import Type

from wire.ice import Ways
from wire.rtc import UNREADABLE, gather_in_time, new_connection

_RESENDABLE = RTP_HISTORY_SIZE  # 128 packets: beyond them a hole stays a hole. A picture must be smaller (150 kB)


async def receiving_connection(cameras: int, ways: Ways) -> RTCPeerConnection:
    """A connection with its offer as local description, gathered: without servers, host candidates only."""
    connection = new_connection(ways, RTCBundlePolicy.MAX_BUNDLE)
    capabilities = RTCRtpReceiver.getCapabilities("video")
    codecs = capabilities.codecs if capabilities is not None else []
    for _ in range(cameras):
        transceiver = connection.addTransceiver("video", direction="recvonly")
        transceiver.setCodecPreferences([codec for codec in codecs if codec.mimeType in ("video/H264", "video/rtx")])
        receiver: Any = transceiver.receiver
        receiver._RTCRtpReceiver__jitter_buffer = PromptBuffer(receiver)
    gather_in_time(connection, ways.relay_only)
    await connection.setLocalDescription(await connection.createOffer())
    return connection


class PromptBuffer(JitterBuffer):
    """aiortc's, but every picture that has become whole leaves at once.

    Its own add() gives back one picture a packet: what a hole has held up stays held up by as many pictures for ever after.
    Seen: pictures three seconds old, half a minute after the link was whole again.
    """

    def __init__(self, receiver: Any) -> None:
        super().__init__(capacity=_RESENDABLE, is_video=True)
        self._receiver = receiver

    def add(self, packet: RtpPacket) -> tuple[bool, JitterFrame | None]:
        """The last picture goes the usual way, those before it straight to the decoder."""
        picture_lost, frame = super().add(packet)
        while frame is not None:
            following = self._remove_frame(packet.sequence_number)
            if following is None:
                break
            self._decode(packet.payload_type, frame)
            frame = following
        return picture_lost, frame

    def _decode(self, payload_type: int, frame: JitterFrame) -> None:
        receiver = self._receiver
        frame.timestamp = receiver._RTCRtpReceiver__timestamp_mapper.map(frame.timestamp)
        receiver._RTCRtpReceiver__decoder_queue.put((receiver._RTCRtpReceiver__codecs[payload_type], frame))


Missing = list[frozenset[int]]  # sequence numbers of packets, by camera


async def mend(connection: RTCPeerConnection, before: Missing) -> Missing:
    """Ask once more for every packet that was missing at the last look already; what is missing now.

    aiortc asks when it finds a hole, and again only when it finds the next one: where the packet that was sent again is lost,
    too, everything waits for that. And of several cameras on one connection it does not know whose a packet sent again is.
    """
    now: Missing = []
    for transceiver in connection.getTransceivers():
        receiver: Any = transceiver.receiver
        holes, sources = receiver._RTCRtpReceiver__nack_generator, receiver._RTCRtpReceiver__rtx_ssrc
        for repetition in sources:
            receiver.transport._rtp_router.ssrc_table.setdefault(repetition, receiver)
        now.append(frozenset(holes.missing) if holes is not None else frozenset())
        still = now[-1] & before[len(now) - 1] if len(now) <= len(before) else frozenset()
        for source in sources.values() if still else ():
            await receiver._send_rtcp_nack(source, sorted(still))
    return now


async def take_answer(connection: RTCPeerConnection, sdp: str) -> str:
    """Apply the car's answer; "" or, in words, why it cannot be used."""
    try:
        await connection.setRemoteDescription(RTCSessionDescription(sdp, "answer"))
    except UNREADABLE as error:
        return f"the answer cannot be used: {error or type(error).__name__}"
    return ""


def user_data(frame: VideoFrame) -> Iterator[bytes]:
    """The SEI "user data unregistered" payloads of a decoded picture, UUID first."""
    sides: Any = frame.side_data  # iterates over its values, against its own declaration
    for side in sides:
        if side.type == Type.SEI_UNREGISTERED:
            yield bytes(side)
