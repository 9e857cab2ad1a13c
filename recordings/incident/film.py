"""The pictures the operator saw: which one a command says was on screen, decoded from the recorded video. Reads one recording.

Which picture it was comes from the newest command that had arrived in the car (`displayed_capture_ns`), and from the window's own
account where there is none. Its age at a moment is that moment minus its capture stamp, both on the vehicle clock.
"""

import base64
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import av
import cv2
import numpy as np

from recordings.incident.evidence import Evidence
from recordings.incident.spans import newest
from recordings.read import Recording
from wire.picture import EncodedPicture

FRAMES = 8  # of a strip
IDR_WITHIN_NS = 10_000_000_000  # the longest interval that [vehicle_gateway.video] idr_interval_s allows
WIDTH_PX, JPEG_QUALITY = 440, 78  # ours: readable in a dossier of a few megabytes
FROZEN_S = 0.2  # StVFernLV, as the car: longer without a new picture counts as none


class Seen(NamedTuple):
    """What stood on the operator's screen at one moment."""

    t_s: float
    camera: str
    capture_s: float | None  # seconds from T; None: nothing was on screen
    said_by: str  # command, window
    shown_after_ms: float | None  # capture to screen, by the window's clock
    jpeg: str  # base64; "" when the recording does not hold that picture, or not what it is built on

    @property
    def age_ms(self) -> float:
        return 0.0 if self.capture_s is None else (self.t_s - self.capture_s) * 1e3


def moments(before_s: float, after_s: float, count: int = FRAMES) -> tuple[float, ...]:
    """Evenly over the window, T among them."""
    evenly = [-before_s + (before_s + after_s) * number / (count - 1) for number in range(count)]
    nearest = min(range(count), key=lambda number: abs(evenly[number]))
    evenly[nearest] = 0.0
    return tuple(evenly)


def film(recording: Recording, evidence: Evidence) -> dict[str, tuple[Seen, ...]]:
    """A strip per camera, the required ones first."""
    times = moments(evidence.before_s, evidence.after_s)
    required = {camera.name for camera in evidence.vehicle.cameras if camera.required} if evidence.vehicle else set()
    return {
        camera: _strip(recording, evidence, camera, times)
        for camera in sorted(recording.cameras, key=lambda name: (name not in required, name))
    }


def _strip(recording: Recording, evidence: Evidence, camera: str, times: tuple[float, ...]) -> tuple[Seen, ...]:
    captured = [_on_screen(evidence, camera, t_s) for t_s in times]
    pictures = decoded(recording, camera, {stamp for stamp, _ in captured if stamp})
    latencies = _latencies(evidence, camera)
    return tuple(
        Seen(
            t_s=t_s,
            camera=camera,
            capture_s=evidence.since_s(stamp) if stamp else None,
            said_by=said_by,
            shown_after_ms=latencies.get(stamp),
            jpeg=pictures.get(stamp, ""),
        )
        for t_s, (stamp, said_by) in zip(times, captured, strict=True)
    )


def _on_screen(evidence: Evidence, camera: str, t_s: float) -> tuple[int, str]:
    """Capture stamp and who says so; 0 when nobody does."""
    command = newest(evidence.commands, t_s)
    if command is not None and camera in command.displayed_capture_ns:
        return command.displayed_capture_ns[camera], "command"
    window = newest(evidence.windows, t_s)
    return (window.displayed_capture_ns.get(camera, 0), "window") if window else (0, "")


def _latencies(evidence: Evidence, camera: str) -> dict[int, float]:
    """Capture to screen [ms] by capture stamp, through the offset between the clocks that the tower measured."""
    operator = next((each for _, each in reversed(evidence.operators) if each.clock_bound_ns > 0), None)
    if operator is None:
        return {}
    return {
        frame.capture_ns: (frame.shown_ns + operator.clock_offset_ns - frame.capture_ns) / 1e6
        for _, window in evidence.windows
        for frame in window.shown
        if frame.camera == camera
    }


def decoded(recording: Recording, camera: str, stamps: set[int]) -> dict[int, str]:
    """JPEG as base64 of the pictures with these capture stamps, as far as the recording holds them."""
    if not stamps:
        return {}
    offset_ns = int(recording.metadata.get("clock", {}).get("utc_minus_vehicle_ns", 0))
    from_ns = min(stamps) + offset_ns - IDR_WITHIN_NS
    until_ns = max(stamps) + offset_ns + IDR_WITHIN_NS  # of arrival: a late picture is still this one
    pictures = (picture for _, picture in recording.pictures(camera, max(from_ns, 0), until_ns))
    return {stamp: _jpeg(image) for stamp, image in _decode(pictures, max(stamps)) if stamp in stamps}


def _decode(pictures: Iterable[EncodedPicture], last_ns: int) -> Iterator[tuple[int, Any]]:
    """(capture stamp, BGR image); one picture in, one out: there are no B-frames.

    From the first IDR on, and behind a picture that is missing from the next one on: what is built on it was not seen so.
    """
    codec: Any = av.CodecContext.create("h264", "r")
    codec.thread_count = 1
    whole, expected = False, 0
    for picture in pictures:
        whole = picture.is_idr or (whole and picture.sequence == expected)
        expected = picture.sequence + 1
        if not whole:
            continue
        packet = av.Packet(picture.annex_b)
        packet.pts = picture.capture_ns
        try:
            frames = codec.decode(packet)
        except av.error.FFmpegError:  # a damaged picture is one picture less
            continue
        yield from ((frame.pts, frame.to_ndarray(format="bgr24")) for frame in frames)
        if picture.capture_ns >= last_ns:
            break
    yield from ((frame.pts, frame.to_ndarray(format="bgr24")) for frame in codec.decode(None))


def _jpeg(image: "np.ndarray[Any, Any]") -> str:
    height, width = image.shape[:2]
    small = cv2.resize(image, (WIDTH_PX, round(height * WIDTH_PX / width)), interpolation=cv2.INTER_AREA)
    return base64.b64encode(cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])[1].tobytes()).decode("ascii")
