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
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from msgspec.structs import replace

from vehicle_gateway.video.picture import Bytes, planes_of, size_of
from vehicle_gateway.video.simulated import Renderer
from wire.load import count_helper
from wire.messages.base import decoder, encode
from wire.messages.sensing import WorldState
from wire.messages.vehicle import CameraCalibration
from wire.pace import raise_priority
from wire.process import stand_back

BEHIND_THE_FIRST = 3  # niceness of the cameras that are not required: the one that is driven by is drawn first
END_S = 2.0  # a painter that is drawing ends after its picture


class PainterEnded(RuntimeError):
    """The process that drew a camera's pictures is gone."""


class Painter:
    """A Renderer whose pictures another process draws, of every size it was made for. Not safe for two threads at once."""

    def __init__(self, name: str, pipe: Connection, sizes: list[Bytes]) -> None:
        self._name, self._pipe, self._sizes = name, pipe, sizes

    def render_planar(self, world: WorldState, out: Bytes) -> None:
        number = next(number for number, planes in enumerate(self._sizes) if planes.shape == out.shape)
        try:
            self._pipe.send_bytes(bytes((number,)) + encode(world))
            self._pipe.recv_bytes()
        except (EOFError, OSError):
            raise PainterEnded(f"the process that draws camera {self._name} has ended") from None
        np.copyto(out, self._sizes[number])


@contextmanager
def painters(
    cameras: tuple[CameraCalibration, ...], make: Callable[[CameraCalibration], Renderer], fifo_priority: int = 0
) -> Iterator[Mapping[str, Painter]]:
    """Running painters by camera. To be entered while the process has one thread; leaving ends them.

    fifo_priority  SCHED_FIFO of the required cameras' painters, where the system allows it; their rate bounds what they take
    """
    context = multiprocessing.get_context("fork")
    renderers = [[make(each) for each in _sizes(calibration)] for calibration in cameras]
    gc.collect()
    gc.freeze()  # a child that counts what it shares would copy it
    pipes = [context.Pipe() for _ in cameras]
    made: dict[str, Painter] = {}
    processes = []
    for calibration, drawers, (ours, theirs) in zip(cameras, renderers, pipes, strict=True):
        planes = [_shared_planes(each) for each in _sizes(calibration)]
        others = [end for pair in pipes for end in pair if end is not theirs]
        asked = (drawers, theirs, planes, others, fifo_priority if calibration.required else None)
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


def _sizes(calibration: CameraCalibration) -> tuple[CameraCalibration, ...]:
    """As it is and, of one that gives way by size, halved."""
    if not calibration.required:
        return (calibration,)
    width_px, height_px = size_of(calibration, halved=True)
    focal_px = calibration.focal_length_px * width_px / calibration.width_px
    return calibration, replace(calibration, width_px=width_px, height_px=height_px, focal_length_px=focal_px)


def _shared_planes(calibration: CameraCalibration) -> Bytes:
    size = size_of(calibration, halved=False)
    return planes_of(size, mmap.mmap(-1, size[0] * size[1] * 3 // 2))


def _paint(
    renderers: list[Renderer], pipe: Connection, sizes: list[Bytes], others: list[Connection], fifo_priority: int | None
) -> None:
    """The life of a painter. Without a priority it stands back."""
    with suppress(OSError):
        Path("/proc/self/comm").write_text(multiprocessing.current_process().name)  # as `top` shows it
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)  # sent to the whole group: the pipe tells when to end
    for end in others:
        end.close()
    if fifo_priority is None:
        stand_back(BEHIND_THE_FIRST)
    else:
        raise_priority(fifo_priority)
    states = decoder(WorldState)
    while True:
        try:
            asked = pipe.recv_bytes()
            renderers[asked[0]].render_planar(states.decode(memoryview(asked)[1:]), sizes[asked[0]])
            pipe.send_bytes(b"")
        except (EOFError, BrokenPipeError, ConnectionResetError):
            return
