"""The simulated camera as a source: renders the newest state of the world; that state's time is the capture stamp.

Every picture is of a state that arrived; nothing is rendered between two. A world that stops gives no picture at all.
Not modelled: exposure time, rolling shutter, lens distortion; of sensor noise only the read noise of a sparse grid of
pixels, because noise on all of them would cost the encoder more than the whole scene.
"""

from typing import Protocol, Self

import numpy as np

from vehicle_gateway.video.picture import Bytes, Picture, from_bgr, luma
from vehicle_gateway.video.slot import NewestSlot
from wire.messages.sensing import WorldState

_NOISE_STEP_PX = 16  # one noisy pixel in 16 x 16
_EARLY_SHARE = 0.75  # a state this share of a period after the last picture is taken: states come at 60 Hz, with jitter


class Renderer(Protocol):
    def render(self, world: WorldState, out: Bytes) -> Bytes:
        """The picture of that state, BGR, (H, W, 3)."""


def is_due(stamp_ns: int, last_ns: int | None, period_ns: int) -> bool:
    """Whether a state is the one for the camera's next picture: it comes at least most of a period after the last."""
    return last_ns is None or stamp_ns < last_ns or stamp_ns - last_ns >= _EARLY_SHARE * period_ns


def missed(stamp_ns: int, last_ns: int | None, period_ns: int) -> int:
    """How many pictures are missing between two: the encoder was busy, or the world stood still."""
    return 0 if last_ns is None else max(round((stamp_ns - last_ns) / period_ns) - 1, 0)


class SimulatedSource:
    """States come in by `put` (the link's thread), pictures go out by `take` (the encoder's thread, which renders)."""

    kind, is_camera = "simulated", True

    def __init__(self, renderer: Renderer, width_px: int, height_px: int, frame_rate_hz: float) -> None:
        self._renderer = renderer
        self._image: Bytes = np.zeros((height_px, width_px, 3), np.uint8)
        self._period_ns = round(1e9 / frame_rate_hz)
        self._slot: NewestSlot[WorldState] = NewestSlot()
        self._last_ns: int | None = None
        self.skipped = 0
        self.losses = 0

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing was opened."""

    def put(self, world: WorldState, received_ns: int) -> None:
        """A state of the world, from the link. The stamp that counts is the state's own."""
        if is_due(world.stamp_ns, self._last_ns, self._period_ns):
            self._slot.put(world)

    def take(self, timeout_s: float) -> Picture | None:
        world = self._slot.take(timeout_s)
        while world is not None and not is_due(world.stamp_ns, self._last_ns, self._period_ns):
            world = self._slot.take(timeout_s)  # came while the one before was being fetched
        if world is None:
            return None
        self.skipped += missed(world.stamp_ns, self._last_ns, self._period_ns)
        self._last_ns = world.stamp_ns
        frame = from_bgr(self._renderer.render(world, self._image))
        add_read_noise(luma(frame), world.stamp_ns)
        return Picture(frame, world.stamp_ns)


def add_read_noise(luma_plane: Bytes, seed: int) -> None:
    """-1, 0 or +1 level on a sparse grid, in place: like a real sensor, never the same picture twice."""
    grid = luma_plane[::_NOISE_STEP_PX, ::_NOISE_STEP_PX]
    noise = np.random.default_rng(seed).integers(-1, 2, grid.shape, dtype=np.int8)
    grid[:] = np.clip(grid.astype(np.int16) + noise, 16, 235).astype(np.uint8)
