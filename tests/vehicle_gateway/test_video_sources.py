"""Where pictures come from: simulated, file; and the words for what is missing or corrupt."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import vehicle_description
from vehicle_gateway.video.media import MediaSource
from vehicle_gateway.video.picture import Bytes, Picture, at_camera_size, fitted, from_bgr, plane
from vehicle_gateway.video.settings import SourceChoice, VideoSettings, camera_bitrate_bps, parse_source
from vehicle_gateway.video.simulated import SimulatedSource, WorldFeed
from vehicle_gateway.video.slot import NewestSlot
from vehicle_gateway.video.sources import choose_sources
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.messages.base import Indicators
from wire.messages.sensing import Pose, WorldState
from wire.messages.vehicle import CameraCalibration

CAMERA = CameraCalibration(
    name="front",
    required=True,
    width_px=320,
    height_px=180,
    frame_rate_hz=30.0,
    focal_length_px=200.0,
    x_m=1.7,
    y_m=0.0,
    z_m=1.3,
    yaw_rad=0.0,
    pitch_rad=0.0,
)
CAR = vehicle_description(cameras=(CAMERA,))
DASH_CAM = Path(__file__).resolve().parents[3] / "shared/data/udacity_lanelines/solidWhiteRight.mp4"
MS = 1_000_000


def write_clip(path: Path, count: int, size: tuple[int, int] = (160, 90), rate_hz: int = 50) -> Path:
    """A clip whose pictures grow brighter: level 60 + 10 * number."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=rate_hz)
        stream.width, stream.height, stream.pix_fmt, stream.time_base = *size, "yuv420p", Fraction(1, rate_hz)
        for number in range(count):
            frame = from_bgr(np.full((size[1], size[0], 3), 60 + 10 * number, np.uint8))
            frame.pts = number
            container.mux(stream.encode(frame))
        container.mux(stream.encode())
    return path


def take(source: MediaSource, count: int) -> list[Picture]:
    pictures: list[Picture] = []
    while len(pictures) < count:
        picture = source.take(5.0)
        assert picture is not None, f"only {len(pictures)} of {count} pictures came"
        pictures.append(picture)
    return pictures


def middle(picture: Picture) -> float:
    return float(plane(picture.frame, 0)[60:120, 100:220].mean())


def bands_are_marked(frame: av.VideoFrame) -> bool:
    """Bright letters on a dark band, above and below: both are there, and letters cover 3 to 40 % of the band."""
    luma = plane(frame, 0)
    rows = luma.shape[0] // 12 // 4 * 4
    shares = [((band > 180).mean(), (band < 40).mean()) for band in (luma[:rows], luma[-rows:])]
    return all(0.03 < bright < 0.4 and dark > 0.5 for bright, dark in shares)


def test_a_file_is_looped_scaled_watermarked_and_stamped_with_the_time_it_is_played(tmp_path: Path) -> None:
    clock = Clock()
    choice = SourceChoice("file", str(write_clip(tmp_path / "clip.mp4", 5)))
    started_ns = clock.now_ns()
    with MediaSource(choice, CAMERA, clock) as source:
        pictures = take(source, 8)
    ended_ns = clock.now_ns()
    assert not source.is_camera
    assert {(picture.frame.width, picture.frame.height) for picture in pictures} == {(320, 180)}
    assert all(bands_are_marked(picture.frame) for picture in pictures)
    stamps = [picture.capture_ns for picture in pictures]
    assert started_ns <= stamps[0]
    assert stamps[-1] <= ended_ns
    gaps_ms = [(late - early) / MS for early, late in zip(stamps, stamps[1:], strict=False)]
    assert 15 < sorted(gaps_ms)[len(gaps_ms) // 2] < 30  # its own rate: 50 Hz
    levels = [middle(picture) for picture in pictures]
    assert min(levels[1:]) < levels[0] + 2  # it began anew


@pytest.mark.skipif(not DASH_CAM.is_file(), reason=f"no dash-cam clip at {DASH_CAM}")
def test_the_dash_cam_clip_plays_at_720p_and_is_marked() -> None:
    camera = CameraCalibration(
        name="front",
        required=True,
        width_px=1280,
        height_px=720,
        frame_rate_hz=30.0,
        focal_length_px=760.0,
        x_m=1.7,
        y_m=0.0,
        z_m=1.3,
        yaw_rad=0.0,
        pitch_rad=0.0,
    )
    with MediaSource(SourceChoice("file", str(DASH_CAM)), camera, Clock()) as source:
        pictures = take(source, 3)
    for picture in pictures:
        assert (picture.frame.width, picture.frame.height) == (1280, 720)
        assert bands_are_marked(picture.frame)
        assert plane(picture.frame, 0)[200:500].std() > 20  # there is a road in it


@pytest.mark.parametrize(
    ("content", "words"), [(None, "cannot be read"), (b"", "cannot be read"), (b"not a video at all" * 100, "cannot be read")]
)
def test_a_file_that_cannot_be_played_is_named_with_its_key_and_the_fix(tmp_path: Path, content: bytes | None, words: str) -> None:
    path = tmp_path / "clip.mp4"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(ConfigurationError) as raised:
        MediaSource(SourceChoice("file", str(path)), CAMERA, Clock())
    text = str(raised.value)
    assert "sources.front" in text
    assert str(path) in text
    assert words in text
    assert "name a video file" in text
    assert "\n" not in text


def test_a_file_cut_off_after_its_head_is_an_error_at_start(tmp_path: Path) -> None:
    whole = write_clip(tmp_path / "whole.mkv", 5).read_bytes()
    (tmp_path / "cut.mkv").write_bytes(whole[: len(whole) // 3])
    with pytest.raises(ConfigurationError, match="cut.mkv"):
        MediaSource(SourceChoice("file", str(tmp_path / "cut.mkv")), CAMERA, Clock())


def test_a_missing_v4l2_camera_is_named_with_the_fix() -> None:
    with pytest.raises(ConfigurationError, match="/dev/video97.*group `video`"):
        MediaSource(SourceChoice("v4l2", "/dev/video97"), CAMERA, Clock())


@pytest.mark.parametrize(
    ("text", "choice"),
    [
        ("simulated", SourceChoice("simulated", "")),
        ("file:/a/b c.mp4", SourceChoice("file", "/a/b c.mp4")),
        ("file:C:clip.mp4", SourceChoice("file", "C:clip.mp4")),
        ("rtsp://camera:554/main", SourceChoice("rtsp", "rtsp://camera:554/main")),
        ("rtsp:rtsp://camera/main", SourceChoice("rtsp", "rtsp://camera/main")),
        ("v4l2:/dev/video0", SourceChoice("v4l2", "/dev/video0")),
    ],
)
def test_a_source_text_names_kind_and_place(text: str, choice: SourceChoice) -> None:
    assert parse_source(text) == choice


def test_a_camera_that_is_not_configured_is_simulated() -> None:
    assert choose_sources(VideoSettings(), CAR) == {"front": SourceChoice("simulated", "")}


def test_a_source_for_a_camera_that_the_car_has_not_is_an_error_that_names_those_it_has() -> None:
    with pytest.raises(ConfigurationError, match="sources.rear.*front"):
        choose_sources(VideoSettings(sources={"rear": "simulated"}), CAR)


def test_the_bit_rate_follows_the_pixels_per_second() -> None:
    quarter = CameraCalibration(**{**{f: getattr(CAMERA, f) for f in CAMERA.__struct_fields__}, "width_px": 640, "height_px": 360})
    assert camera_bitrate_bps(4000, quarter) == 1_000_000


class PlainRenderer:
    """A grey picture, always the same: only sensor noise tells two apart."""

    def render_planar(self, world: WorldState, out: Bytes) -> None:
        out[:] = 100


def world_at(stamp_ns: int) -> WorldState:
    return WorldState(
        stamp_ns=stamp_ns,
        car=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        speed_m_s=0.0,
        road_wheel_angle_rad=0.0,
        pitch_rad=0.0,
        roll_rad=0.0,
        indicators=Indicators.OFF,
        hazard=False,
        brake_lights=False,
        people=(),
    )


def small(rate_hz: float) -> CameraCalibration:
    return replace(CAMERA, width_px=320, height_px=180, frame_rate_hz=rate_hz)


def simulated(rate_hz: float = 27.0) -> SimulatedSource:
    return SimulatedSource(PlainRenderer(), small(rate_hz))


def rendered(source: SimulatedSource) -> Picture | None:
    """What its own thread would do, done here: no test waits for a thread."""
    source.render(0.0)
    return source.take(0.0)


def state_ns(number: int) -> int:
    return 1_000 * MS + number * 18_518_519


def numbers_taken(feed: WorldFeed, sources: list[SimulatedSource], numbers: range) -> list[list[int]]:
    """Which states each source made a picture of, every one fetched at once."""
    taken: list[list[int]] = [[] for _ in sources]
    for number in numbers:
        feed.put(world_at(state_ns(number)), received_ns=0)
        for source, mine in zip(sources, taken, strict=True):
            picture = rendered(source)
            if picture is not None:
                assert picture.capture_ns == state_ns(number)
                mine.append(number)
    return taken


def test_a_world_at_54_hz_becomes_a_camera_at_27_hz_with_the_worlds_own_stamps() -> None:
    source = simulated()
    assert numbers_taken(WorldFeed([source]), [source], range(60)) == [list(range(0, 60, 2))]
    assert source.skipped == 0


def test_no_two_of_three_cameras_want_the_same_state() -> None:
    sources = [simulated(13.5), simulated(27.0), simulated(13.5)]
    taken = numbers_taken(WorldFeed(sources), sources, range(60))
    assert taken == [list(range(1, 60, 4)), list(range(0, 60, 2)), list(range(3, 60, 4))]


def test_a_camera_that_has_to_give_way_takes_fewer_and_later_as_many_as_before() -> None:
    sources = [simulated(27.0), simulated(13.5)]
    feed = WorldFeed(sources)
    sources[1].limit(6.75)
    assert len(numbers_taken(feed, sources, range(60))[1]) in (7, 8)
    sources[1].limit(13.5)
    assert len(numbers_taken(feed, sources, range(60, 120))[1]) in (15, 16)


def test_a_camera_that_gives_way_by_size_gives_half_of_each_side_until_it_need_not() -> None:
    source = simulated()
    feed = WorldFeed([source])
    sizes = []
    for number, halved in enumerate((False, True, True, False)):
        source.limit(27.0, halved)
        feed.put(world_at(state_ns(2 * number)), received_ns=0)
        picture = rendered(source)
        assert picture is not None
        sizes.append((picture.frame.width, picture.frame.height))
    assert sizes == [(320, 180), (160, 90), (160, 90), (320, 180)]


def test_states_that_got_lost_cost_no_more_pictures_than_they_held() -> None:
    source = simulated(13.5)
    feed = WorldFeed([source])
    taken = []
    for number in (number for number in range(60) if number % 3):  # one in three is lost, also some of the camera's turns
        feed.put(world_at(state_ns(number)), received_ns=0)
        if rendered(source) is not None:
            taken.append(number)
    assert 14 <= len(taken) <= 15


def test_a_world_that_begins_anew_is_shown_at_once() -> None:
    source = simulated()
    feed = WorldFeed([source])
    numbers_taken(feed, [source], range(60))
    feed.put(world_at(5 * MS), received_ns=0)
    picture = rendered(source)
    assert picture is not None
    assert picture.capture_ns == 5 * MS


def test_a_world_that_stops_gives_no_picture_and_a_standing_car_gives_new_ones() -> None:
    source = simulated()
    feed = WorldFeed([source])
    lumas = []
    for number in (0, 0, 2):
        feed.put(world_at(state_ns(number)), received_ns=0)
        picture = rendered(source)
        lumas.append(plane(picture.frame, 0).copy() if picture else None)
    assert lumas[1] is None
    assert lumas[0] is not None
    assert lumas[2] is not None
    difference = np.abs(lumas[0].astype(int) - lumas[2])
    assert 0 < difference.max() <= 2  # sensor noise, not to be seen


def test_pictures_that_the_encoder_was_too_busy_for_are_counted() -> None:
    source = simulated()
    feed = WorldFeed([source])
    for number in range(0, 10, 2):
        feed.put(world_at(state_ns(number)), received_ns=0)
        if number in (0, 8):
            assert rendered(source) is not None
    assert source.skipped == 3


def test_its_own_thread_renders_and_what_goes_wrong_there_reaches_the_camera() -> None:
    class Broken:
        def render_planar(self, world: WorldState, out: Bytes) -> None:
            raise ArithmeticError("no picture of this world")

    with simulated() as source:
        WorldFeed([source]).put(world_at(state_ns(0)), received_ns=0)
        picture = source.take(5.0)
        assert picture is not None
        assert picture.capture_ns == state_ns(0)
    with SimulatedSource(Broken(), small(27.0)) as source:
        WorldFeed([source]).put(world_at(state_ns(0)), received_ns=0)
        with pytest.raises(ArithmeticError):
            for _ in range(50):
                source.take(0.1)


def test_a_camera_that_nobody_wants_renders_nothing_and_skips_nothing() -> None:
    source = simulated()
    feed = WorldFeed([source])
    source.limit(0.0)
    assert numbers_taken(feed, [source], range(20)) == [[]]
    assert source.skipped == 0
    source.limit(27.0)
    assert len(numbers_taken(feed, [source], range(20, 40))[0]) == 10


@given(st.lists(st.booleans(), max_size=60))
def test_the_slot_gives_the_newest_once_and_counts_the_rest(steps: list[bool]) -> None:
    slot: NewestSlot[int] = NewestSlot()
    last_put, last_taken, puts, takes = None, None, 0, 0
    for number, is_put in enumerate(steps):
        if is_put:
            slot.put(number)
            last_put, puts = number, puts + 1
        else:
            item = slot.take(0.0)
            assert item == (last_put if last_put != last_taken else None)
            takes += item is not None
            last_taken = last_put
    waiting = int(last_put is not None and last_put != last_taken)
    assert slot.replaced == puts - takes - waiting


@given(st.integers(16, 4000), st.integers(16, 4000))
def test_a_fitted_picture_is_even_inside_and_touches_two_sides(width_px: int, height_px: int) -> None:
    width, height = fitted(width_px, height_px, 1280, 720)
    assert width % 2 == height % 2 == 0
    assert 2 <= width <= 1280
    assert 2 <= height <= 720
    assert width >= 1276 or height >= 716


def test_a_picture_of_another_aspect_stands_between_black_bars() -> None:
    square = from_bgr(np.full((100, 100, 3), 200, np.uint8))
    luma = plane(at_camera_size(square, 320, 180), 0)
    assert (luma[:, :60] == 16).all()
    assert (luma[:, -60:] == 16).all()
    assert luma[:, 80:240].min() > 150
