"""foxglove.CompressedVideo as protobuf: the schema built here field by field, one access unit per message. Pure.

timestamp 1 (google.protobuf.Timestamp, capture time as Unix time), frame_id 2 (the camera), data 3 (Annex B), format 4
("h264").
Source: Foxglove's message schema CompressedVideo; H.264 in Annex B, SPS in every IDR, no B-frames.
What the message has no field for is kept beside it: the sequence is the MCAP message's, and Unix time minus
`utc_minus_vehicle_ns` of the channel's metadata is the capture stamp on the vehicle clock, exactly.
"""

from google.protobuf import timestamp_pb2
from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet
from google.protobuf.message import DecodeError

from wire.picture import EncodedPicture
from wire.protobuf import message_class

SCHEMA_NAME = "foxglove.CompressedVideo"
_NANOSECONDS = 1_000_000_000
_IDR = 5  # nal_unit_type of a coded slice of an IDR picture, ITU-T H.264 table 7-1
_FIELDS = (  # name, number, type, name of a message type
    ("timestamp", 1, FieldDescriptorProto.TYPE_MESSAGE, ".google.protobuf.Timestamp"),
    ("frame_id", 2, FieldDescriptorProto.TYPE_STRING, None),
    ("data", 3, FieldDescriptorProto.TYPE_BYTES, None),
    ("format", 4, FieldDescriptorProto.TYPE_STRING, None),
)


def _descriptors() -> FileDescriptorSet:
    timestamp = FileDescriptorProto()
    timestamp_pb2.DESCRIPTOR.CopyToProto(timestamp)
    video = FileDescriptorProto(
        name="foxglove/CompressedVideo.proto", package="foxglove", syntax="proto3", dependency=[timestamp.name]
    )
    message = video.message_type.add(name="CompressedVideo")
    for name, number, type_, type_name in _FIELDS:
        message.field.add(name=name, number=number, type=type_, type_name=type_name, label=FieldDescriptorProto.LABEL_OPTIONAL)
    return FileDescriptorSet(file=[timestamp, video])


_DESCRIPTORS = _descriptors()
_CompressedVideo = message_class(_DESCRIPTORS, SCHEMA_NAME)
SCHEMA: bytes = _DESCRIPTORS.SerializeToString(deterministic=True)


def encode_video(picture: EncodedPicture, utc_minus_vehicle_ns: int) -> bytes:
    """One picture as a CompressedVideo message; its timestamp is the capture time as Unix time."""
    seconds, nanos = divmod(picture.capture_ns + utc_minus_vehicle_ns, _NANOSECONDS)
    message = _CompressedVideo(frame_id=picture.camera, data=picture.annex_b, format="h264")
    message.timestamp.seconds, message.timestamp.nanos = seconds, nanos
    encoded: bytes = message.SerializeToString()
    return encoded


def decode_video(data: bytes, sequence: int, utc_minus_vehicle_ns: int) -> EncodedPicture:
    """The picture back, its stamp on the vehicle clock. Raises ValueError on anything that is not such a message."""
    try:
        message = _CompressedVideo.FromString(data)
    except DecodeError as error:
        raise ValueError(f"not a {SCHEMA_NAME}: {error}") from None
    unix_ns = message.timestamp.seconds * _NANOSECONDS + message.timestamp.nanos
    return EncodedPicture(
        camera=message.frame_id,
        capture_ns=unix_ns - utc_minus_vehicle_ns,
        sequence=sequence,
        is_idr=has_idr(message.data),
        annex_b=message.data,
    )


def has_idr(annex_b: bytes) -> bool:
    """Whether an access unit holds an IDR slice: a decoder may start here."""
    at = annex_b.find(b"\x00\x00\x01")
    while 0 <= at < len(annex_b) - 3:
        if annex_b[at + 3] & 0x1F == _IDR:
            return True
        at = annex_b.find(b"\x00\x00\x01", at + 3)
    return False
