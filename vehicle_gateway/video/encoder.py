"""One camera's H.264 encoder: x264 by PyAV, no delay, no B-frames, an IDR every interval and on request.

Options and their reasons: zerolatency removes look-ahead; a rate buffer of a few pictures bounds the largest one; SPS
and PPS stand in front of every IDR. (Tried with PyAV 18.1.0.)
It never waits and never holds a picture back: one picture in, one access unit out.
"""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import av
from av.video.frame import PictureType

from vehicle_gateway.video.rate import (
    Rate,
    RateLimits,
    Rates,
    after_estimate,
    after_loss,
    applied_bps,
    joined,
    led_by,
    left,
    shared_bps,
)
from vehicle_gateway.video.settings import VideoSettings, camera_bitrate_bps
from wire.messages.vehicle import CameraCalibration

_TIME_BASE = Fraction(1, 1_000_000)
_REQUEST_INTERVAL_NS = 250_000_000  # a lossy link may ask for a key picture with every loss: at most four a second


@dataclass(frozen=True, slots=True)
class AccessUnit:
    annex_b: bytes
    is_idr: bool


def idr_is_due(now_ns: int, last_idr_ns: int | None, requested: bool, interval_ns: int) -> bool:
    """Whether the next picture must be an IDR. last_idr_ns None: there was none yet."""
    if last_idr_ns is None:
        return True
    since_ns = now_ns - last_idr_ns
    return since_ns >= interval_ns or (requested and since_ns >= _REQUEST_INTERVAL_NS)


class Encoder:
    """encode() from one thread; the receivers' feedback (request_idr, note_...) from any one other."""

    def __init__(self, calibration: CameraCalibration, settings: VideoSettings, real_time_factor: float = 1.0) -> None:
        self._real_time_factor = real_time_factor
        ceiling_bps = camera_bitrate_bps(settings.bitrate_kbps, calibration)
        floor_bps = min(camera_bitrate_bps(settings.bitrate_floor_kbps, calibration), ceiling_bps)
        self._limits = RateLimits(floor_bps, ceiling_bps)
        self._rates: Rates = {}  # never changed, only replaced: the other thread reads it
        self._full_size = self._size = calibration.width_px, calibration.height_px
        self._applied_bps = ceiling_bps
        self._applied_hz = self._wanted_hz = calibration.frame_rate_hz
        self._interval_ns = round(settings.idr_interval_s * 1e9)
        self._last_idr_ns: int | None = None
        self._requested = False
        self._origin_ns: int | None = None
        self._settings = settings
        self._context = _open_context(self._size, settings, ceiling_bps, self._applied_hz)

    def limit(self, rate_hz: float) -> None:
        """So many pictures a second come from now on: x264 shares the bit rate among them, whenever they come."""
        self._wanted_hz = rate_hz

    def request_idr(self) -> None:
        """The next picture becomes an IDR (a new watcher, a lost packet)."""
        self._requested = True

    def note_session(self, watcher: str, watched: bool) -> None:
        """A watcher's session began, or it is over."""
        self._rates = joined(self._rates, watcher, self._limits) if watched else left(self._rates, watcher)

    def note_leader(self, watcher: str) -> None:
        """This watcher's operator drives."""
        self._rates = led_by(self._rates, watcher)

    def note_estimate(self, watcher: str, estimate_bps: float) -> None:
        """The receiver's estimate of what its path carries for this camera.

        The receiver counts real seconds, we those of the drive. In slow motion fewer bits come in one of his than we send in one of
        ours, and as he promises at most half more than came, the rate would sink to its floor.
        """
        self._note(watcher, lambda rate: after_estimate(rate, estimate_bps / self._real_time_factor))

    def note_loss(self, watcher: str, lost: float) -> None:
        """The share of packets lost since the receiver's last report, 0..1."""
        self._note(watcher, lambda rate: after_loss(rate, lost, self._limits))

    def _note(self, watcher: str, change: Callable[[Rate], Rate]) -> None:
        if watcher in self._rates:  # a last report may come when the session is over
            self._rates = {**self._rates, watcher: change(self._rates[watcher])}

    def encode(self, frame: av.VideoFrame, now_ns: int) -> AccessUnit:
        """One yuv420p frame, of any size: a new one begins with an IDR. now_ns must grow from call to call."""
        idr = idr_is_due(now_ns, self._last_idr_ns, self._requested, self._interval_ns)
        idr = self._follow(idr, (frame.width, frame.height)) or idr
        if idr:
            self._last_idr_ns, self._requested = now_ns, False
        self._origin_ns = now_ns if self._origin_ns is None else self._origin_ns
        frame.pts, frame.time_base = (now_ns - self._origin_ns) // 1000, _TIME_BASE
        frame.pict_type = PictureType.I if idr else PictureType.NONE
        packets = self._context.encode(frame)
        return AccessUnit(b"".join(bytes(packet) for packet in packets), any(packet.is_keyframe for packet in packets))

    def _follow(self, idr: bool, size: tuple[int, int]) -> bool:
        """Whether the encoder was opened anew for another bit rate, picture rate or size. (x264's rate buffer cannot be changed
        through PyAV, and with the old buffer a new rate swings for seconds.) The IDR that follows fits the new buffer."""
        wanted_bps = applied_bps(self._applied_bps, shared_bps(self._rates, self._limits), idr)
        wanted = wanted_bps, self._wanted_hz, size
        if wanted == (self._applied_bps, self._applied_hz, self._size):
            return False
        self._applied_bps, self._applied_hz, self._size = wanted
        narrower = size[0] / self._full_size[0]  # twice the bits for a pixel of half the width: it is shown larger
        self._context = _open_context(size, self._settings, round(wanted_bps * narrower), self._wanted_hz)
        return True


def _open_context(size: tuple[int, int], settings: VideoSettings, bitrate_bps: int, rate_hz: float) -> av.VideoCodecContext:
    context = av.CodecContext.create("libx264", "w")
    (context.width, context.height), context.pix_fmt = size, "yuv420p"
    context.framerate = Fraction(rate_hz).limit_denominator(1001)
    context.time_base = _TIME_BASE
    context.bit_rate = bitrate_bps
    context.thread_count = settings.encoder_threads
    context.options = {
        "preset": settings.preset,
        "tune": "zerolatency",
        "forced-idr": "1",
        "maxrate": str(bitrate_bps),
        "bufsize": str(round(bitrate_bps / rate_hz * settings.vbv_frames)),
        "x264-params": "keyint=infinite:scenecut=0:bframes=0:repeat-headers=1",  # we time the IDR
    }
    return context
