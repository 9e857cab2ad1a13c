"""foxglove.CompressedVideo, field by field, and back. Numbers from Foxglove's published schema."""

import pytest
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorSet
from hypothesis import given
from hypothesis import strategies as st

from recordings.compressed_video import SCHEMA, SCHEMA_NAME, decode_video, encode_video, has_idr
from wire.picture import EncodedPicture

UTC_NS = 1_700_000_000_000_000_000


def test_the_schema_is_that_of_foxglove_field_by_field() -> None:
    files = {file.name: file for file in FileDescriptorSet.FromString(SCHEMA).file}
    assert list(files) == ["google/protobuf/timestamp.proto", "foxglove/CompressedVideo.proto"]
    video = files["foxglove/CompressedVideo.proto"]
    assert f"{video.package}.{video.message_type[0].name}" == SCHEMA_NAME == "foxglove.CompressedVideo"
    assert video.syntax == "proto3"
    assert [(field.name, field.number, field.type, field.type_name) for field in video.message_type[0].field] == [
        ("timestamp", 1, FieldDescriptorProto.TYPE_MESSAGE, ".google.protobuf.Timestamp"),
        ("frame_id", 2, FieldDescriptorProto.TYPE_STRING, ""),
        ("data", 3, FieldDescriptorProto.TYPE_BYTES, ""),
        ("format", 4, FieldDescriptorProto.TYPE_STRING, ""),
    ]


def test_the_bytes_are_those_of_the_protobuf_encoding() -> None:
    picture = EncodedPicture(camera="front", capture_ns=1_500_000_003, sequence=1, is_idr=False, annex_b=b"\0\0\1\x41")
    by_hand = (
        b"\x0a\x04"
        b"\x08\x0b"
        b"\x10\x03"  # 1: timestamp of 4 bytes, 1: seconds 11, 2: nanos 3
        b"\x12\x05front"
        b"\x1a\x04\0\0\1\x41"
        b"\x22\x04h264"
    )
    assert encode_video(picture, 9_500_000_000) == by_hand


@given(
    st.integers(0, 2**60),
    st.integers(0, 2**32 - 1),
    st.binary(min_size=1, max_size=200),
    st.text(st.characters(min_codepoint=33, max_codepoint=126), min_size=1, max_size=20),
)
def test_a_picture_comes_back_with_its_stamp_on_the_vehicle_clock(capture_ns: int, sequence: int, data: bytes, camera: str) -> None:
    sent = EncodedPicture(camera=camera, capture_ns=capture_ns, sequence=sequence, is_idr=False, annex_b=data)
    back = decode_video(encode_video(sent, UTC_NS), sequence, UTC_NS)
    assert (back.camera, back.capture_ns, back.sequence, back.annex_b) == (camera, capture_ns, sequence, data)


@given(st.binary(max_size=64))
def test_other_bytes_are_a_picture_or_a_value_error(data: bytes) -> None:
    try:
        decode_video(data, 0, 0)
    except ValueError as error:
        assert "CompressedVideo" in str(error)


@pytest.mark.parametrize(
    ("data", "expected"),
    [
        (b"\0\0\0\1\x67SPS\0\0\0\1\x68PPS\0\0\1\x65slice", True),
        (b"\0\0\0\1\x41slice", False),
        (b"\0\0\1\x25slice", True),  # nal_ref_idc 1
        (b"\0\0\1", False),
        (b"", False),
    ],
)
def test_a_decoder_may_start_only_where_an_idr_slice_is(data: bytes, expected: bool) -> None:
    assert has_idr(data) is expected
