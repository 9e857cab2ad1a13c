"""Cut, damaged and parted recordings. What must be saved is told by the whole file's index, not by the recovery."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import NonSeekingReader, make_reader

from recordings.errors import RecordingError
from recordings.read import open_recording
from recordings.recover import default_output, examine, recover

CHUNK_MESSAGES = 6


@pytest.fixture(scope="module")
def whole(build: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """60 IMU samples in chunks of 6."""
    path = tmp_path_factory.mktemp("whole") / "drive.mcap"
    build.recording(path, build.imu_rows(60), flush_every=CHUNK_MESSAGES)
    return path


def chunk_ends(path: Path) -> list[int]:
    with path.open("rb") as stream:
        summary: Any = make_reader(stream).get_summary()
    return [index.chunk_start_offset + index.chunk_length for index in summary.chunk_indexes]


def stamps(path: Path) -> list[int]:
    with open_recording(path) as recording:
        return [message.stamp_ns for _, message in recording.messages("imu")]


def test_the_file_under_test_has_many_chunks(whole: Path) -> None:
    assert len(chunk_ends(whole)) == 60 // CHUNK_MESSAGES


@settings(max_examples=150, deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True))
def test_every_complete_message_of_a_cut_file_is_saved(whole: Path, place: float) -> None:
    data = whole.read_bytes()
    cut = int(place * len(data))
    expected = CHUNK_MESSAGES * sum(end <= cut for end in chunk_ends(whole))
    path, saved = whole.with_name("cut.mcap"), whole.with_name("saved.mcap")
    saved.unlink(missing_ok=True)
    path.write_bytes(data[:cut])
    if expected == 0:
        with pytest.raises(RecordingError, match="nothing can be saved"):
            examine(path)
        return
    part = examine(path)
    assert not part.whole
    assert recover([part], saved) == expected
    assert stamps(saved) == stamps(whole)[:expected]
    assert path.read_bytes() == data[:cut]


@pytest.mark.parametrize("short_of_the_end", [1, 4, 8, 9, 20])
def test_a_file_that_lacks_only_its_end_is_saved_entirely(whole: Path, tmp_path: Path, short_of_the_end: int) -> None:
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole.read_bytes()[:-short_of_the_end])
    with pytest.raises(RecordingError, match="truncated"), open_recording(path):
        pass
    assert recover([examine(path)], tmp_path / "saved.mcap") == 60


@pytest.mark.parametrize("chunk", [0, 4, 9])
def test_a_damaged_chunk_costs_only_itself(whole: Path, tmp_path: Path, chunk: int) -> None:
    data = bytearray(whole.read_bytes())
    data[chunk_ends(whole)[chunk] - 10] ^= 0xFF  # within the compressed bytes
    path = tmp_path / "damaged.mcap"
    path.write_bytes(data)
    part = examine(path)
    assert (part.whole, part.damaged_chunks) == (False, 1)
    assert recover([part], tmp_path / "saved.mcap") == 60 - CHUNK_MESSAGES
    left = stamps(whole)
    del left[chunk * CHUNK_MESSAGES : (chunk + 1) * CHUNK_MESSAGES]
    assert stamps(tmp_path / "saved.mcap") == left


@settings(max_examples=200, deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True), changed=st.integers(1, 255))
def test_one_changed_byte_never_brings_a_message_that_was_not_recorded(whole: Path, place: float, changed: int) -> None:
    """Whatever the byte: reading and recovery give messages that were written, or say that the file is damaged."""
    data = bytearray(whole.read_bytes())
    data[int(place * len(data))] ^= changed
    path, saved = whole.with_name("changed.mcap"), whole.with_name("saved.mcap")
    saved.unlink(missing_ok=True)
    path.write_bytes(data)
    written = set(stamps(whole))
    with suppress(RecordingError):
        assert set(stamps(path)) <= written
    with suppress(RecordingError):
        recover([examine(path)], saved)
        assert set(stamps(saved)) <= written


def test_a_recovered_file_still_says_what_made_it(recorded: Callable[..., Path], build: Any, tmp_path: Path) -> None:
    path = recorded(build.imu_rows(10), flush_every=5)
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(path.read_bytes()[:-30])
    recover([examine(cut)], tmp_path / "saved.mcap")
    with open_recording(tmp_path / "saved.mcap") as saved, open_recording(path) as original:
        assert saved.metadata == original.metadata
        assert saved.attachments() == original.attachments()


def test_parts_are_joined_in_the_order_of_time_whatever_the_order_of_names(
    recorded: Callable[..., Path], build: Any, tmp_path: Path
) -> None:
    first = recorded(build.imu_rows(5))
    second = recorded(build.imu_rows(4, start_ns=10**9))
    parts = [examine(second), examine(first)]
    assert recover(parts, tmp_path / "joined.mcap") == 9
    with (tmp_path / "joined.mcap").open("rb") as stream:
        in_file_order = NonSeekingReader(stream).iter_messages(log_time_order=False)
        assert [message.log_time - build.utc_ns for _, _, message in in_file_order] == stamps(first) + stamps(second)
    with open_recording(tmp_path / "joined.mcap") as joined:
        assert joined.topics == {"imu": 9}
    with (tmp_path / "joined.mcap").open("rb") as stream:
        summary: Any = make_reader(stream).get_summary()
    assert (len(summary.metadata_indexes), len(summary.attachment_indexes)) == (3, 1)  # what both say is said once


def test_parts_of_different_vehicles_are_not_one_drive(recorded: Callable[..., Path], build: Any, tmp_path: Path) -> None:
    parts = [examine(recorded(build.imu_rows(1), vehicle_id=name)) for name in ("car-1", "car-2")]
    with pytest.raises(RecordingError, match="different vehicles"):
        recover(parts, tmp_path / "joined.mcap")
    assert not (tmp_path / "joined.mcap").exists()


def test_an_existing_file_is_not_replaced(whole: Path, tmp_path: Path) -> None:
    (tmp_path / "saved.mcap").write_bytes(b"precious")
    with pytest.raises(RecordingError, match="--output"):
        recover([examine(whole)], tmp_path / "saved.mcap")
    assert (tmp_path / "saved.mcap").read_bytes() == b"precious"


def test_a_place_that_cannot_be_written_leaves_nothing_behind(whole: Path, tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match="--output"):
        recover([examine(whole)], tmp_path / "nowhere" / "saved.mcap")
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize("data", [b"", b"\x89MCAP0\r\n", b"no recording at all, but long enough to hold a head"])
def test_a_file_with_nothing_in_it_says_so(tmp_path: Path, data: bytes) -> None:
    (tmp_path / "file").write_bytes(data)
    with pytest.raises(RecordingError, match="nothing can be saved"):
        examine(tmp_path / "file")


def test_the_default_output_stands_beside_the_original() -> None:
    assert default_output(Path("sessions/a/drive-2.mcap")) == Path("sessions/a/drive-2.recovered.mcap")
