"""A protobuf message from a schema that a program builds itself: nothing generated, no name shared with another library's. Pure."""

from typing import Any

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass


def message_class(descriptors: FileDescriptorSet, name: str) -> Any:
    """The class of the message with this full name, in a pool of its own. Raises KeyError when none of the files has it."""
    pool = DescriptorPool()
    for file in descriptors.file:
        pool.Add(file)
    return GetMessageClass(pool.FindMessageTypeByName(name))
