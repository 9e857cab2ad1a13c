"""Sources that PyAV reads: a file (looped at its own rate, watermarked), an RTSP camera, a V4L2 camera.

The capture stamp is the moment the picture came out of the decoder: exposure, transport and decoding before that are
not in it. A file is never live. RTSP and V4L2 were not tried: there was no camera.
A source that cannot be opened at start is an error that names the fix; one lost while driving is counted, and opened
again with back-off, while the last picture stands and grows old.
"""

import logging
import threading
from collections.abc import Iterator
from typing import Any, Self

import av

from vehicle_gateway.video.picture import Picture, at_camera_size, size_of
from vehicle_gateway.video.settings import SourceChoice
from vehicle_gateway.video.slot import NewestSlot
from vehicle_gateway.video.watermark import Watermark
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.messages.vehicle import CameraCalibration

log = logging.getLogger(__name__)
_OPEN_TIMEOUT_S, _READ_TIMEOUT_S = 5.0, 2.0
_NEVER_NS = 2**62
_LIMIT_SHARE = 0.9  # of the period asked for: pictures come with jitter
_BACK_OFF_FIRST_S, _BACK_OFF_MAX_S = 0.5, 5.0
_FIX = {
    "file": "name a video file that FFmpeg can read",
    "rtsp": "check that the camera is on, its address and its password",
    "v4l2": "check that the device exists (ls /dev/video*) and that this user is in the group `video`",
}


class MediaSource:
    """One thread reads and decodes into one slot. Raises ConfigurationError when it cannot be opened at start."""

    def __init__(self, choice: SourceChoice, calibration: CameraCalibration, clock: Clock) -> None:
        self.kind, self.is_camera = choice.kind, choice.kind != "file"
        self.losses = 0
        self._choice, self._calibration, self._clock = choice, calibration, clock
        self._halved = False
        sizes = (size_of(calibration, halved) for halved in (False, True))
        self._watermarks = [Watermark(*size) for size in sizes] if choice.kind == "file" else []
        self._slot: NewestSlot[Picture] = NewestSlot()
        self._least_ns = self._taken_ns = 0  # between two pictures; when the last one was taken
        self._halt = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"{choice.kind}-{calibration.name}", daemon=True)
        self._container = self._open_at_start()

    @property
    def skipped(self) -> int:
        return self._slot.replaced

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._halt.set()
        self._thread.join(timeout=_READ_TIMEOUT_S + 1.0)

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        rests, is_full = rate_hz <= 0, rate_hz >= self._calibration.frame_rate_hz
        self._least_ns = _NEVER_NS if rests else 0 if is_full else round(_LIMIT_SHARE * 1e9 / rate_hz)
        self._halved = halved

    def take(self, timeout_s: float) -> Picture | None:
        return self._slot.take(timeout_s)

    def _open_at_start(self) -> Any:
        where = f"[vehicle_gateway.video] sources.{self._calibration.name} = '{self._choice.kind}:{self._choice.place}'"
        try:
            container = open_container(self._choice, self._calibration)
            next(container.decode(video=0))  # what opens may still be corrupt
        except (av.FFmpegError, OSError, IndexError, StopIteration) as error:
            reason = "holds no video" if isinstance(error, IndexError | StopIteration) else f"cannot be read: {error}"
            raise ConfigurationError(f"{where}: {reason}; {_FIX[self.kind]}") from None
        if self.kind == "file":
            container.seek(0)
        return container

    def _run(self) -> None:
        container: Any = self._container
        back_off_s = _BACK_OFF_FIRST_S
        while not self._halt.is_set():
            pictures = self._read(container) if container is not None else 0
            if self._halt.is_set():
                break
            if self.kind == "file" and pictures:
                container.seek(0)  # the end of a file is its beginning
                continue
            back_off_s = _BACK_OFF_FIRST_S if pictures else min(2 * back_off_s, _BACK_OFF_MAX_S)
            container = self._reopen(container, back_off_s)
        if container is not None:
            container.close()

    def _read(self, container: Any) -> int:
        """Hand over pictures until the source ends or fails; how many came."""
        pictures = 0
        try:
            for frame in self._paced(container):
                pictures += 1
                now_ns = self._clock.now_ns()
                if now_ns - self._taken_ns >= self._least_ns:
                    self._taken_ns = now_ns
                    self._slot.put(self._picture(frame, now_ns))
        except (av.FFmpegError, OSError) as error:
            log.warning("camera %s: %s lost: %s", self._calibration.name, self.kind, error)
        return pictures

    def _reopen(self, container: Any, back_off_s: float) -> Any | None:
        self.losses += 1
        if container is not None:
            container.close()
        self._halt.wait(back_off_s)
        try:
            return open_container(self._choice, self._calibration)
        except (av.FFmpegError, OSError) as error:
            log.warning("camera %s: %s not there yet: %s", self._calibration.name, self.kind, error)
            return None

    def _paced(self, container: Any) -> Iterator[av.VideoFrame]:
        """The frames of a camera as they come; those of a file at its own rate."""
        start_ns, first_s = self._clock.now_ns(), None
        for frame in container.decode(video=0):
            if self.kind == "file" and frame.time is not None:
                first_s = frame.time if first_s is None else first_s
                due_ns = start_ns + round((frame.time - first_s) * 1e9)
                self._halt.wait(self._clock.real_s(max(due_ns - self._clock.now_ns(), 0)))
            if self._halt.is_set():
                return
            yield frame

    def _picture(self, frame: av.VideoFrame, capture_ns: int) -> Picture:
        halved = self._halved
        sized = at_camera_size(frame, *size_of(self._calibration, halved))
        if self._watermarks:
            self._watermarks[halved].draw(sized)
        return Picture(sized, capture_ns)


def open_container(choice: SourceChoice, calibration: CameraCalibration) -> Any:
    """The opened input. Raises av.FFmpegError or OSError."""
    timeout = (_OPEN_TIMEOUT_S, _READ_TIMEOUT_S)
    if choice.kind == "v4l2":
        options = {"video_size": f"{calibration.width_px}x{calibration.height_px}", "framerate": f"{calibration.frame_rate_hz:g}"}
        return av.open(choice.place, format="v4l2", options=options, timeout=timeout)
    if choice.kind == "rtsp":
        options = {"rtsp_transport": "tcp", "fflags": "nobuffer", "flags": "low_delay", "max_delay": "0"}
        return av.open(choice.place, options=options, timeout=timeout)
    return av.open(choice.place)
