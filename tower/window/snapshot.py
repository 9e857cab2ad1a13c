"""One telling picture of the window for the session's folder: where the operator had to leave the own lane farthest.

The choice is pure. Encoding runs on a thread of its own, and not while the operator drives; the file appears whole or not at all.
"""

import os
import threading
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import cv2
import numpy as np
import numpy.typing as npt
import pygame

from wire.messages.vehicle import Mode

_AFTER_NS = 1_000_000_000  # of driving: then there is a picture in any case
_BETWEEN_NS = 2_000_000_000
_FARTHER_M = 0.05  # a smaller gain is not worth a new copy


@dataclass(frozen=True, slots=True)
class Choice:
    """What was saved so far."""

    remote_since_ns: int | None = None  # tower clock
    saved_ns: int | None = None
    saved_m: float = -1.0  # offset from the own lane in the saved picture; -1: unknown


def choose(before: Choice, mode: Mode | None, from_lane_m: float | None, picture_live: bool, now_ns: int) -> tuple[Choice, bool]:
    """Whether the window as it is now is worth saving.

    from_lane_m  distance of the car from the middle of its own lane, >= 0; None: unknown
    """
    if mode is not Mode.REMOTE:
        return Choice(None, before.saved_ns, before.saved_m), False
    since = before.remote_since_ns if before.remote_since_ns is not None else now_ns
    offset = from_lane_m if from_lane_m is not None else -1.0
    waited = before.saved_ns is None or now_ns - before.saved_ns >= _BETWEEN_NS
    telling = before.saved_ns is None or offset > before.saved_m + _FARTHER_M
    if now_ns - since < _AFTER_NS or not (picture_live and waited and telling):
        return Choice(since, before.saved_ns, before.saved_m), False
    return Choice(since, now_ns, offset), True


class SnapshotWriter:
    """Keeps the best picture until the operator no longer drives: to encode it takes as long as several pictures may."""

    def __init__(self, path: Path | None) -> None:
        self._path = path
        self._kept: pygame.Surface | None = None
        self._busy: threading.Thread | None = None
        self.failed = 0

    def __enter__(self) -> "SnapshotWriter":
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self._finish()
        self.write()
        self._finish()

    def keep(self, surface: pygame.Surface) -> None:
        """A copy of the surface, in place of the one kept before."""
        if self._path is not None:
            self._kept = surface.copy()

    def write(self) -> None:
        """Begins to write what is kept, unless another is still being written. Nothing kept: nothing happens."""
        if self._path is None or self._kept is None or (self._busy is not None and self._busy.is_alive()):
            return
        kept, self._kept = self._kept, None
        self._busy = threading.Thread(target=self._encode, args=(kept, self._path), name="snapshot", daemon=True)
        self._busy.start()

    def _finish(self) -> None:
        if self._busy is not None:
            self._busy.join()

    def _encode(self, surface: pygame.Surface, path: Path) -> None:
        done, data = cv2.imencode(".png", pixels_of(surface), [cv2.IMWRITE_PNG_COMPRESSION, 3])
        part = path.with_suffix(".part")
        try:
            part.write_bytes(data.tobytes() if done else b"")
            os.replace(part, path)
        except OSError:
            self.failed += 1


def pixels_of(surface: pygame.Surface) -> npt.NDArray[np.uint8]:
    """A copy (H, W, 3) BGR of a surface with 8 bits each."""
    rgb = pygame.surfarray.array3d(surface)
    return np.ascontiguousarray(rgb.swapaxes(0, 1)[..., ::-1])
