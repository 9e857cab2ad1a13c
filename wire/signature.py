"""HMAC-SHA256 over a message, bound to a lease: Zenoh samples carry no sender, and a hub hides who stands behind it."""

import hmac
from typing import TypeVar

import msgspec

from wire.messages.base import encode
from wire.messages.operating import DriveCommand
from wire.messages.session import HandOverRequest

Signed = TypeVar("Signed", DriveCommand, HandOverRequest)


def _digest(message: DriveCommand | HandOverRequest, key: bytes) -> str:
    return hmac.digest(key, type(message).__name__.encode() + encode(message), "sha256").hex()[:32]


def sign(message: Signed, key: bytes) -> Signed:
    """The message with its `hmac` filled in (128 bit, hex). Whatever stood there is replaced."""
    bare = msgspec.structs.replace(message, hmac="")
    return msgspec.structs.replace(bare, hmac=_digest(bare, key))


def is_genuine(message: DriveCommand | HandOverRequest, key: bytes) -> bool:
    """Whether `message` was signed with `key` and not changed since. Constant time in the comparison."""
    expected = _digest(msgspec.structs.replace(message, hmac=""), key)
    return hmac.compare_digest(message.hmac.encode(), expected.encode())
