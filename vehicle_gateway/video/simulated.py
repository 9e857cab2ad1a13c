"""The simulated cameras as sources: they render states of the world; a state's time is the capture stamp.

Every picture is of a state that arrived; nothing is rendered between two. A world that stops gives no picture at all.
Not modelled: exposure time, rolling shutter, lens distortion; of sensor noise only the read noise of a sparse grid of
pixels, because noise on all of them would cost the encoder more than the whole scene.
"""

import threading
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Protocol, Self

import numpy as np

from vehicle_gateway.video.picture import Bytes, Picture, luma, planar_frame, planes_of, size_of
from vehicle_gateway.video.slot import NewestSlot
from vehicle_gateway.video.turns import every, first_turns, is_turn, number_of
from wire.messages.sensing import WorldState
from wire.messages.vehicle import CameraCalibration

NOISE_STEP_PX = 16  # one noisy pixel in 16 x 16
_LOOK_S = 0.2  # how often a renderer without work looks whether it is to end
_BEGAN_ANEW_NS = 1_000_000_000  # a gap or a step back of more than this: another world


class Renderer(Protocol):
    def render_planar(self, world: WorldState, out: Bytes) -> None:
        """That state's picture into `out`: (H * 3 / 2, W), planar YUV 4:2:0 (BT.601, limited range); full or half size."""


class SimulatedSource:
    """States come in by `offer` (the link's thread), are rendered on a thread of its own, and go out by `take`.

    The next picture is rendered while the last one is encoded: one after the other would take longer than a period.
    """

    kind, is_camera = "simulated", True

    def __init__(self, renderer: Renderer, calibration: CameraCalibration) -> None:
        self.rate_hz = rate_hz = calibration.frame_rate_hz
        self.first_turn = 0
        self._renderer = renderer
        self._planes = [planes_of(size_of(calibration, halved)) for halved in (False, True)]
        self._halved = False
        self._step = every(rate_hz)
        self._states: NewestSlot[WorldState] = NewestSlot()
        self._pictures: NewestSlot[Picture] = NewestSlot()
        self._last: int | None = None
        self._halt = threading.Event()
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="renderer")
        self._worker: Future[None] | None = None
        self.losses = 0

    @property
    def skipped(self) -> int:
        return self._states.replaced + self._pictures.replaced

    def __enter__(self) -> Self:
        self._worker = self._pool.submit(self._run)
        return self

    def __exit__(self, *_: object) -> None:
        self._halt.set()
        self._pool.shutdown()

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        self._halved = halved
        self._step = every(min(rate_hz, self.rate_hz)) if rate_hz > 0 else 0

    def offer(self, world: WorldState, number: int | None) -> None:
        """A state of the world with its number; None: the numbers begin anew."""
        if number is None:
            self._last = None
        elif self._step and is_turn(number, self._last, self._step, self.first_turn):
            self._last = number
            self._states.put(world)

    def take(self, timeout_s: float) -> Picture | None:
        """Raises what the renderer raised: the camera, and with it the program, then ends."""
        if self._worker is not None and self._worker.done():
            self._worker.result()
        return self._pictures.take(timeout_s)

    def _run(self) -> None:
        while not self._halt.is_set():
            self.render(_LOOK_S)

    def render(self, timeout_s: float) -> None:
        """The state that waits, or the next that comes within `timeout_s`, becomes the picture to be fetched."""
        world = self._states.take(timeout_s)
        if world is not None:
            self._pictures.put(self._picture_of(world))

    def _picture_of(self, world: WorldState) -> Picture:
        planes = self._planes[self._halved]
        self._renderer.render_planar(world, planes)
        frame = planar_frame(planes)
        add_read_noise(luma(frame), world.stamp_ns)
        return Picture(frame, world.stamp_ns)


class WorldFeed:
    """Hands each state of the world to the cameras whose turn it is. `put` from the link's thread."""

    def __init__(self, sources: list[SimulatedSource]) -> None:
        self._sources = sources
        self._origin_ns = self._newest_ns = 0
        for source, first in zip(sources, first_turns([source.rate_hz for source in sources]), strict=True):
            source.first_turn = first

    def put(self, world: WorldState, received_ns: int) -> None:
        """The stamp that counts is the state's own."""
        if not -_BEGAN_ANEW_NS < world.stamp_ns - self._newest_ns < _BEGAN_ANEW_NS:
            self._origin_ns = world.stamp_ns
            for source in self._sources:
                source.offer(world, None)
        self._newest_ns = world.stamp_ns
        number = number_of(world.stamp_ns, self._origin_ns)
        for source in self._sources:
            source.offer(world, number)


def add_read_noise(luma_plane: Bytes, seed: int) -> None:
    """-1, 0 or +1 level on a sparse grid, in place: like a real sensor, never the same picture twice."""
    grid = luma_plane[::NOISE_STEP_PX, ::NOISE_STEP_PX]
    noise = np.random.default_rng(seed).integers(-1, 2, grid.shape, dtype=np.int8)
    grid[:] = np.clip(grid.astype(np.int16) + noise, 16, 235).astype(np.uint8)
