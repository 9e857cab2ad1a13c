"""A car of one process whose cameras count, and a window's look at them: over a real WebRTC connection, without a link."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from tower.video.receiver import DecodedFrame, VideoReceiver
from vehicle_gateway.video.picture import Picture, from_bgr
from vehicle_gateway.video.sender import video_sender
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.messages.base import Message
from wire.messages.vehicle import CameraCalibration

WAIT_S = 5.0


class MemoryLink:
    """The link of both sites in one object: queries are answered in place, published messages kept."""

    def __init__(self) -> None:
        self.handlers: dict[str, Callable[[Any], Message]] = {}
        self.published: dict[str, list[Any]] = {}
        self.hearers: dict[str, list[Callable[[Any, int], None]]] = {}
        self.asked = 0

    def publish(self, name: str, message: Message | bytes) -> None:
        self.published.setdefault(name, []).append(message)

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None:
        self.handlers[name] = handler

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None:
        self.hearers.setdefault(name, []).append(callback)

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None:
        self.asked += 1
        return self.handlers[name](request) if name in self.handlers else None


class CountingCamera:
    """30 Hz unless told; the grey level of picture n is 40 + n % 170, so that a picture can be told by what is in it."""

    kind, is_camera, skipped, losses = "simulated", True, 0, 0

    def __init__(self, clock: Clock, rate_hz: float = 30.0) -> None:
        self._clock, self._period_s, self._halt = clock, 1 / rate_hz, threading.Event()
        self.levels: dict[int, int] = {}  # capture_ns -> grey level

    def take(self, timeout_s: float) -> Picture | None:
        if self._halt.wait(self._period_s):
            return None
        capture_ns, level = self._clock.now_ns(), 40 + len(self.levels) % 170
        self.levels[capture_ns] = level
        return Picture(from_bgr(np.full((180, 320, 3), level, np.uint8)), capture_ns)

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        """It never has to give way here: a slow machine must not change what is counted."""

    def __enter__(self) -> "CountingCamera":
        return self

    def __exit__(self, *_: object) -> None:
        self._halt.set()


def camera(name: str) -> CameraCalibration:
    return CameraCalibration(
        name=name,
        required=True,
        width_px=320,
        height_px=180,
        frame_rate_hz=30.0,
        focal_length_px=200.0,
        x_m=1.7,
        y_m=0.0,
        z_m=1.3,
        yaw_rad=0.0,
        pitch_rad=0.0,
    )


@contextmanager
def car(link: MemoryLink, *names: str, rate_hz: float = 30.0) -> Iterator[dict[str, CountingCamera]]:
    sources = {name: CountingCamera(Clock(), rate_hz) for name in names}
    with video_sender(link, tuple(camera(name) for name in names), sources, VideoSettings(), Clock()):
        yield sources


def watch(video: VideoReceiver, name: str, count: int, after: int = 0) -> list[DecodedFrame]:
    """`count` different pictures of one camera with a sequence above `after`."""
    frames: dict[int, DecodedFrame] = {}
    clock, pause = Clock(), threading.Event()
    end_ns = clock.now_ns() + round(WAIT_S * 1e9)
    while len(frames) < count:
        assert clock.now_ns() < end_ns, f"{len(frames)} of {count} pictures of {name} in {WAIT_S} s"
        frame = video.newest(name)
        if frame is not None and frame.sequence > after:
            frames[frame.sequence] = frame
        pause.wait(0.005)
    return list(frames.values())
