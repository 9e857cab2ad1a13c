"""Which messages of a level are let in, against a plainer account of the same stream."""

from hypothesis import given
from hypothesis import strategies as st

from wire.messages.automation import RoadMap
from wire.messages.sensing import CameraStatus
from wire.order import SILENT_NS, Newest, is_old, is_ordered, stream_of
from wire.topics import TOPICS, Kind

MS = 1_000_000


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(1, 300)), max_size=60))
def test_while_a_stream_is_alive_stamps_only_rise(steps: list[tuple[int, int]]):
    """(stamp, ms since the one before) of each arrival; a gap shorter than the limit never lets the stamps fall."""
    newest, now_ns, let_in = None, 0, []
    for stamp, gap_ms in steps:
        now_ns += gap_ms * MS
        if not is_old(stamp, now_ns, newest):
            let_in.append((stamp, now_ns))
            newest = Newest(stamp, now_ns)
    for (first, at), (second, after) in zip(let_in, let_in[1:], strict=False):
        assert second > first or after - at >= SILENT_NS


def test_after_a_second_of_silence_a_sender_that_was_started_again_is_heard_whatever_its_clock():
    newest = Newest(stamp_ns=5000 * MS, received_ns=100 * MS)
    assert is_old(1 * MS, 100 * MS + SILENT_NS - 1, newest)
    assert not is_old(1 * MS, 100 * MS + SILENT_NS, newest)
    assert not is_old(0, 0, None)


def test_cameras_of_one_topic_are_streams_of_their_own_and_what_has_no_stamp_is_not_ordered():
    assert is_ordered(CameraStatus) and not is_ordered(RoadMap)
    levels = {name for name, topic in TOPICS.items() if topic.kind is Kind.LEVEL and topic.type and is_ordered(topic.type)}
    assert {"vehicle_state", "gateway_status", "autonomy_command", "autonomy_status", "camera_status", "operator_input"} <= levels
    left = CameraStatus(
        stamp_ns=1,
        camera="left",
        source="simulated",
        live=True,
        newest_capture_ns=1,
        frames=1,
        repeated=0,
        bitrate_kbps=1.0,
        encode_ms=1.0,
        watching=0,
    )
    assert stream_of(left) == "left"
