"""One process for each simulated camera: none waits for another, and none holds the interpreter that encodes and sends.

They are forked from the program that has painted the scene, before it has threads, and share the scene's memory. A painter
draws what it is asked to and knows nothing else; it ends when its pipe does. Raises nothing itself: what goes wrong while it
draws is told on standard error, and whoever asks next gets a PainterEnded.
"""

import gc
import mmap
import multiprocessing
import signal
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from multiprocessing.connection import Connection

import numpy as np

from vehicle_gateway.video.picture import Bytes
from vehicle_gateway.video.simulated import Renderer
from wire.load import count_helper
from wire.messages.base import decoder, encode
from wire.messages.sensing import WorldState
from wire.messages.vehicle import CameraCalibration
from wire.process import stand_back

BEHIND_THE_FIRST = 3  # niceness of the cameras that are not required: the one that is driven by is drawn first
END_S = 2.0  # a painter that is drawing ends after its picture


class PainterEnded(RuntimeError):
    """The process that drew a camera's pictures is gone."""


class Painter:
    """A Renderer whose pictures another process draws. Not safe for two threads at once."""

    def __init__(self, name: str, pipe: Connection, planes: Bytes) -> None:
        self._name, self._pipe, self._planes = name, pipe, planes

    def render_planar(self, world: WorldState, out: Bytes) -> None:
        try:
            self._pipe.send_bytes(encode(world))
            self._pipe.recv_bytes()
        except (EOFError, OSError):
            raise PainterEnded(f"the process that draws camera {self._name} has ended") from None
        np.copyto(out, self._planes)


@contextmanager
def painters(
    cameras: tuple[CameraCalibration, ...], make: Callable[[CameraCalibration], Renderer]
) -> Iterator[Mapping[str, Painter]]:
    """Running painters by camera. To be entered while the process has one thread; leaving ends them."""
    context = multiprocessing.get_context("fork")
    renderers = [make(calibration) for calibration in cameras]
    gc.collect()
    gc.freeze()  # a child that counts what it shares would copy it
    pipes = [context.Pipe() for _ in cameras]
    made: dict[str, Painter] = {}
    processes = []
    for calibration, renderer, (ours, theirs) in zip(cameras, renderers, pipes, strict=True):
        planes = _shared_planes(calibration)
        others = [end for pair in pipes for end in pair if end is not theirs]
        asked = (renderer, theirs, planes, others, 0 if calibration.required else BEHIND_THE_FIRST)
        processes.append(context.Process(target=_paint, args=asked, name=f"painter-{calibration.name}", daemon=True))
        made[calibration.name] = Painter(calibration.name, ours, planes)
    for process in processes:
        process.start()
        count_helper(process.pid or 0)
    for _, theirs in pipes:
        theirs.close()
    try:
        yield made
    finally:
        for ours, _ in pipes:
            ours.close()
        for process in processes:
            process.join(END_S)


def _shared_planes(calibration: CameraCalibration) -> Bytes:
    shape = calibration.height_px * 3 // 2, calibration.width_px
    return np.frombuffer(mmap.mmap(-1, shape[0] * shape[1]), np.uint8).reshape(shape)


def _paint(renderer: Renderer, pipe: Connection, planes: Bytes, others: list[Connection], niceness: int) -> None:
    """The life of a painter."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # sent to the whole group: the pipe tells when to end
    for end in others:
        end.close()
    stand_back(niceness)
    states = decoder(WorldState)
    while True:
        try:
            asked = pipe.recv_bytes()
            renderer.render_planar(states.decode(asked), planes)
            pipe.send_bytes(b"")
        except (EOFError, BrokenPipeError, ConnectionResetError):
            return
