"""Bytes of the `video` topic: one encoded picture, from the video sender to the recorder, without leaving the car.

Layout, little-endian: u64 capture_ns (vehicle clock), u32 sequence, u8 flags (bit 0: IDR), u8 length of the camera's name,
the name in ASCII, then one access unit in Annex B (SPS and PPS in front of every IDR, no END_SEQ).
"""

import struct
from dataclasses import dataclass

_HEAD = struct.Struct("<QIBB")


@dataclass(frozen=True, slots=True, kw_only=True)
class EncodedPicture:
    camera: str
    capture_ns: int
    sequence: int
    is_idr: bool
    annex_b: bytes


def pack_picture(picture: EncodedPicture) -> bytes:
    name = picture.camera.encode("ascii")
    return _HEAD.pack(picture.capture_ns, picture.sequence, int(picture.is_idr), len(name)) + name + picture.annex_b


def unpack_picture(data: bytes) -> EncodedPicture:
    """Raises ValueError on anything shorter than it says it is."""
    if len(data) < _HEAD.size:
        raise ValueError(f"picture of {len(data)} bytes is shorter than its head of {_HEAD.size}")
    capture_ns, sequence, flags, name_length = _HEAD.unpack_from(data)
    body = _HEAD.size + name_length
    if len(data) <= body:
        raise ValueError(f"picture of {len(data)} bytes ends before its body at {body}")
    return EncodedPicture(
        camera=data[_HEAD.size : body].decode("ascii"),
        capture_ns=capture_ns,
        sequence=sequence,
        is_idr=bool(flags & 1),
        annex_b=data[body:],
    )
