"""What the writer leaves in the file, seen by the mcap package's own readers and by PyAV."""

import base64
import io
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from mcap.reader import NonSeekingReader, make_reader

from recordings.errors import RecordingError
from recordings.read import open_recording
from recordings.writer import DriveWriter, open_drive_file
from wire.messages.base import encode
from wire.picture import EncodedPicture, pack_picture

MS = 1_000_000


def records(path: Path, topic: str) -> list[Any]:
    with path.open("rb") as stream:
        return [message for _, _, message in make_reader(stream, validate_crcs=True).iter_messages(topics=[topic])]


def test_a_payload_is_stored_byte_for_byte(recorded: Callable[..., Path], build: Any) -> None:
    spaced = encode(build.imu(5 * MS)).replace(b":", b" :  ")
    path = recorded([("imu", spaced, 6 * MS)])
    assert [message.data for message in records(path, "imu")] == [spaced]


def test_times_are_those_of_arrival_and_of_the_sender(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded([("imu", build.imu(5 * MS), 6 * MS)])
    (message,) = records(path, "imu")
    assert message.log_time == build.utc_ns + 6 * MS
    assert message.publish_time == build.utc_ns + 5 * MS


def test_a_towers_stamp_goes_through_the_offset_told_before(recorded: Callable[..., Path], build: Any) -> None:
    hour = 3_600_000 * MS
    path = recorded(
        [
            ("drive_command", build.command(1, event_ns=hour + 1 * MS), 2 * MS),  # no offset yet
            ("operator_status", build.operator(hour + 3 * MS, offset_ns=-999 * MS, bound_ns=0), 3 * MS),  # not measured
            ("drive_command", build.command(1, event_ns=hour + 2 * MS), 3 * MS),
            ("operator_status", build.operator(hour + 3 * MS, offset_ns=-hour, bound_ns=MS), 4 * MS),
            ("drive_command", build.command(2, event_ns=hour + 5 * MS), 7 * MS),
        ]
    )
    published = [message.publish_time - build.utc_ns for message in records(path, "drive_command")]
    assert published == [2 * MS, 3 * MS, 5 * MS]


def test_what_does_not_decode_is_kept_apart_and_counted(build: Any) -> None:
    stream = io.BytesIO()
    drive = DriveWriter(stream, build.provenance())
    not_finite = encode(build.imu(1)).replace(b"9.81", b"NaN")
    wrong = [b"", b"{}", b"\xff\xfe", not_finite, encode(build.referee(1))]
    for payload in wrong:
        drive.add("imu", payload, 9 * MS)
    drive.add("imu", encode(build.imu(1)), 10 * MS)
    drive.add("video", b"short", 11 * MS)
    drive.flush()
    assert dict(drive.undecodable) == {"imu": 5, "video": 1}
    assert dict(drive.added) == {"imu": 6, "video": 1}


def test_an_undecodable_payload_can_be_had_back(recorded: Callable[..., Path]) -> None:
    path = recorded([("imu", b"\xff not a message", 9 * MS)])
    with open_recording(path) as recording:
        assert recording.topics == {"undecodable": 1}
        ((_, event),) = recording.messages("undecodable")
    assert (event.topic, event.stamp_ns) == ("imu", 9 * MS)
    assert base64.b64decode(event.payload_base64) == b"\xff not a message"


def test_the_file_passes_both_readers_of_the_format_with_checksums(recorded: Callable[..., Path], build: Any) -> None:
    path = recorded(build.imu_rows(50), flush_every=7)
    with path.open("rb") as stream:
        indexed = [message.data for _, _, message in make_reader(stream, validate_crcs=True).iter_messages()]
    with path.open("rb") as stream:
        streamed = [message.data for _, _, message in NonSeekingReader(stream, validate_crcs=True).iter_messages()]
    assert indexed == streamed == [encode(message) for _, message, _ in build.imu_rows(50)]


def test_the_recording_says_what_made_it(recorded: Callable[..., Path], build: Any) -> None:
    with open_recording(recorded(build.imu_rows(1))) as recording:
        assert recording.attachments() == {"configuration.toml": b"[wire]\n"}
        assert recording.metadata["drive"]["vehicle_id"] == "car-1"
        assert recording.metadata["clock"]["utc_minus_vehicle_ns"] == str(build.utc_ns)
        assert recording.versions == {"python": "3.11"}


def test_an_earlier_drive_is_never_overwritten(tmp_path: Path) -> None:
    paths = []
    for _ in range(3):
        path, stream = open_drive_file(tmp_path)
        stream.write(str(path).encode())
        stream.close()
        paths.append(path)
    assert [path.name for path in paths] == ["drive.mcap", "drive-2.mcap", "drive-3.mcap"]
    assert [path.read_bytes() for path in paths] == [str(path).encode() for path in paths]


def test_a_folder_that_cannot_be_written_names_the_setting(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(RecordingError, match=r"\[wire.session\] folder"):
        open_drive_file(tmp_path / "file")


def encoded(frames: list[np.ndarray[Any, Any]]) -> list[bytes]:
    """One access unit of H.264 in Annex B per frame: SPS and PPS before every IDR, no B-frames."""
    encoder: Any = av.CodecContext.create("libx264", "w")
    height, width, _ = frames[0].shape
    encoder.width, encoder.height, encoder.pix_fmt, encoder.time_base = width, height, "yuv420p", Fraction(1, 30)
    encoder.options = {"preset": "ultrafast", "tune": "zerolatency", "g": "4", "bf": "0", "qp": "18"}
    units = []
    for number, pixels in enumerate(frames):
        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24")
        frame.pts = number
        units += [bytes(packet) for packet in encoder.encode(frame)]
    return units + [bytes(packet) for packet in encoder.encode(None)]


def nal_types(annex_b: bytes) -> list[int]:
    return [part[0] & 0x1F for part in annex_b.split(b"\0\0\1")[1:]]


def test_recorded_video_decodes_frame_by_frame(recorded: Callable[..., Path], build: Any) -> None:
    grey = [np.full((96, 128, 3), 20 * number, dtype=np.uint8) for number in range(10)]
    units = encoded(grey)
    path = recorded(
        [
            (
                "video",
                pack_picture(
                    EncodedPicture(
                        camera="front", capture_ns=number * 33 * MS, sequence=number, is_idr=number % 4 == 0, annex_b=unit
                    )
                ),
                number * 33 * MS + MS,
            )
            for number, unit in enumerate(units)
        ]
    )
    decoder: Any = av.CodecContext.create("h264", "r")
    times = [(message.publish_time - build.utc_ns, message.log_time - build.utc_ns) for message in records(path, "video/front")]
    assert times == [(number * 33 * MS, number * 33 * MS + MS) for number in range(10)]
    with open_recording(path) as recording:
        assert recording.cameras == ("front",)
        pictures = [picture for _, picture in recording.pictures("front")]
    assert [picture.capture_ns for picture in pictures] == [number * 33 * MS for number in range(10)]
    assert [picture.is_idr for picture in pictures] == [number % 4 == 0 for number in range(10)]
    assert all(7 in nal_types(picture.annex_b) for picture in pictures if picture.is_idr)
    levels = [
        frame.to_ndarray(format="rgb24").mean() for picture in pictures for frame in decoder.decode(av.Packet(picture.annex_b))
    ]
    levels += [frame.to_ndarray(format="rgb24").mean() for frame in decoder.decode(None)]
    assert levels == pytest.approx([20 * number for number in range(10)], abs=4)
