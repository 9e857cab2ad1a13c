"""RECORDED FILE - NOT LIVE, across the top and the bottom of every picture of a file: it is not the road ahead."""

import cv2
import numpy as np
from av import VideoFrame

from vehicle_gateway.video.picture import Bytes, plane

TEXT = "RECORDED FILE - NOT LIVE"
_FONT, _BAND_SHARE, _TEXT_SHARE = cv2.FONT_HERSHEY_SIMPLEX, 12, 0.55  # band = height/12; text = 0.55 of the band
_DARK, _BRIGHT, _NEUTRAL = 16, 235, 128  # limited range


class Watermark:
    """The bands for one picture size, drawn once."""

    def __init__(self, width_px: int, height_px: int) -> None:
        self._rows = max(height_px // _BAND_SHARE // 4 * 4, 16)
        self._band = _band(width_px, self._rows)

    def draw(self, frame: VideoFrame) -> None:
        """Into a writable yuv420p frame of that size."""
        luma = plane(frame, 0)
        luma[: self._rows] = self._band
        luma[-self._rows :] = self._band
        for number in (1, 2):
            chroma = plane(frame, number)
            chroma[: self._rows // 2] = _NEUTRAL
            chroma[-(self._rows // 2) :] = _NEUTRAL


def _band(width_px: int, rows: int) -> Bytes:
    """(rows, width) luma: bright text in the middle of a dark band, made to fit."""
    band = np.full((rows, width_px), _DARK, np.uint8)
    (width, height), _ = cv2.getTextSize(TEXT, _FONT, 1.0, 2)
    scale = min(_TEXT_SHARE * rows / height, 0.95 * width_px / width)
    thickness = max(1, round(2 * scale))
    (width, height), _ = cv2.getTextSize(TEXT, _FONT, scale, thickness)
    corner = ((width_px - width) // 2, (rows + height) // 2)
    cv2.putText(band, TEXT, corner, _FONT, scale, _BRIGHT, thickness, cv2.LINE_AA)
    return band
