"""Reading: types, order, and one clear line for what cannot be read."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from mcap.writer import Writer

from recordings.errors import RecordingError
from recordings.read import open_recording
from wire.messages.sensing import Imu
from wire.picture import EncodedPicture, pack_picture

MS = 1_000_000


def failure(path: Path) -> str:
    with pytest.raises(RecordingError) as caught, open_recording(path) as recording:
        list(recording.messages("imu"))
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)
    return str(caught.value)


def test_messages_come_in_the_types_of_wire_with_the_time_of_arrival(recorded: Callable[..., Path], build: Any) -> None:
    with open_recording(recorded([("imu", build.imu(5), 7)])) as recording:
        ((log_ns, message),) = recording.messages("imu")
    assert (log_ns, message) == (build.utc_ns + 7, build.imu(5))
    assert isinstance(message, Imu)


def test_rows_of_several_topics_come_in_the_order_of_arrival(recorded: Callable[..., Path], build: Any) -> None:
    rows = [("imu", build.imu(1), 30), ("referee", build.referee(2), 10), ("imu", build.imu(3), 20)]
    with open_recording(recorded(rows, flush_every=1)) as recording:
        found = [(topic, log_ns - build.utc_ns) for topic, log_ns, _ in recording.rows("imu", "referee")]
    assert found == [("referee", 10), ("imu", 20), ("imu", 30)]


def test_two_iterators_over_one_recording_do_not_disturb_each_other(recorded: Callable[..., Path], build: Any) -> None:
    with open_recording(recorded(build.imu_rows(40), flush_every=5)) as recording:
        pairs = list(zip(recording.messages("imu"), recording.messages("imu"), strict=True))
    assert len(pairs) == 40 and all(one == other for one, other in pairs)


def test_a_topic_that_was_not_recorded_is_empty(recorded: Callable[..., Path], build: Any) -> None:
    with open_recording(recorded(build.imu_rows(1))) as recording:
        assert list(recording.messages("referee")) == []
        assert list(recording.pictures("rear")) == []


def test_pictures_of_two_cameras_are_kept_apart(recorded: Callable[..., Path]) -> None:
    pictures = [
        EncodedPicture(camera=name, capture_ns=number * MS, sequence=number, is_idr=False, annex_b=b"\0\0\1\x41")
        for number, name in enumerate(("front", "rear", "front"))
    ]
    path = recorded([("video", pack_picture(picture), picture.capture_ns + 1) for picture in pictures])
    with open_recording(path) as recording:
        assert recording.topics == {"video/front": 2, "video/rear": 1}
        assert [picture for _, picture in recording.pictures("front")] == [pictures[0], pictures[2]]
        assert [picture for _, picture in recording.pictures("rear")] == [pictures[1]]


def test_an_empty_drive_is_a_whole_recording(recorded: Callable[..., Path]) -> None:
    with open_recording(recorded([])) as recording:
        assert (recording.topics, recording.span_ns) == ({}, None)


def test_a_truncated_file_names_the_command_that_helps(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded(build.imu_rows(10))
    path.write_bytes(path.read_bytes()[:-5])
    assert failure(path).endswith(f"run: recordings recover {path}")


def test_a_damaged_file_names_the_command_that_helps(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded(build.imu_rows(10))
    data = bytearray(path.read_bytes())
    data[len(data) // 3 : len(data) // 3 + 400] = bytes(400)
    path.write_bytes(data)
    assert failure(path).endswith(f"run: recordings recover {path}")


def test_something_else_is_not_called_a_recording(tmp_path: Path) -> None:
    for name, data in (("empty", b""), ("text", b"this is a text file, not a recording")):
        (tmp_path / name).write_bytes(data)
        assert "not an MCAP recording" in failure(tmp_path / name)
    assert "No such file" in failure(tmp_path / "absent")


def test_a_recording_of_an_older_message_says_with_what_to_read_it(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded([])
    with path.open("wb") as stream:
        mcap: Any = Writer(stream)
        mcap.start()
        mcap.add_metadata("versions", {"commit": "abc123"})
        mcap.add_message(mcap.register_channel("imu", "json", 0), 1, b'{"stamp_ns":1}', 1)
        mcap.finish()
    assert "read it with the version that recorded it (abc123)" in failure(path)
