"""The last ten seconds of the front camera as small pictures, and their replay while a request is open.

Keeps 10 pictures a second, 400 x 225 pixels each: 36 MB, made once. While a request is open nothing is kept: what led to it stays.
Decides nothing; the clock is an argument.
"""

from dataclasses import dataclass

import cv2
import numpy as np
import numpy.typing as npt

WIDE_PX, HIGH_PX = 400, 225  # what the panel has on a 1080p screen
SPAN_NS, PERIOD_NS = 10_000_000_000, 100_000_000
SPEED = 2.0  # ours: a budget of 15 s leaves no ten seconds to look back
HOLD_NS = 700_000_000  # the newest picture stands still before it begins again
_EARLY_NS = 15_000_000  # a camera of 30 Hz does not hit 100 ms; this much early counts
_SLOTS = SPAN_NS // PERIOD_NS


@dataclass(frozen=True, slots=True, eq=False)
class ReplayFrame:
    """One small picture; the same object for the same picture, so that it is drawn once."""

    image: npt.NDArray[np.uint8]  # (HIGH_PX, WIDE_PX, 4) BGRA
    before_s: float  # how long before the request
    share: float  # of the whole replay, 0..1


class ReplayRing:
    def __init__(self) -> None:
        self._images = np.zeros((_SLOTS, HIGH_PX, WIDE_PX, 4), np.uint8)
        self._kept: list[tuple[int, int]] = []  # (tower clock, slot), oldest first
        self._next = 0
        self._since_ns: int | None = None  # tower clock: the replay's begin
        self._frames: list[ReplayFrame] = []

    def is_due(self, now_ns: int) -> bool:
        """Whether `keep` would keep a picture now: scaling those it passes over is saved."""
        return self._since_ns is None and not (self._kept and now_ns - self._kept[-1][0] < PERIOD_NS - _EARLY_NS)

    def keep(self, image: npt.NDArray[np.uint8], now_ns: int) -> None:
        """A new picture of the live video; most are passed over. Costs 0.2 ms ten times a second."""
        if not self.is_due(now_ns):
            return
        cv2.resize(image, (WIDE_PX, HIGH_PX), dst=self._images[self._next], interpolation=cv2.INTER_LINEAR)
        self._kept = [(at, slot) for at, slot in self._kept if slot != self._next and now_ns - at <= SPAN_NS]
        self._kept.append((now_ns, self._next))
        self._next = (self._next + 1) % _SLOTS

    def follow(self, asked: bool, now_ns: int) -> None:
        """asked  a request is open: its replay begins with it and ends with it"""
        if asked and self._since_ns is None:
            self._since_ns, self._frames = now_ns, self._made(now_ns)
        elif not asked and self._since_ns is not None:
            self._since_ns, self._frames = None, []

    def frame(self, now_ns: int) -> ReplayFrame | None:
        """What the replay shows now; None without one."""
        if self._since_ns is None or not self._frames:
            return None
        span_ns = round(self._frames[0].before_s * 1e9)
        played_ns = int((now_ns - self._since_ns) * SPEED) % (span_ns + round(HOLD_NS * SPEED))
        before_s = (span_ns - played_ns) / 1e9
        return next((frame for frame in reversed(self._frames) if frame.before_s >= before_s), self._frames[-1])

    def _made(self, now_ns: int) -> list[ReplayFrame]:
        recent = [(at, slot) for at, slot in self._kept if now_ns - at <= SPAN_NS]
        if not recent:
            return []
        span = max(now_ns - recent[0][0], 1)
        return [ReplayFrame(self._images[slot], (now_ns - at) / 1e9, 1 - (now_ns - at) / span) for at, slot in recent]
