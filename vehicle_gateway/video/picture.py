"""Pictures as the encoder wants them: planar YUV 4:2:0 (BT.601, limited range) at the camera's size."""

from dataclasses import dataclass
from fractions import Fraction
from mmap import mmap
from typing import Any, Protocol, Self

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from wire.messages.vehicle import CameraCalibration

_BLACK_LUMA, _NEUTRAL_CHROMA = 16, 128  # limited range
Bytes = NDArray[np.uint8]


@dataclass(frozen=True, slots=True)
class Picture:
    frame: av.VideoFrame  # yuv420p, camera's size or half of it
    capture_ns: int  # vehicle clock


class Source(Protocol):
    """Where the pictures of one camera come from. Leaving its context stops its thread and closes what it opened."""

    @property
    def kind(self) -> str:
        """simulated, file, rtsp or v4l2."""

    @property
    def is_camera(self) -> bool:
        """It shows what is in front of the car; a file never does."""

    @property
    def skipped(self) -> int:
        """Pictures that came and were not fetched in time, since start."""

    @property
    def losses(self) -> int:
        """How often the source was lost, since start."""

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        """No more pictures a second than this from now on: the machine cannot keep up, or can again. 0: none, nobody wants them.

        halved  half the camera's width and height
        """

    def take(self, timeout_s: float) -> Picture | None:
        """The newest picture not fetched before; None when none came within `timeout_s`."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...


def from_bgr(image: Bytes) -> av.VideoFrame:
    """A yuv420p frame of an (H, W, 3) BGR image; H and W even. OpenCV: a third of the time swscale takes."""
    planar: Any = cv2.cvtColor(image, cv2.COLOR_BGR2YUV_I420)
    return av.VideoFrame.from_ndarray(planar, format="yuv420p")


def planes_of(size: tuple[int, int], buffer: bytes | mmap | None = None) -> Bytes:
    """Room for a picture of that width and height, (H * 3 / 2, W), in `buffer` or its own."""
    width, height = size
    flat = np.zeros(width * height * 3 // 2, np.uint8) if buffer is None else np.frombuffer(buffer, np.uint8)
    return flat[: width * height * 3 // 2].reshape(height * 3 // 2, width)


def planar_frame(planes: Bytes) -> av.VideoFrame:
    """A frame of (H * 3 / 2, W) planes: a copy, so that the next picture can be rendered while this one is encoded."""
    return av.VideoFrame.from_ndarray(planes, format="yuv420p")


def luma(frame: av.VideoFrame) -> Bytes:
    """The luma plane as a writable (H, W) view."""
    return plane(frame, 0)


def size_of(calibration: CameraCalibration, halved: bool) -> tuple[int, int]:
    """Width and height of its pictures: even, as chroma has half of each."""
    if not halved:
        return calibration.width_px, calibration.height_px
    return calibration.width_px // 4 * 2, calibration.height_px // 4 * 2


def plane(frame: av.VideoFrame, number: int) -> Bytes:
    """A plane as a writable view without its padding."""
    part: Any = frame.planes[number]  # offers the buffer protocol, which its declaration does not say
    return np.frombuffer(part, np.uint8).reshape(part.height, part.line_size)[:, : part.width]


def fitted(width_px: int, height_px: int, into_width_px: int, into_height_px: int) -> tuple[int, int]:
    """The largest even size with the same aspect that fits; equal to `into` when the aspect differs by under 1 %."""
    scale = min(Fraction(into_width_px, width_px), Fraction(into_height_px, height_px))
    width, height = (int(size * scale) // 2 * 2 for size in (width_px, height_px))
    near = width >= 0.99 * into_width_px and height >= 0.99 * into_height_px
    return (into_width_px, into_height_px) if near else (max(width, 2), max(height, 2))


def at_camera_size(frame: av.VideoFrame, width_px: int, height_px: int) -> av.VideoFrame:
    """Any decoded frame as a writable yuv420p frame of the camera's size, black bars where the aspect differs."""
    width, height = fitted(frame.width, frame.height, width_px, height_px)
    scaled = frame.reformat(width=width, height=height, format="yuv420p")
    if (width, height) == (width_px, height_px):
        scaled.make_writable()  # the decoder may still refer to it
        return scaled
    whole = av.VideoFrame(width_px, height_px, "yuv420p")
    left, top = (width_px - width) // 4 * 2, (height_px - height) // 4 * 2
    for number, (background, step) in enumerate(((_BLACK_LUMA, 1), (_NEUTRAL_CHROMA, 2), (_NEUTRAL_CHROMA, 2))):
        target = plane(whole, number)
        target[:] = background
        target[top // step : (top + height) // step, left // step : (left + width) // step] = plane(scaled, number)
    return whole
