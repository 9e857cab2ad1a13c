"""The capture stamp inside the picture: emulation prevention, and what a real decoder makes of it."""

from fractions import Fraction

import av
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tower.video.connection import user_data
from vehicle_gateway.video.sei import END_OF_SEQUENCE, protect, stamp_nal
from wire.stamp import Stamp, read_stamp

awkward = st.binary(max_size=64) | st.lists(st.sampled_from([0, 0, 0, 1, 2, 3, 4, 255]), max_size=64).map(bytes)


def unprotected(data: bytes) -> bytes:
    """H.264 7.3.1, read plainly: the 03 of every 00 00 03 is dropped."""
    out, zeros = bytearray(), 0
    for byte in data:
        if zeros >= 2 and byte == 3:
            zeros = 0
            continue
        zeros = zeros + 1 if byte == 0 else 0
        out.append(byte)
    return bytes(out)


@given(awkward)
@example(bytes(9))
@example(b"\x00\x00\x03\x00\x00\x03")
def test_protected_bytes_never_look_like_a_start_code_and_come_back_whole(data: bytes) -> None:
    guarded = protect(data + b"\x80")
    assert not any(guarded[i : i + 3] in (b"\0\0\0", b"\0\0\1", b"\0\0\2") for i in range(len(guarded)))
    assert unprotected(guarded) == data + b"\x80"


def one_coded_picture() -> bytes:
    context = av.CodecContext.create("libx264", "w")
    context.width, context.height, context.pix_fmt, context.time_base = 64, 64, "yuv420p", Fraction(1, 30)
    context.options = {"preset": "ultrafast", "tune": "zerolatency"}
    frame = av.VideoFrame(64, 64, "yuv420p")
    for plane in frame.planes:
        plane.update(bytes([100]) * plane.buffer_size)
    return b"".join(bytes(packet) for packet in context.encode(frame))


CODED = one_coded_picture()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**64 - 1), st.integers(0, 2**32 - 1))
@example(0, 0)
@example(0x0000010000020000, 0x00000300)
@example(2**64 - 1, 2**32 - 1)
def test_a_decoder_gives_back_the_stamp_that_was_put_in(capture_ns: int, sequence: int) -> None:
    decoder = av.CodecContext.create("h264", "r")
    (frame,) = decoder.decode(av.Packet(stamp_nal(Stamp(capture_ns, sequence)) + CODED))
    found = read_stamp(user_data(frame))
    assert found is not None
    assert (found.capture_ns, found.sequence) == (capture_ns, sequence)


def test_a_picture_without_our_stamp_has_none_although_x264_wrote_a_message_of_its_own() -> None:
    (frame,) = av.CodecContext.create("h264", "r").decode(av.Packet(CODED))
    assert any(b"x264" in message for message in user_data(frame))
    assert read_stamp(user_data(frame)) is None


def test_a_lone_end_of_sequence_decodes_to_nothing_and_disturbs_nothing() -> None:
    decoder = av.CodecContext.create("h264", "r")
    assert len(decoder.decode(av.Packet(CODED))) == 1
    assert decoder.decode(av.Packet(END_OF_SEQUENCE)) == []
    assert len(decoder.decode(av.Packet(CODED))) == 1
