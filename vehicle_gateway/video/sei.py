"""Capture stamp and sequence inside the picture: an H.264 SEI message "user data unregistered" with our own UUID.

WebRTC loses the capture time (aiortc rebases pts and has no abs-capture-time), so it travels in the picture itself.
Source: ITU-T H.264 (08/2021) 7.3.2.3.1 (SEI syntax), D.1.7 (user_data_unregistered), 7.4.1.1 (emulation prevention).
"""

import re

from wire.stamp import Stamp, stamp_payload

END_OF_SEQUENCE = b"\x00\x00\x00\x01\x0a\x00"  # a lone NAL unit of type 10; the second byte is padding
_START_CODE = b"\x00\x00\x00\x01"
_NAL_SEI, _PAYLOAD_USER_DATA_UNREGISTERED, _RBSP_STOP = b"\x06", 5, b"\x80"
_FORBIDDEN = re.compile(rb"\x00\x00(?=[\x00-\x03])")


def protect(rbsp: bytes) -> bytes:
    """Emulation prevention: no 00 00 00, 00 00 01, 00 00 02 or 00 00 03 remains inside a NAL unit."""
    return _FORBIDDEN.sub(b"\x00\x00\x03", rbsp)


def stamp_nal(stamp: Stamp) -> bytes:
    """One SEI NAL unit with start code, to stand in front of the coded picture it belongs to.

    capture_ns 0..2**64-1 on the vehicle clock; sequence is taken modulo 2**32.
    """
    payload = stamp_payload(stamp)
    message = bytes([_PAYLOAD_USER_DATA_UNREGISTERED, len(payload)]) + payload + _RBSP_STOP
    return _START_CODE + _NAL_SEI + protect(message)
