"""The one error of this room that a person can do something about, and what the mcap package raises on damage."""

import struct

from mcap.exceptions import McapError
from zstandard import ZstdError


class RecordingError(Exception):
    """A recording cannot be written or read; the text names the file and the fix, on one line."""


# A changed length or offset shows as a read or seek beyond the file, or beyond memory. Found by changing single bytes:
# tests/recordings/test_recover.py.
DAMAGE = (McapError, ZstdError, struct.error, ValueError, KeyError, OSError, OverflowError, MemoryError, RuntimeError)
