"""The simulated cameras as sources: they render states of the world; a state's time is the capture stamp.

Every picture is of a state that arrived; nothing is rendered between two. A world that stops gives no picture at all.
Only one picture is rendered at a time: two renderers in one interpreter would only wait for each other.
Not modelled: exposure time, rolling shutter, lens distortion; of sensor noise only the read noise of a sparse grid of
pixels, because noise on all of them would cost the encoder more than the whole scene.
"""

import threading
from typing import Protocol, Self

import numpy as np

from vehicle_gateway.video.picture import Bytes, Picture, luma, planar_frame
from vehicle_gateway.video.slot import NewestSlot
from vehicle_gateway.video.turns import every, first_turns, is_turn, number_of
from wire.messages.sensing import WorldState

NOISE_STEP_PX = 16  # one noisy pixel in 16 x 16
_BEGAN_ANEW_NS = 1_000_000_000  # a gap or a step back of more than this: another world


class Renderer(Protocol):
    def render_planar(self, world: WorldState, out: Bytes) -> None:
        """The picture of that state into `out`: (H * 3 / 2, W), planar YUV 4:2:0 (BT.601, limited range)."""


class SimulatedSource:
    """States come in by `offer` (the link's thread), pictures go out by `take` (the camera's thread, which renders)."""

    kind, is_camera = "simulated", True

    def __init__(self, renderer: Renderer, width_px: int, height_px: int, rate_hz: float) -> None:
        self.rate_hz = rate_hz
        self.first_turn = 0
        self.brush: threading.Lock = threading.Lock()  # the feed gives all its cameras the same
        self._renderer = renderer
        # two: the picture before is repeated while the world stands still
        self._planes: list[Bytes] = [np.zeros((height_px * 3 // 2, width_px), np.uint8) for _ in range(2)]
        self._step = every(rate_hz)
        self._slot: NewestSlot[WorldState] = NewestSlot()
        self._last: int | None = None
        self.losses = 0

    @property
    def skipped(self) -> int:
        return self._slot.replaced

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing was opened."""

    def limit(self, rate_hz: float) -> None:
        self._step = every(min(rate_hz, self.rate_hz))

    def offer(self, world: WorldState, number: int | None) -> None:
        """A state of the world with its number; None: the numbers begin anew."""
        if number is None:
            self._last = None
        elif is_turn(number, self._last, self._step, self.first_turn):
            self._last = number
            self._slot.put(world)

    def take(self, timeout_s: float) -> Picture | None:
        world = self._slot.take(timeout_s)
        if world is None:
            return None
        self._planes.reverse()
        planes = self._planes[0]
        with self.brush:
            self._renderer.render_planar(world, planes)
        frame = planar_frame(planes)
        add_read_noise(luma(frame), world.stamp_ns)
        return Picture(frame, world.stamp_ns)


class WorldFeed:
    """Hands each state of the world to the cameras whose turn it is. `put` from the link's thread."""

    def __init__(self, sources: list[SimulatedSource]) -> None:
        self._sources = sources
        self._origin_ns = self._newest_ns = 0
        brush = threading.Lock()
        for source, first in zip(sources, first_turns([source.rate_hz for source in sources]), strict=True):
            source.first_turn, source.brush = first, brush

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
