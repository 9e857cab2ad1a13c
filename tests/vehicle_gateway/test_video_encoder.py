"""The encoder: when an IDR comes, what stands in it, and that every picture can be decoded at once."""

import av
import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from vehicle_gateway.video.encoder import Encoder, idr_is_due
from vehicle_gateway.video.picture import from_bgr
from vehicle_gateway.video.settings import VideoSettings, camera_bitrate_bps
from wire.messages.vehicle import CameraCalibration

RATE_HZ = 30
PERIOD_NS = 33_333_333
S = 1_000_000_000
CAMERA = CameraCalibration(
    name="front",
    required=True,
    width_px=192,
    height_px=108,
    frame_rate_hz=RATE_HZ,
    focal_length_px=120.0,
    x_m=1.7,
    y_m=0.0,
    z_m=1.3,
    yaw_rad=0.0,
    pitch_rad=0.0,
)
NOISE = np.random.default_rng(7).integers(0, 255, (108, 400, 3), dtype=np.uint8)
SMOOTH = np.kron(np.random.default_rng(8).integers(40, 215, (9, 40, 1)), np.ones((12, 10, 3))).astype(np.uint8)
SPS, PPS, IDR = 7, 8, 5


def picture(number: int) -> av.VideoFrame:
    return from_bgr(np.ascontiguousarray(NOISE[:, number % 200 : number % 200 + 192]))


def nal_types(annex_b: bytes) -> list[int]:
    """Types of the NAL units, found plainly by their three-byte start codes."""
    return [part[0] & 31 for part in annex_b.split(b"\x00\x00\x01")[1:]]


def encode(count: int, requests: tuple[int, ...] = (), settings: VideoSettings | None = None) -> list[bytes]:
    """`count` coded pictures at 30 Hz; before those in `requests` an IDR is asked for."""
    encoder = Encoder(CAMERA, settings or VideoSettings(bitrate_kbps=20000))
    units = []
    for number in range(count):
        if number in requests:
            encoder.request_idr()
        unit = encoder.encode(picture(number), 5 * S + number * PERIOD_NS)
        assert unit.is_idr == (IDR in nal_types(unit.annex_b))
        units.append(unit.annex_b)
    return units


def idr_numbers(units: list[bytes]) -> list[int]:
    return [number for number, unit in enumerate(units) if IDR in nal_types(unit)]


def test_an_idr_comes_first_and_every_two_seconds() -> None:
    numbers = idr_numbers(encode(200))
    assert numbers[0] == 0
    assert all(60 <= late - early <= 61 for early, late in zip(numbers, numbers[1:], strict=False))
    assert len(numbers) == 4


def test_an_idr_that_is_asked_for_is_the_next_picture() -> None:
    assert idr_numbers(encode(40, requests=(17,))) == [0, 17]


def test_a_storm_of_requests_gives_at_most_four_idr_a_second() -> None:
    numbers = idr_numbers(encode(60, requests=tuple(range(60))))
    assert 7 <= len(numbers) <= 8


def test_parameter_sets_stand_in_front_of_every_idr() -> None:
    for number in idr_numbers(units := encode(70)):
        types = nal_types(units[number])
        assert types.index(SPS) < types.index(PPS) < types.index(IDR)


def test_every_picture_is_decoded_at_once_in_order_and_looks_like_what_went_in() -> None:
    decoder = av.CodecContext.create("h264", "r")
    encoder = Encoder(CAMERA, VideoSettings(bitrate_kbps=20000))
    for number in range(12):
        image = np.ascontiguousarray(SMOOTH[:, 10 * number : 10 * number + 192])
        frames = decoder.decode(av.Packet(encoder.encode(from_bgr(image), number * PERIOD_NS).annex_b))
        assert len(frames) == 1
        difference = frames[0].to_ndarray(format="bgr24").astype(int) - image
        assert np.abs(difference).mean() < 6  # of 255; shifted by one picture it is above 50


def test_a_late_joiner_decodes_from_any_idr_on() -> None:
    units = encode(70)
    second = idr_numbers(units)[1]
    decoder = av.CodecContext.create("h264", "r")
    assert sum(len(decoder.decode(av.Packet(unit))) for unit in units[second:]) == len(units) - second


def test_a_lower_rate_is_obeyed_at_once_and_a_higher_one_with_the_next_idr() -> None:
    encoder = Encoder(CAMERA, VideoSettings(bitrate_kbps=20000, idr_interval_s=2.0))
    encoder.note_session("ann", watched=True)
    for _ in range(4):
        encoder.note_loss("ann", 0.0)  # at full rate from the first picture on
    sizes, idrs = [], []
    for number in range(180):
        if number in (30, 90):
            encoder.note_estimate("ann", camera_bitrate_bps(5000 if number == 30 else 40000, CAMERA))
        unit = encoder.encode(picture(number), number * PERIOD_NS)
        sizes.append(len(unit.annex_b))
        if unit.is_idr:
            idrs.append(number)
    assert idrs[:2] == [0, 30]
    assert 90 <= idrs[2] <= 92
    before, low, after = (sum(sizes[start : start + 30]) for start in (0, 31, 100))
    assert low < 0.4 * before  # a quarter, less the receiver's headroom
    assert after > 0.7 * before


def test_a_report_that_comes_when_its_session_is_over_changes_nothing() -> None:
    encoder = Encoder(CAMERA, VideoSettings(bitrate_kbps=20000))
    encoder.note_session("ann", watched=True)
    encoder.note_session("ann", watched=False)
    encoder.note_loss("ann", 0.9)
    encoder.note_estimate("ann", camera_bitrate_bps(2000, CAMERA))
    sizes = [len(encoder.encode(picture(number), number * PERIOD_NS).annex_b) for number in range(60)]
    assert sum(sizes[30:]) * 8 > 0.7 * camera_bitrate_bps(20000, CAMERA)


def test_fewer_pictures_a_second_share_the_same_bit_rate() -> None:
    encoder = Encoder(CAMERA, VideoSettings(bitrate_kbps=20000))
    many = [encoder.encode(picture(number), number * PERIOD_NS) for number in range(60)]
    encoder.limit(RATE_HZ / 3)
    few = [encoder.encode(picture(3 * number), (60 + 3 * number) * PERIOD_NS) for number in range(20)]
    assert few[0].is_idr and not any(unit.is_idr for unit in few[1:])
    before, after = (sum(len(unit.annex_b) for unit in units) for units in (many[30:], few[10:]))  # a second each
    assert 0.8 < after / before < 1.25


def test_a_smaller_picture_begins_with_an_idr_and_is_decoded_at_its_size() -> None:
    encoder, decoder = Encoder(CAMERA, VideoSettings(bitrate_kbps=20000)), av.CodecContext.create("h264", "r")
    small = from_bgr(np.ascontiguousarray(NOISE[:54, :96]))
    shown, idrs = [], []
    for number, frame in enumerate((picture(0), picture(1), small, small, picture(4))):
        unit = encoder.encode(frame, number * PERIOD_NS)
        idrs.append(unit.is_idr)
        shown += [(each.width, each.height) for each in decoder.decode(av.Packet(unit.annex_b))]
    shown += [(each.width, each.height) for each in decoder.decode(None)]
    assert idrs == [True, False, True, False, True]
    assert shown == [(192, 108)] * 2 + [(96, 54)] * 2 + [(192, 108)]


def test_the_largest_picture_stays_within_the_rate_buffer() -> None:
    settings = VideoSettings(bitrate_kbps=20000, vbv_frames=3.0)
    mean_bytes = camera_bitrate_bps(20000, CAMERA) / RATE_HZ / 8
    assert max(len(unit) for unit in encode(130, settings=settings)[1:]) < 1.3 * 3.0 * mean_bytes


@given(st.lists(st.tuples(st.integers(1, 400), st.booleans()), min_size=1, max_size=60))
def test_no_stretch_without_an_idr_is_longer_than_the_interval_and_one_picture(steps: list[tuple[int, bool]]) -> None:
    now_ns, last_ns, pending = 0, None, False
    for step_ms, requested in steps:
        now_ns += step_ms * 1_000_000
        pending = pending or requested
        if idr_is_due(now_ns, last_ns, pending, 2 * S):
            assert last_ns is None or now_ns - last_ns >= S // 4
            last_ns, pending = now_ns, False
        else:
            assert last_ns is not None
            assert now_ns - last_ns < (S // 4 if pending else 2 * S)
