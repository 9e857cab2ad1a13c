"""foxglove.SceneUpdate as protobuf: schema and message classes, built here field by field; the kinds of primitive that we use.

Source: Foxglove's message schemas, names and numbers of the fields. What stands in a field that is left out is for other drawings.
"""

from google.protobuf import duration_pb2, timestamp_pb2
from google.protobuf.descriptor_pb2 import DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet

from wire.protobuf import message_class

PACKAGE = "foxglove"
SCHEMA_NAME = "foxglove.SceneUpdate"
LINE_STRIP, LINE_LOOP, LINE_LIST = range(3)  # LinePrimitive.Type
DELETE_ALL = 1  # SceneEntityDeletion.Type
_KINDS = {
    "double": FieldDescriptorProto.TYPE_DOUBLE,
    "bool": FieldDescriptorProto.TYPE_BOOL,
    "string": FieldDescriptorProto.TYPE_STRING,
    "Timestamp": ".google.protobuf.Timestamp",
    "Duration": ".google.protobuf.Duration",
}
MESSAGES: dict[str, tuple[str, ...]] = {  # "name number kind"; * repeated
    "Vector3": ("x 1 double", "y 2 double", "z 3 double"),
    "Point3": ("x 1 double", "y 2 double", "z 3 double"),
    "Quaternion": ("x 1 double", "y 2 double", "z 3 double", "w 4 double"),
    "Pose": ("position 1 Vector3", "orientation 2 Quaternion"),
    "Color": ("r 1 double", "g 2 double", "b 3 double", "a 4 double"),
    "CubePrimitive": ("pose 1 Pose", "size 2 Vector3", "color 3 Color"),
    "CylinderPrimitive": ("pose 1 Pose", "size 2 Vector3", "bottom_scale 3 double", "top_scale 4 double", "color 5 Color"),
    "LinePrimitive": (
        "type 1 LinePrimitive.Type",
        "pose 2 Pose",
        "thickness 3 double",
        "scale_invariant 4 bool",
        "points 5 *Point3",
        "color 6 Color",
    ),
    "TextPrimitive": (
        "pose 1 Pose",
        "billboard 2 bool",
        "font_size 3 double",
        "scale_invariant 4 bool",
        "color 5 Color",
        "text 6 string",
    ),
    "SceneEntityDeletion": ("timestamp 1 Timestamp", "type 2 SceneEntityDeletion.Type", "id 3 string"),
    "SceneEntity": (
        "timestamp 1 Timestamp",
        "frame_id 2 string",
        "id 3 string",
        "lifetime 4 Duration",
        "frame_locked 5 bool",
        "cubes 8 *CubePrimitive",
        "cylinders 10 *CylinderPrimitive",
        "lines 11 *LinePrimitive",
        "texts 13 *TextPrimitive",
    ),
    "SceneUpdate": ("deletions 1 *SceneEntityDeletion", "entities 2 *SceneEntity"),
}
ENUMS = {"LinePrimitive": ("LINE_STRIP", "LINE_LOOP", "LINE_LIST"), "SceneEntityDeletion": ("MATCHING_ID", "ALL")}


def _descriptors() -> FileDescriptorSet:
    known = [FileDescriptorProto() for _ in range(2)]
    timestamp_pb2.DESCRIPTOR.CopyToProto(known[0])
    duration_pb2.DESCRIPTOR.CopyToProto(known[1])
    scene = FileDescriptorProto(
        name="foxglove/SceneUpdate.proto", package=PACKAGE, syntax="proto3", dependency=[file.name for file in known]
    )
    for name, fields in MESSAGES.items():
        message = scene.message_type.add(name=name)
        for field in fields:
            _add_field(message, *field.split())
        _add_enum(message, ENUMS.get(name, ()))
    return FileDescriptorSet(file=[*known, scene])


def _add_field(message: DescriptorProto, name: str, number: str, kind: str) -> None:
    bare = kind.removeprefix("*")
    repeated, single = FieldDescriptorProto.LABEL_REPEATED, FieldDescriptorProto.LABEL_OPTIONAL
    field = message.field.add(name=name, number=int(number), label=repeated if kind != bare else single)
    known = _KINDS.get(bare, f".{PACKAGE}.{bare}")
    if isinstance(known, int):
        field.type = known
        return
    field.type = FieldDescriptorProto.TYPE_ENUM if bare.endswith(".Type") else FieldDescriptorProto.TYPE_MESSAGE
    field.type_name = known


def _add_enum(message: DescriptorProto, names: tuple[str, ...]) -> None:
    if names:
        kinds = message.enum_type.add(name="Type")
        for number, name in enumerate(names):
            kinds.value.add(name=name, number=number)


_DESCRIPTORS = _descriptors()
SceneUpdate = message_class(_DESCRIPTORS, SCHEMA_NAME)
SCHEMA: bytes = _DESCRIPTORS.SerializeToString(deterministic=True)
