"""Car and tower in one process over a real WebRTC connection: pictures, stamps, replacement, recovery."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tower.video.receiver import DecodedFrame, VideoReceiver
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.picture import Picture, from_bgr
from vehicle_gateway.video.sender import video_sender
from vehicle_gateway.video.session import VideoSessions
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.loop_thread import loop_in_thread
from wire.messages.base import Message
from wire.messages.session import VideoAnswer, VideoOffer
from wire.messages.vehicle import CameraCalibration
from wire.picture import unpack_picture

HOUR_NS = 3_600_000_000_000
WAIT_S = 5.0


class MemoryLink:
    """The link of both sites in one object: queries are answered in place, published messages kept."""

    def __init__(self) -> None:
        self.handlers: dict[str, Callable[[Any], Message]] = {}
        self.published: dict[str, list[Any]] = {}
        self.hearers: dict[str, list[Callable[[Any, int], None]]] = {}
        self.asked = 0

    def publish(self, name: str, message: Message | bytes) -> None:
        self.published.setdefault(name, []).append(message)

    def serve(self, name: str, handler: Callable[[Any], Message]) -> None:
        self.handlers[name] = handler

    def on(self, name: str, callback: Callable[[Any, int], None]) -> None:
        self.hearers.setdefault(name, []).append(callback)

    def ask(self, name: str, request: Message, timeout_s: float) -> Any | None:
        self.asked += 1
        return self.handlers[name](request) if name in self.handlers else None


class CountingCamera:
    """30 Hz; the grey level of picture n is 40 + n % 170, so that a picture can be told by what is in it."""

    kind, is_camera, skipped, losses = "simulated", True, 0, 0

    def __init__(self, clock: Clock) -> None:
        self._clock, self._halt = clock, threading.Event()
        self.levels: dict[int, int] = {}  # capture_ns -> grey level

    def take(self, timeout_s: float) -> Picture | None:
        if self._halt.wait(1 / 30):
            return None
        capture_ns, level = self._clock.now_ns(), 40 + len(self.levels) % 170
        self.levels[capture_ns] = level
        return Picture(from_bgr(np.full((180, 320, 3), level, np.uint8)), capture_ns)

    def limit(self, rate_hz: float, halved: bool = False) -> None:
        """It never has to give way here: a slow machine must not change what is counted."""

    def __enter__(self) -> "CountingCamera":
        return self

    def __exit__(self, *_: object) -> None:
        self._halt.set()


def camera(name: str) -> CameraCalibration:
    return CameraCalibration(
        name=name,
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


@contextmanager
def car(link: MemoryLink, *names: str) -> Iterator[dict[str, CountingCamera]]:
    sources = {name: CountingCamera(Clock()) for name in names}
    with video_sender(link, tuple(camera(name) for name in names), sources, VideoSettings(), Clock()):
        yield sources


def watch(video: VideoReceiver, name: str, count: int, after: int = 0) -> list[DecodedFrame]:
    """`count` different pictures of one camera with a sequence above `after`."""
    frames: dict[int, DecodedFrame] = {}
    clock, pause = Clock(), threading.Event()
    end_ns = clock.now_ns() + round(WAIT_S * 1e9)
    while len(frames) < count:
        assert clock.now_ns() < end_ns, f"{len(frames)} of {count} pictures of {name} in {WAIT_S} s"
        frame = video.newest(name)
        if frame is not None and frame.sequence > after:
            frames[frame.sequence] = frame
        pause.wait(0.005)
    return list(frames.values())


def test_pictures_of_two_cameras_arrive_with_their_stamps_on_a_tower_whose_clock_is_an_hour_off() -> None:
    link = MemoryLink()
    with car(link, "front", "left") as sources, VideoReceiver(link, Clock(HOUR_NS), ("front", "left")) as video:
        for name in ("front", "left"):
            for frame in watch(video, name, 20):
                assert frame.camera == name
                assert frame.image.shape == (180, 320, 4)
                assert frame.image.flags.c_contiguous
                level = sources[name].levels[frame.capture_ns]  # KeyError: a stamp that no picture had
                assert abs(float(frame.image[..., :3].mean()) - level) < 4
                assert 0 < frame.decoded_ns - HOUR_NS - frame.capture_ns < 1_000_000_000
        assert video.withheld["front"] == 0
        assert video.sessions == 1
    recorded = [unpack_picture(data) for data in link.published["video"]]
    assert {picture.camera for picture in recorded} == {"front", "left"}
    assert not any(b"\x00\x00\x00\x01\x0a\x00" in picture.annex_b for picture in recorded)  # no end of sequence


class OnALossyWay(VideoReceiver):
    """Each camera's 40th packet does not come, nor its first repetition."""

    async def _open(self, cameras: tuple[str, ...]) -> Any:
        connection, readers = await super()._open(cameras)
        for transceiver in connection.getTransceivers() if connection is not None else ():
            lose(transceiver.receiver)
        return connection, readers


def lose(receiver: Any) -> None:
    hear, count = receiver._handle_rtp_packet, iter(range(1, 100_000))
    lost: set[int] = set()

    async def lossy(packet: Any, arrival_time_ms: int) -> None:
        repeats = int.from_bytes(packet.payload[:2], "big") if packet.ssrc in receiver._RTCRtpReceiver__rtx_ssrc else None
        if repeats is None and next(count) == 40:
            lost.add(packet.sequence_number)
        elif repeats in lost:
            lost.clear()
        else:
            await hear(packet, arrival_time_ms)

    receiver._handle_rtp_packet = lossy


def test_of_two_cameras_a_packet_that_is_lost_twice_is_sent_until_it_comes_and_no_picture_is_missed() -> None:
    link, clock = MemoryLink(), Clock()
    with car(link, "front", "left"), OnALossyWay(link, clock, ("front", "left")) as video:
        late_ms = [(frame.decoded_ns - frame.capture_ns) / 1e6 for frame in watch(video, "front", 60)]
        assert max(late_ms) < 600.0, "a hole that stays holds up 128 packets: more than a second"
        assert watch(video, "left", 1) and not video.withheld


def test_without_a_watcher_the_recorder_still_gets_its_pictures() -> None:
    link, enough = MemoryLink(), threading.Event()
    with car(link, "front"):
        for _ in range(200):
            if len(link.published.get("video", ())) >= 10 or enough.wait(0.02):
                break
    pictures = [unpack_picture(data) for data in link.published["video"]]
    assert len(pictures) >= 10
    assert pictures[0].is_idr


def test_a_new_window_takes_over_and_gets_pictures_at_once() -> None:
    link = MemoryLink()
    with car(link, "front"):
        with VideoReceiver(link, Clock(), ("front",)) as first:
            last = watch(first, "front", 5)[-1].sequence
        with VideoReceiver(link, Clock(), ("front",)) as second:
            frames = watch(second, "front", 5)
            assert frames[0].sequence > last
            assert second.sessions == 1


def test_a_restarted_car_is_asked_again_and_the_pictures_come_back() -> None:
    link = MemoryLink()
    with VideoReceiver(link, Clock(), ("front",)) as video:
        with car(link, "front"):
            watch(video, "front", 5)
        link.handlers.clear()
        with car(link, "front") as sources:
            end = threading.Event()
            for _ in range(1000):
                frame = video.newest("front")
                if (frame is not None and frame.capture_ns in sources["front"].levels) or end.wait(0.01):
                    break
            frames = watch(video, "front", 20)
        assert all(frame.capture_ns in sources["front"].levels for frame in frames)
        assert video.sessions == 2


def test_a_slow_window_sees_the_newest_and_the_rest_is_counted() -> None:
    link, pause = MemoryLink(), threading.Event()
    with car(link, "front"), VideoReceiver(link, Clock(), ("front",)) as video:
        first = watch(video, "front", 1)[0]
        pause.wait(0.5)
        now_ns = Clock().now_ns()
        second = video.newest("front")
        assert second is not None
        assert now_ns - second.decoded_ns < 100_000_000
        assert video.replaced["front"] >= second.sequence - first.sequence - 1 >= 5


@pytest.fixture(scope="module")
def sessions() -> Iterator[VideoSessions]:
    with loop_in_thread("test") as loop:
        served = VideoSessions(loop, {"front": Encoder(camera("front"), VideoSettings())})
        yield served
        served.close()


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.text(max_size=200) | st.sampled_from(["v=0", "m=video", "a=group:BUNDLE 0"]).map("v=0\r\n{}\r\n".format))
@example("")
@example("v=0\r\no=- 1 1 IN IP4 0.0.0.0\r\ns=-\r\nt=0 0\r\nm=audio 9 UDP/TLS/RTP/SAVPF 0\r\na=mid:0\r\n")
@example("v=0\r\no=- 1 1 IN IP4 0.0.0.0\r\ns=-\r\nt=0 0\r\nm=video 9 UDP/TLS/RTP/SAVPF 96\r\na=mid:0\r\n")
def test_an_offer_that_makes_no_sense_is_refused_with_a_rule(sessions: VideoSessions, sdp: str) -> None:
    answer = sessions.answer(VideoOffer(sdp=sdp, cameras=("front",)))
    assert answer.sdp == ""
    assert answer.rule.startswith("offer refused")


def test_an_unknown_camera_is_refused_by_name(sessions: VideoSessions) -> None:
    answer = sessions.answer(VideoOffer(sdp="", cameras=("front", "side")))
    assert "side" in answer.rule
    assert "front" in answer.rule


def test_a_car_that_refuses_or_answers_nonsense_is_asked_again_and_nothing_breaks() -> None:
    link, pause = MemoryLink(), threading.Event()
    link.handlers["video_session"] = lambda offer: VideoAnswer(sdp="v=0\r\nm=nonsense", cameras=offer.cameras, rule="")
    with VideoReceiver(link, Clock(), ("front",)) as video:
        for _ in range(300):
            if link.asked >= 2 or pause.wait(0.01):
                break
        assert link.asked >= 2
        with car(link, "front"):
            watch(video, "front", 3)


def test_an_offer_that_comes_while_the_cameras_end_is_refused_in_words() -> None:
    with loop_in_thread("test") as loop:
        served = VideoSessions(loop, {"front": Encoder(camera("front"), VideoSettings())})
    answer = served.answer(VideoOffer(sdp="v=0", cameras=("front",)))
    assert (answer.sdp, answer.rule) == ("", "the car's cameras are ending; ask again")
