"""The peer of the video benchmark: aiortc as its examples use it - tracks of raw frames, default codec (VP8) and rate.

The capture stamp is a row of black and white blocks in the picture: 48 bits, microseconds.
"""

import asyncio
from fractions import Fraction
from multiprocessing.connection import Connection
from typing import Any

import av
import cv2
import numpy as np
from aiortc import MediaStreamTrack, RTCSessionDescription
from numpy.typing import NDArray

from benchmarks.pictures import WARM_UP_S, Cameras, Measured, Meter, Scene, cpu_s
from vehicle_gateway.video.picture import plane
from wire.clock import Clock
from wire.messages.vehicle import CameraCalibration
from wire.rtc import new_connection

_BLOCK_PX, _BITS = 8, 48  # a block is as large as VP8 needs it to be; 48 of them fit into the narrowest camera of 384
_VIDEO_CLOCK = Fraction(1, 90_000)


class RawTrack(MediaStreamTrack):
    """Raw frames with the stamp in the picture."""

    kind = "video"

    def __init__(self, camera: CameraCalibration) -> None:
        super().__init__()
        self._scene = Scene(camera)

    async def recv(self) -> av.VideoFrame:
        await asyncio.sleep(self._scene.due_in_s())
        frame, capture_ns = self._scene.take()
        write_blocks(plane(frame, 0), capture_ns // 1000)
        frame.pts, frame.time_base = capture_ns * 9 // 100_000, _VIDEO_CLOCK
        return frame


def send(pipe: Connection, cameras: Cameras) -> None:
    cv2.setNumThreads(1)

    async def serve() -> None:
        connection, loop = new_connection(), asyncio.get_running_loop()
        while (request := await loop.run_in_executor(None, pipe.recv)) != "end":
            if request == "cpu":
                pipe.send(cpu_s())
                continue
            await connection.setRemoteDescription(RTCSessionDescription(request, "offer"))
            for camera in cameras:
                connection.addTrack(RawTrack(camera))
            await connection.setLocalDescription(await connection.createAnswer())
            pipe.send(connection.localDescription.sdp)
        await connection.close()

    asyncio.run(serve())


def receive(pipe: Connection, cameras: Cameras, duration_s: float) -> Measured:
    return asyncio.run(_receive(pipe, cameras, duration_s))


async def _receive(pipe: Connection, cameras: Cameras, duration_s: float) -> Measured:
    connection = new_connection()
    for _ in cameras:
        connection.addTransceiver("video", direction="recvonly")
    await connection.setLocalDescription(await connection.createOffer())
    pipe.send(connection.localDescription.sdp)
    await connection.setRemoteDescription(RTCSessionDescription(pipe.recv(), "answer"))
    latencies_ms: dict[str, list[float]] = {camera.name: [] for camera in cameras}
    readers = [
        asyncio.create_task(_read(transceiver.receiver.track, latencies_ms[camera.name]))
        for transceiver, camera in zip(connection.getTransceivers(), cameras, strict=True)
    ]
    await asyncio.sleep(WARM_UP_S)
    meter = Meter(pipe, Clock())
    for found in latencies_ms.values():
        found.clear()
    await asyncio.sleep(duration_s)
    result = Measured(latencies_ms, *meter.read())
    for reader in readers:
        reader.cancel()
    pipe.send("end")
    await connection.close()
    return result


async def _read(track: Any, latencies_ms: list[float]) -> None:
    clock = Clock()
    while True:
        frame: Any = await track.recv()
        latencies_ms.append((clock.now_ns() // 1000 - read_blocks(plane(frame, 0))) / 1e3)
        frame.to_ndarray(format="bgra")  # our receiver's figures hold this conversion too


def write_blocks(luma: NDArray[np.uint8], value: int) -> None:
    """The low 48 bits of `value` as white and black blocks in the first rows of a luma plane."""
    for bit in range(_BITS):
        luma[: 2 * _BLOCK_PX, bit * _BLOCK_PX : (bit + 1) * _BLOCK_PX] = 235 if value >> bit & 1 else 16


def read_blocks(luma: NDArray[np.uint8]) -> int:
    """What write_blocks wrote, from the decoded plane."""
    middles = luma[_BLOCK_PX, _BLOCK_PX // 2 : _BITS * _BLOCK_PX : _BLOCK_PX]
    return sum(1 << bit for bit, level in enumerate(middles) if level > 125)
