"""The loop of one camera, on one thread: take the newest picture, judge it, encode it, stamp it, hand it on.

It never queues. A picture that came while the last one was being encoded is replaced by a newer one and counted. While
the source gives nothing the last picture is sent again with its OLD stamp, so that a watcher sees it grow old.
"""

import logging
import threading
import zlib
from collections import deque
from collections.abc import Callable
from typing import NamedTuple

from vehicle_gateway.video import picture_motion
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.freshness import Freshness, judge
from vehicle_gateway.video.load import LATE_NS, Allowance, is_late
from vehicle_gateway.video.picture import Picture, Source, luma
from vehicle_gateway.video.picture_motion import PictureMotion
from vehicle_gateway.video.sei import stamp_nal
from wire.clock import Clock
from wire.messages.health import LoopHealth
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import CameraCalibration
from wire.pace import Lateness, scheduling
from wire.picture import EncodedPicture
from wire.stamp import Stamp

log = logging.getLogger(__name__)
Deliver = Callable[[EncodedPicture, int], None]  # the picture, and the time it was ready
_DIGEST_ROWS = 16  # one row in so many tells a new picture from a repeated one: the noise of a sensor is in every row
_LOOK_S = 0.05  # how often a camera that is not wanted looks whether it is
_REPEAT_AFTER_NS = 100_000_000  # a source that gives nothing is shown again at this interval (or 1.5 periods of a slower camera)
_LIVE_NS = 1_000_000_000  # without new content for this long the camera no longer shows the road ahead now
_SECOND_NS = 1_000_000_000


class _Encoded(NamedTuple):
    ready_ns: int
    size: int  # bytes
    encode_ns: int
    age_ns: int  # since its capture, when it was ready


class CameraLoop:
    """run() on its own thread; status() and health() from any other."""

    def __init__(
        self,
        calibration: CameraCalibration,
        source: Source,
        encoder: Encoder,
        clock: Clock,
        deliver: Deliver,
        is_wanted: Callable[[int], bool] = lambda now_ns: True,
        speed_m_s: Callable[[int], float | None] = lambda now_ns: None,
    ) -> None:
        """
        is_wanted  whether anybody needs pictures at that time; while nobody does none is encoded
        speed_m_s  of the car at that time, by its own sensors; None: not known
        """
        self.calibration = calibration
        self.encoder = encoder
        self.allowed = Allowance(calibration.frame_rate_hz)
        self._is_wanted, self._speed_m_s = is_wanted, speed_m_s
        self._source, self._clock, self._deliver = source, clock, deliver
        self._wait_s = self._repeat_after_s(calibration.frame_rate_hz)
        self._freshness, self._motion = Freshness(), PictureMotion()
        self._lateness = Lateness(round(1e9 / calibration.frame_rate_hz))
        self._previous: Picture | None = None
        self._previous_ns: int | None = None
        self._encoded: deque[_Encoded] = deque(maxlen=256)
        self._skipped_before = 0
        self._scheduling = "other"

    def run(self, halt: threading.Event) -> None:
        self._scheduling = scheduling()
        while not halt.is_set():
            if not self._is_wanted(self._clock.now_ns()):
                self._rest(halt)
                continue
            picture = self._source.take(self._wait_s) or self._previous
            if picture is not None:
                self.step(picture, self._clock.now_ns())

    def _rest(self, halt: threading.Event) -> None:
        """Until somebody wants pictures: nothing is shown again then that was seen before."""
        self._previous = self._previous_ns = None
        self._source.limit(0.0)
        while not halt.wait(_LOOK_S):
            if self._is_wanted(self._clock.now_ns()):
                self._source.take(0.0)  # from before
                self._source.limit(*self.allowed)
                return

    def limit(self, allowed: Allowance) -> None:
        """No more and no larger pictures than this from now on."""
        self.allowed = allowed
        self.encoder.limit(allowed.rate_hz)
        self._wait_s = self._repeat_after_s(allowed.rate_hz)
        self._lateness.period_ns = round(1e9 / allowed.rate_hz)
        if self._is_wanted(self._clock.now_ns()):
            self._source.limit(*allowed)

    def _repeat_after_s(self, rate_hz: float) -> float:
        """In the source's time, which is that of the clock, slow motion or not."""
        return self._clock.real_s(max(_REPEAT_AFTER_NS, round(1.5e9 / rate_hz)))

    def step(self, picture: Picture, now_ns: int) -> None:
        """One picture, from the source or once more, to whoever receives them."""
        self._note_lateness(now_ns)
        digest = _digest(picture)
        if digest != self._freshness.digest:  # what comes again is old already
            self._look(picture, now_ns)
        self._freshness = judge(self._freshness, digest, picture.capture_ns, self._motion.still)
        stamp = Stamp(self._freshness.capture_ns, self._freshness.pictures & 0xFFFFFFFF)
        unit = self.encoder.encode(picture.frame, now_ns)
        ready_ns = self._clock.now_ns()
        coded = EncodedPicture(
            camera=self.calibration.name,
            capture_ns=stamp.capture_ns,
            sequence=stamp.sequence,
            is_idr=unit.is_idr,
            annex_b=stamp_nal(stamp) + unit.annex_b,
        )
        self._deliver(coded, ready_ns)
        self._encoded.append(_Encoded(ready_ns, len(coded.annex_b), ready_ns - now_ns, ready_ns - stamp.capture_ns))
        self._previous, self._previous_ns = picture, now_ns

    def _look(self, picture: Picture, now_ns: int) -> None:
        """Does it move as the car does? A file shows another road, and is no camera anyway."""
        speed_m_s = self._speed_m_s(now_ns)
        if self._source.is_camera and picture_motion.is_due(self._motion, speed_m_s, now_ns):
            before, seen = self._motion, picture_motion.cells(luma(picture.frame))
            self._motion = picture_motion.judge(before, seen, speed_m_s, now_ns)
            if self._motion.still != before.still:
                word = "stands still while the car moves" if self._motion.still else "moves again"
                log.warning("camera %s: the picture %s", self.calibration.name, word)

    def _note_lateness(self, now_ns: int) -> None:
        if self._previous_ns is not None:
            self._lateness.add(self._previous_ns + self._lateness.period_ns, now_ns)

    def status(self, now_ns: int, watching: int) -> CameraStatus:
        recent = self._last_second(now_ns)
        state = self._freshness
        return CameraStatus(
            stamp_ns=now_ns,
            camera=self.calibration.name,
            source=self._source.kind,
            live=self._source.is_camera and state.pictures > 0 and now_ns - state.capture_ns <= _LIVE_NS,
            newest_capture_ns=state.capture_ns,
            frames=state.pictures,
            repeated=state.repeated,
            bitrate_kbps=sum(each.size for each in recent) * 8 / 1000,
            encode_ms=sum(each.encode_ns for each in recent) / 1e6 / len(recent) if recent else 0.0,
            watching=watching,
            wanted=self._is_wanted(now_ns),
            skipped=self._source.skipped,
            nominal_hz=self.calibration.frame_rate_hz,
            rate_hz=self.allowed.rate_hz,
            halved=self.allowed.halved,
        )

    def was_late(self, now_ns: int) -> bool:
        """Whether too many pictures of the last second were late or missing. To be asked once a second."""
        recent, skipped = self._last_second(now_ns), self._source.skipped
        late = sum(each.age_ns > LATE_NS for each in recent)
        missing, self._skipped_before = skipped - self._skipped_before, skipped
        return is_late(len(recent), late, missing)

    def _last_second(self, now_ns: int) -> list["_Encoded"]:
        return [each for each in tuple(self._encoded) if now_ns - each.ready_ns <= _SECOND_NS]

    def health(self, process: str, now_ns: int) -> LoopHealth:
        dropped = {
            "pictures skipped": self._source.skipped,
            "source lost": self._source.losses,
            "picture stood still while the car moved": self._motion.times,
        }
        return self._lateness.health(
            process,
            f"camera {self.calibration.name}",
            now_ns,
            self._scheduling,
            {reason: count for reason, count in dropped.items() if count},
        )


def _digest(picture: Picture) -> int:
    return zlib.crc32(luma(picture.frame)[::_DIGEST_ROWS].tobytes())
