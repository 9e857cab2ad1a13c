"""New picture or the old one again; and what the loop of a camera says about it."""

import threading
from collections.abc import Callable

import av
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tower.video.connection import user_data
from vehicle_gateway.video.camera import CameraLoop
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.freshness import Freshness, judge
from vehicle_gateway.video.load import Allowance
from vehicle_gateway.video.picture import Picture, from_bgr
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.messages.vehicle import CameraCalibration
from wire.picture import EncodedPicture
from wire.stamp import read_stamp

CAMERA = CameraCalibration(
    name="front",
    required=True,
    width_px=96,
    height_px=64,
    frame_rate_hz=30.0,
    focal_length_px=60.0,
    x_m=1.7,
    y_m=0.0,
    z_m=1.3,
    yaw_rad=0.0,
    pitch_rad=0.0,
)
MS = 1_000_000


class NoSource:
    """A camera that gives nothing by itself: the test hands pictures to the loop."""

    skipped, losses = 3, 0

    def __init__(self, kind: str = "v4l2") -> None:
        self.kind, self.is_camera = kind, kind != "file"

    def take(self, timeout_s: float) -> Picture | None:
        return None

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        """It gives nothing anyway."""

    def __enter__(self) -> "NoSource":
        return self

    def __exit__(self, *_: object) -> None:
        pass


class OneLevelSource(NoSource):
    """Pictures at once, stamped 1, 2, 3, ...; `fetched` is set with the third."""

    def __init__(self) -> None:
        super().__init__()
        self.count, self.fetched = 0, threading.Event()

    def take(self, timeout_s: float) -> Picture | None:
        self.count += 1
        if self.count >= 3:
            self.fetched.set()
        return Picture(grey(50 + self.count % 100), self.count)


def grey(level: int) -> av.VideoFrame:
    return from_bgr(np.full((64, 96, 3), level, np.uint8))


def loop_of(deliver: Callable[[EncodedPicture, int], None], kind: str = "v4l2") -> CameraLoop:
    return CameraLoop(CAMERA, NoSource(kind), Encoder(CAMERA, VideoSettings()), Clock(), deliver)


@given(st.lists(st.integers(0, 2), min_size=1, max_size=40))
def test_the_stamp_is_always_that_of_the_last_change_of_content(contents: list[int]) -> None:
    state = Freshness()
    for number, content in enumerate(contents):
        state = judge(state, content, 100 + number)
        changes = [i for i in range(number + 1) if i == 0 or contents[i] != contents[i - 1]]
        assert state.capture_ns == 100 + changes[-1]
        assert state.repeated == number + 1 - len(changes)


def test_repeated_content_keeps_the_old_stamp_in_the_picture_and_in_the_recording() -> None:
    sent: list[EncodedPicture] = []
    loop = loop_of(lambda picture, _: sent.append(picture))
    for number, level in enumerate((50, 90, 90, 90, 120)):
        loop.step(Picture(grey(level), (10 + number) * MS), (20 + number) * MS)
    decoder = av.CodecContext.create("h264", "r")
    stamps = [read_stamp(user_data(frame)) for one in sent for frame in decoder.decode(av.Packet(one.annex_b))]
    assert [(stamp.capture_ns, stamp.sequence) for stamp in stamps if stamp] == [
        (10 * MS, 1),
        (11 * MS, 2),
        (11 * MS, 3),
        (11 * MS, 4),
        (14 * MS, 5),
    ]
    assert [picture.capture_ns for picture in sent] == [10 * MS, 11 * MS, 11 * MS, 11 * MS, 14 * MS]


def test_the_status_counts_repeats_and_a_camera_that_hangs_is_no_longer_live() -> None:
    now_ns = Clock().now_ns()
    loop = loop_of(lambda *_: None)
    for number, level in enumerate((50, 90, 90)):
        loop.step(Picture(grey(level), now_ns + number * MS), now_ns + number * MS)
    status = loop.status(now_ns + 500 * MS, watching=1)
    assert (status.frames, status.repeated, status.newest_capture_ns) == (3, 1, now_ns + MS)
    assert status.live
    assert status.watching == 1
    assert not loop.status(now_ns + 1500 * MS, watching=1).live


def test_a_file_is_never_live() -> None:
    now_ns = Clock().now_ns()
    loop = loop_of(lambda *_: None, kind="file")
    loop.step(Picture(grey(50), now_ns), now_ns)
    assert not loop.status(now_ns + MS, watching=0).live


class WaitsForNothing(OneLevelSource):
    """It never has a picture, and keeps how long it was waited for."""

    def __init__(self) -> None:
        super().__init__()
        self.waited_s: list[float] = []

    def take(self, timeout_s: float) -> Picture | None:
        super().take(timeout_s)
        self.waited_s.append(timeout_s)
        return None


@pytest.mark.parametrize(("rate_hz", "after_ms"), [(30.0, 100.0), (10.0, 150.0)])
def test_in_slow_motion_a_source_has_as_much_longer_until_its_last_picture_is_shown_again(rate_hz: float, after_ms: float) -> None:
    source, halt = WaitsForNothing(), threading.Event()
    clock = Clock(real_time_factor=0.25)
    loop = CameraLoop(CAMERA, source, Encoder(CAMERA, VideoSettings()), clock, lambda *_: None)
    loop.limit(Allowance(rate_hz))
    thread = threading.Thread(target=loop.run, args=(halt,))
    thread.start()
    try:
        assert source.fetched.wait(5.0)
    finally:
        halt.set()
        thread.join(5.0)
    assert source.waited_s[0] == pytest.approx(4 * after_ms / 1e3)


def test_skipped_pictures_are_told_in_the_health_of_the_loop() -> None:
    health = loop_of(lambda *_: None).health("vehicle-gateway video", Clock().now_ns())
    assert health.dropped == {"pictures skipped": 3}


def test_a_camera_that_nobody_wants_encodes_nothing_and_starts_again_without_what_was_before() -> None:
    wanted, halt = threading.Event(), threading.Event()
    sent: list[EncodedPicture] = []
    source = OneLevelSource()
    loop = CameraLoop(
        CAMERA,
        source,
        Encoder(CAMERA, VideoSettings()),
        Clock(),
        lambda picture, _: sent.append(picture),
        lambda _: wanted.is_set(),
    )
    thread = threading.Thread(target=loop.run, args=(halt,))
    thread.start()
    try:
        assert not source.fetched.wait(0.2)
        assert not loop.status(Clock().now_ns(), watching=1).wanted
        wanted.set()
        assert source.fetched.wait(5.0)
    finally:
        halt.set()
        thread.join(5.0)
    assert sent
    assert min(picture.capture_ns for picture in sent) > 1  # the first, from before, was thrown away
