"""The [vehicle_gateway.video] section: where each camera's pictures come from and how they are encoded."""

from dataclasses import dataclass
from typing import Annotated

from msgspec import Meta

from wire.messages.base import Message, Name
from wire.messages.vehicle import CameraCalibration

# simulated | file:PATH | rtsp:URL (or a plain rtsp://...) | v4l2:/dev/videoN
SourceText = Annotated[str, Meta(pattern=r"^(simulated|file:.+|rtsp:.+|v4l2:/dev/.+)$", max_length=1000)]
_REFERENCE_PIXELS_PER_S = 1280 * 720 * 30  # what bitrate_kbps is given for


class VideoSettings(Message):
    sources: dict[Name, SourceText] = {}  # by camera name; a camera that is not listed is simulated
    bitrate_kbps: Annotated[int, Meta(ge=250, le=30000)] = 4000  # at 1280x720, 30 Hz; others in proportion
    bitrate_floor_kbps: Annotated[int, Meta(ge=100, le=30000)] = 800  # congestion never takes the rate below this
    preset: Annotated[str, Meta(pattern="^(ultrafast|superfast|veryfast)$")] = "ultrafast"  # 4.6, 7.9, 13.6 ms at 720p
    vbv_frames: Annotated[float, Meta(ge=1.0, le=30.0)] = 3.0  # rate buffer in mean pictures
    idr_interval_s: Annotated[float, Meta(ge=0.5, le=10.0)] = 2.0  # what a late joiner or a seek may wait
    encoder_threads: Annotated[int, Meta(ge=1, le=8)] = 1  # per camera; more than one costs about 0.5 ms a slice


@dataclass(frozen=True, slots=True)
class SourceChoice:
    kind: str  # simulated, file, rtsp, v4l2
    place: str  # path, URL or device; "" for the simulated camera


def parse_source(text: str) -> SourceChoice:
    """What a source text names. `text` has been checked against SourceText."""
    kind, _, place = text.partition(":")
    return SourceChoice(kind, text if place.startswith("//") else place)


def camera_bitrate_bps(kbps: int, calibration: CameraCalibration) -> int:
    """The bit rate of one camera: `kbps` scaled by its pixels per second against 1280x720 at 30 Hz."""
    pixels_per_s = calibration.width_px * calibration.height_px * calibration.frame_rate_hz
    return round(kbps * 1000 * pixels_per_s / _REFERENCE_PIXELS_PER_S)
