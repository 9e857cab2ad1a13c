"""A part of a decoded picture as pixels of a given size. Pure.

The three planes are scaled first and then turned into BGRA: half the bytes to scale, and only what is shown is converted.
Measured 2026-11 at 1280x720 to 800x450: 0.5 ms, libswscale 0.75 ms, conversion before scaling 1.0 ms.
Colours: BT.601, limited range, as the sender's.
"""

from typing import Any

import cv2
import numpy as np
from av import VideoFrame
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]
Part = tuple[int, int, int, int]  # left, top, width, height in pixels of the picture


def to_bgra(frame: VideoFrame, part: Part | None = None, size: tuple[int, int] | None = None) -> Bytes:
    """(height, width, 4) BGRA, contiguous, of a yuv420p frame; its lowest bit may be cut off an odd part.

    part  what is shown; None: all
    size  width and height of the result; None: those of the part
    """
    whole = (0, 0, frame.width, frame.height)
    left, top, wide, high = part or whole
    width, height = size or (wide, high)
    if frame.format.name != "yuv420p" or ((left, top, wide, high) == whole and (width, height) == (wide, high)):
        return _any_format(frame, (left, top, wide, high), (width, height))
    even = (width + width % 2, height + height % 2)
    planar = np.empty((even[1] * 3 // 2, even[0]), np.uint8)
    for number, target in enumerate(_planes_of(planar, even)):
        shift = 1 if number else 0
        source = _plane(frame, number)[top >> shift : (top + high) >> shift, left >> shift : (left + wide) >> shift]
        cv2.resize(source, target.shape[::-1], dst=target, interpolation=cv2.INTER_LINEAR)
    bgra = np.asarray(cv2.cvtColor(planar, cv2.COLOR_YUV2BGRA_I420), np.uint8)
    return bgra if even == (width, height) else np.ascontiguousarray(bgra[:height, :width])


def _any_format(frame: VideoFrame, part: Part, size: tuple[int, int]) -> Bytes:
    """By libswscale: faster where nothing is scaled, and it reads every format."""
    left, top, wide, high = part
    image = np.asarray(frame.to_ndarray(format="bgra"), np.uint8)[top : top + high, left : left + wide]
    scaled = image if (wide, high) == size else cv2.resize(image, size, interpolation=cv2.INTER_LINEAR)
    return np.ascontiguousarray(scaled, np.uint8)


def _planes_of(planar: Bytes, size: tuple[int, int]) -> tuple[Bytes, Bytes, Bytes]:
    """Y, U and V of an I420 buffer as views; both sizes even."""
    width, height = size
    flat, luma, chroma = planar.reshape(-1), width * height, width * height // 4
    half = (height // 2, width // 2)
    return (
        flat[:luma].reshape(height, width),
        flat[luma : luma + chroma].reshape(half),
        flat[luma + chroma :].reshape(half),
    )


def _plane(frame: VideoFrame, number: int) -> Bytes:
    plane: Any = frame.planes[number]  # offers the buffer protocol, which its declaration does not say
    return np.frombuffer(plane, np.uint8).reshape(-1, plane.line_size)[: plane.height, : plane.width]
