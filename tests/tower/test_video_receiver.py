"""Car and tower in one process over a real WebRTC connection: pictures, stamps, replacement, recovery."""

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.tower.filmed_car import MemoryLink, camera, car, watch
from tower.video.receiver import VideoReceiver
from vehicle_gateway.video.encoder import Encoder
from vehicle_gateway.video.session import VideoSessions
from vehicle_gateway.video.settings import VideoSettings
from wire.clock import Clock
from wire.loop_thread import loop_in_thread
from wire.messages.session import VideoAnswer, VideoOffer
from wire.picture import unpack_picture

HOUR_NS = 3_600_000_000_000


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
    """lose: what each camera's receiver does not get."""

    def __init__(self, lose: Callable[[Any], None], link: MemoryLink, *rest: Any) -> None:
        super().__init__(link, *rest)
        self._lose = lose

    async def _open(self, cameras: tuple[str, ...]) -> Any:
        connection, readers = await super()._open(cameras)
        for transceiver in connection.getTransceivers() if connection is not None else ():
            self._lose(transceiver.receiver)
        return connection, readers


def the_40th_twice(receiver: Any) -> None:
    """That packet does not come, nor its first repetition."""
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
    with car(link, "front", "left"), OnALossyWay(the_40th_twice, link, clock, ("front", "left")) as video:
        late_ms = [(frame.decoded_ns - frame.capture_ns) / 1e6 for frame in watch(video, "front", 60)]
        assert max(late_ms) < 600.0, "a hole that stays holds up 128 packets: more than a second"
        assert watch(video, "left", 1) and not video.withheld


def first_ends(receiver: Any) -> None:
    """The first of the ends of sequence that follow a picture does not come."""
    hear, before = receiver._handle_rtp_packet, [b""]

    async def lossy(packet: Any, arrival_time_ms: int) -> None:
        if packet.ssrc in receiver._RTCRtpReceiver__rtx_ssrc:
            await hear(packet, arrival_time_ms)
            return
        is_end, was_end = packet.payload[:1] == b"\x0a", before[0] == b"\x0a"
        before[0] = packet.payload[:1]
        if not is_end or was_end:
            await hear(packet, arrival_time_ms)

    receiver._handle_rtp_packet = lossy


def test_a_lost_end_of_sequence_is_sent_again_long_before_the_next_picture() -> None:
    link, clock = MemoryLink(), Clock()
    with car(link, "front", rate_hz=2.0), OnALossyWay(first_ends, link, clock, ("front",)) as video:
        frames = watch(video, "front", 5)
        late_ms = [(frame.decoded_ns - frame.capture_ns) / 1e6 for frame in frames]
    assert max(late_ms[1:]) < 400.0, "the picture waited for the one after it"
    assert [frame.sequence - frames[0].sequence for frame in frames] == list(range(5))


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
