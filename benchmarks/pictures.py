"""What both video chains are measured with: the same moving pictures, a pipe instead of the link, CPU of both processes."""

import resource
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

import av
import cv2
import numpy as np
from msgspec.structs import replace

from vehicle_gateway.video.picture import Picture, from_bgr
from wire.clock import Clock
from wire.messages.base import Message
from wire.messages.vehicle import CameraCalibration, VehicleDescription
from wire.rear_view import REAR

WARM_UP_S = 3.0
STEP_PX = 6  # by which the texture moves from one picture to the next
Cameras = tuple[CameraCalibration, ...]
SIDES = ("left", "right")
SIDE = {"required": False, "width_px": 416, "height_px": 360, "frame_rate_hz": 13.5, "focal_length_px": 450.0}


def three_cameras(car: VehicleDescription) -> Cameras:
    """What is sent while the car drives forward; where the configuration has the front alone, with sides of our usual size."""
    forward = tuple(camera for camera in car.cameras if camera.name != REAR)
    known = {camera.name for camera in forward}
    return (*forward, *(replace(forward[0], name=name, **SIDE) for name in SIDES if name not in known))


class Measured(NamedTuple):
    """What the receiving process has seen in `spent_s`."""

    latencies_ms: dict[str, list[float]]  # by camera
    spent_s: float
    receiver_cpu: float  # of one core
    sender_cpu: float


class Scene:
    """Pictures of a textured plane, of one camera's size and at its rate, each with the time it was taken."""

    def __init__(self, camera: CameraCalibration) -> None:
        self._width_px, self._rate_hz = camera.width_px, camera.frame_rate_hz
        coarse = np.random.default_rng(1).integers(0, 255, (90, 320, 3), dtype=np.uint8)
        self._plane = cv2.resize(coarse, (2 * camera.width_px, camera.height_px), interpolation=cv2.INTER_CUBIC)
        self._clock, self._pause = Clock(), threading.Event()
        self._due_ns = self._clock.now_ns()
        self._number = 0

    def due_in_s(self) -> float:
        """Until the next picture; a late one is not made up for."""
        now_ns = self._clock.now_ns()
        self._due_ns = max(self._due_ns + round(1e9 / self._rate_hz), now_ns)
        return (self._due_ns - now_ns) / 1e9

    def take(self) -> tuple[av.VideoFrame, int]:
        self._number += 1
        left = STEP_PX * self._number % self._width_px
        return from_bgr(np.ascontiguousarray(self._plane[:, left : left + self._width_px])), self._clock.now_ns()

    def wait_and_take(self) -> tuple[av.VideoFrame, int]:
        self._pause.wait(self.due_in_s())
        return self.take()


class SceneSource:
    """The scene as a source of the sender."""

    kind, is_camera, skipped, losses = "simulated", True, 0, 0

    def __init__(self, camera: CameraCalibration) -> None:
        self._scene = Scene(camera)

    def take(self, timeout_s: float) -> Picture:
        return Picture(*self._scene.wait_and_take())

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        """Always the camera's own rate: both chains are given the same pictures."""

    def __enter__(self) -> "SceneSource":
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing was opened."""


class PipeLink:
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
            self._pipe.send(cpu_s() if request == "cpu" else self.handler(request) if self.handler else None)


class Meter:
    """CPU of both processes per second of a clock, from its making to read()."""

    def __init__(self, pipe: Connection, clock: Clock) -> None:
        self._pipe, self._clock = pipe, clock
        self.start_ns, self._own_s, self._far_s = clock.now_ns(), cpu_s(), self._far()

    def _far(self) -> float:
        self._pipe.send("cpu")
        return float(self._pipe.recv())

    def read(self) -> tuple[float, float, float]:
        """(seconds, own CPU per second, the sender's)."""
        spent_s = (self._clock.now_ns() - self.start_ns) / 1e9
        return spent_s, (cpu_s() - self._own_s) / spent_s, (self._far() - self._far_s) / spent_s


def cpu_s() -> float:
    """Of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime
