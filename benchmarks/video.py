"""Video: capture to decoded picture, our chain beside stock aiortc VP8, one camera, the same pictures, in one run.

    python -m benchmarks.video

Sender and receiver are two processes on one machine and one clock. Ours: vehicle_gateway.video.sender and
tower.video.receiver as the programs run them, the stamp inside the picture. The peer: aiortc as its examples use it (a
track of raw frames, default codec and rate), the stamp as a row of black and white blocks in the picture. Latency is
from the frame in the camera thread's hand to the decoded frame in the other process's hand. Pictures: a moving texture.
The link that carries offer and answer is a pipe here. Not measured: camera, renderer, screen, network.
"""

import asyncio
import multiprocessing
import resource
import threading
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from multiprocessing.connection import Connection
from typing import Any

import av
import cv2
import numpy as np
from aiortc import MediaStreamTrack, RTCPeerConnection, RTCSessionDescription
from numpy.typing import NDArray

from tower.video.receiver import VideoReceiver
from vehicle_gateway.video.picture import Picture, from_bgr, plane
from vehicle_gateway.video.sender import video_sender
from vehicle_gateway.video.settings import VideoSettings
from vehicle_gateway.video.track import new_connection
from wire.clock import Clock
from wire.messages.base import Message
from wire.messages.vehicle import CameraCalibration

WIDTH_PX, HEIGHT_PX, RATE_HZ = 1280, 720, 30
WARM_UP_S = 3.0
_BLOCK_PX, _BITS = 16, 48  # the stamp of the peer's pictures: microseconds modulo 2**48
_VIDEO_CLOCK = Fraction(1, 90_000)
CAMERA = CameraCalibration(
    name="front",
    required=True,
    width_px=WIDTH_PX,
    height_px=HEIGHT_PX,
    frame_rate_hz=RATE_HZ,
    focal_length_px=760.0,
    x_m=1.7,
    y_m=0.0,
    z_m=1.35,
    yaw_rad=0.0,
    pitch_rad=0.06,
)
Receive = Callable[[Connection, float], tuple[list[float], float, float, float]]  # ms, seconds, CPU here, CPU there


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoFigures:
    chain: str
    pictures: int
    rate_hz: float
    p50_ms: float
    p95_ms: float
    p99_ms: float
    sender_cpu_percent: float  # of one core
    receiver_cpu_percent: float


def compare(duration_s: float = 15.0) -> tuple[VideoFigures, VideoFigures]:
    """(ours, stock aiortc VP8), measured one after the other."""
    return (
        _measure("ours", _send_ours, _receive_ours, duration_s),
        _measure("stock aiortc VP8", _send_stock, _receive_stock, duration_s),
    )


def _measure(chain: str, send: Callable[[Connection], None], receive: Receive, duration_s: float) -> VideoFigures:
    context = multiprocessing.get_context("spawn")
    car, tower = context.Pipe()
    result_out, result_in = context.Pipe()
    sender = context.Process(target=send, args=(car,))
    receiver = context.Process(target=_receive_and_tell, args=(receive, tower, duration_s, result_in))
    sender.start()
    receiver.start()
    latencies_ms, spent_s, receiver_cpu, sender_cpu = result_out.recv()
    receiver.join()
    sender.join()
    p50, p95, p99 = (round(float(value), 1) for value in np.percentile(latencies_ms, (50, 95, 99)))
    return VideoFigures(
        chain=chain,
        pictures=len(latencies_ms),
        rate_hz=round(len(latencies_ms) / spent_s, 1),
        p50_ms=p50,
        p95_ms=p95,
        p99_ms=p99,
        sender_cpu_percent=round(100 * sender_cpu, 1),
        receiver_cpu_percent=round(100 * receiver_cpu, 1),
    )


def _receive_and_tell(receive: Receive, pipe: Connection, duration_s: float, out: Connection) -> None:
    out.send(receive(pipe, duration_s))


def _cpu_s() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


class _Scene:
    """Pictures of a textured plane that moves 6 px a picture, at 30 Hz, each with the time it was taken."""

    def __init__(self) -> None:
        coarse = np.random.default_rng(1).integers(0, 255, (90, 320, 3), dtype=np.uint8)
        self._plane = cv2.resize(coarse, (2 * WIDTH_PX, HEIGHT_PX), interpolation=cv2.INTER_CUBIC)
        self._clock, self._pause = Clock(), threading.Event()
        self._due_ns = self._clock.now_ns()
        self._number = 0

    def due_in_s(self) -> float:
        """Until the next picture; a late one is not made up for."""
        now_ns = self._clock.now_ns()
        self._due_ns = max(self._due_ns + round(1e9 / RATE_HZ), now_ns)
        return (self._due_ns - now_ns) / 1e9

    def take(self) -> tuple[av.VideoFrame, int]:
        self._number += 1
        left = 6 * self._number % WIDTH_PX
        return from_bgr(np.ascontiguousarray(self._plane[:, left : left + WIDTH_PX])), self._clock.now_ns()

    def wait_and_take(self) -> tuple[av.VideoFrame, int]:
        self._pause.wait(self.due_in_s())
        return self.take()


class _SceneSource:
    """The scene as a source of the sender."""

    kind, is_camera, skipped, losses = "simulated", True, 0, 0

    def __init__(self) -> None:
        self._scene = _Scene()

    def take(self, timeout_s: float) -> Picture:
        return Picture(*self._scene.wait_and_take())

    def limit(self, rate_hz: float) -> None:
        """Always 30 Hz."""

    def __enter__(self) -> "_SceneSource":
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing was opened."""


class _PipeLink:
    """The link over a pipe: one question, one answer."""

    def __init__(self, pipe: Connection) -> None:
        self._pipe = pipe
        self.handler: Callable[[Any], Message] | None = None

    def publish(self, name: str, message: Message | bytes) -> None:
        """The recorder is not part of this."""

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None:
        self.handler = handler

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None:
        """No car says anything here."""

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None:
        self._pipe.send(request)
        return self._pipe.recv() if self._pipe.poll(timeout_s) else None

    def answer_until_told_the_end(self) -> None:
        """Offers are answered; "cpu" gives the CPU time so far; "end" ends."""
        while (request := self._pipe.recv()) != "end":
            self._pipe.send(_cpu_s() if request == "cpu" else self.handler(request) if self.handler else None)


def _send_ours(pipe: Connection) -> None:
    cv2.setNumThreads(1)
    link = _PipeLink(pipe)
    with video_sender(link, (CAMERA,), {"front": _SceneSource()}, VideoSettings(), Clock()):
        link.answer_until_told_the_end()


def _receive_ours(pipe: Connection, duration_s: float) -> tuple[list[float], float, float, float]:
    clock, pause = Clock(), threading.Event()
    latencies_ms: dict[int, float] = {}
    with VideoReceiver(_PipeLink(pipe), clock, ("front",)) as video:
        pause.wait(WARM_UP_S)
        meter = _Meter(pipe, clock)
        while clock.now_ns() - meter.start_ns < duration_s * 1e9:
            frame = video.newest("front")
            if frame is not None:
                latencies_ms[frame.sequence] = (frame.decoded_ns - frame.capture_ns) / 1e6
            pause.wait(1 / 60)  # the window's display rate
        result = list(latencies_ms.values())[1:], *meter.read()
    pipe.send("end")
    return result


class _Meter:
    """CPU of both processes per second of a clock, from its making to read()."""

    def __init__(self, pipe: Connection, clock: Clock) -> None:
        self._pipe, self._clock = pipe, clock
        self.start_ns, self._own_s, self._far_s = clock.now_ns(), _cpu_s(), self._far()

    def _far(self) -> float:
        self._pipe.send("cpu")
        return float(self._pipe.recv())

    def read(self) -> tuple[float, float, float]:
        """(seconds, own CPU per second, the sender's)."""
        spent_s = (self._clock.now_ns() - self.start_ns) / 1e9
        return spent_s, (_cpu_s() - self._own_s) / spent_s, (self._far() - self._far_s) / spent_s


class _RawTrack(MediaStreamTrack):
    """Raw frames with the stamp in the picture: the way aiortc's examples send a camera."""

    kind = "video"

    def __init__(self) -> None:
        super().__init__()
        self._scene = _Scene()

    async def recv(self) -> av.VideoFrame:
        await asyncio.sleep(self._scene.due_in_s())
        frame, capture_ns = self._scene.take()
        write_blocks(plane(frame, 0), capture_ns // 1000)
        frame.pts, frame.time_base = capture_ns * 9 // 100_000, _VIDEO_CLOCK
        return frame


def _send_stock(pipe: Connection) -> None:
    cv2.setNumThreads(1)

    async def serve() -> None:
        connection, loop = new_connection(), asyncio.get_running_loop()
        while (request := await loop.run_in_executor(None, pipe.recv)) != "end":
            if request == "cpu":
                pipe.send(_cpu_s())
                continue
            await connection.setRemoteDescription(RTCSessionDescription(request, "offer"))
            connection.addTrack(_RawTrack())
            await connection.setLocalDescription(await connection.createAnswer())
            pipe.send(connection.localDescription.sdp)
        await connection.close()

    asyncio.run(serve())


def _receive_stock(pipe: Connection, duration_s: float) -> tuple[list[float], float, float, float]:
    return asyncio.run(_receive_stock_until(pipe, duration_s))


async def _receive_stock_until(pipe: Connection, duration_s: float) -> tuple[list[float], float, float, float]:
    connection, clock = await _stock_receiver(), Clock()
    pipe.send(connection.localDescription.sdp)
    await connection.setRemoteDescription(RTCSessionDescription(pipe.recv(), "answer"))
    track = connection.getTransceivers()[0].receiver.track
    warm_ns = clock.now_ns() + round(WARM_UP_S * 1e9)
    latencies_ms: list[float] = []
    meter: _Meter | None = None
    while meter is None or clock.now_ns() - meter.start_ns < duration_s * 1e9:
        frame: Any = await track.recv()
        now_us = clock.now_ns() // 1000
        if meter is not None:
            latencies_ms.append((now_us - read_blocks(plane(frame, 0))) / 1e3)
            frame.to_ndarray(format="bgra")  # our receiver's figures hold this conversion too
        elif clock.now_ns() > warm_ns:
            meter = _Meter(pipe, clock)
    result = latencies_ms, *meter.read()
    pipe.send("end")
    await connection.close()
    return result


async def _stock_receiver() -> RTCPeerConnection:
    connection = new_connection()
    connection.addTransceiver("video", direction="recvonly")
    await connection.setLocalDescription(await connection.createOffer())
    return connection


def write_blocks(luma: NDArray[np.uint8], value: int) -> None:
    """The low 48 bits of `value` as white and black blocks in the first rows of a luma plane."""
    for bit in range(_BITS):
        luma[:_BLOCK_PX, bit * _BLOCK_PX : (bit + 1) * _BLOCK_PX] = 235 if value >> bit & 1 else 16


def read_blocks(luma: NDArray[np.uint8]) -> int:
    """What write_blocks wrote, from the decoded plane."""
    middles = luma[_BLOCK_PX // 2, _BLOCK_PX // 2 : _BITS * _BLOCK_PX : _BLOCK_PX]
    return sum(1 << bit for bit, level in enumerate(middles) if level > 125)


if __name__ == "__main__":
    for figures in compare():
        print(figures)
