"""The bytes of one encoded picture: there and back, and nothing cut short or made up is taken."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from wire.picture import EncodedPicture, pack_picture, unpack_picture

PICTURES = st.builds(
    EncodedPicture,
    camera=st.text(st.characters(max_codepoint=126, min_codepoint=33), max_size=255),
    capture_ns=st.integers(0, 2**64 - 1),
    sequence=st.integers(0, 2**32 - 1),
    is_idr=st.booleans(),
    annex_b=st.binary(min_size=1, max_size=500),
)


@given(PICTURES)
def test_what_is_packed_is_what_is_unpacked(picture):
    assert unpack_picture(pack_picture(picture)) == picture


@given(PICTURES, st.data())
def test_a_picture_cut_before_its_body_is_refused(picture, data):
    packed = pack_picture(picture)
    body = len(packed) - len(picture.annex_b)
    with pytest.raises(ValueError):
        unpack_picture(packed[: data.draw(st.integers(0, body))])


@given(st.binary(max_size=300))
def test_noise_is_refused_or_is_a_picture_that_packs_to_the_same_bytes_but_for_unused_flags(noise):
    try:
        picture = unpack_picture(noise)
    except ValueError:
        return
    packed = pack_picture(picture)
    assert packed[:12] == noise[:12] and packed[13:] == noise[13:]
    assert packed[12] == noise[12] & 1


def test_the_layout_is_the_one_that_is_written_down():
    packed = pack_picture(EncodedPicture(camera="front", capture_ns=1, sequence=2, is_idr=True, annex_b=b"\x00\x00\x01\x67"))
    assert packed == b"\x01" + b"\x00" * 7 + b"\x02\x00\x00\x00" + b"\x01" + b"\x05" + b"front" + b"\x00\x00\x01\x67"
