"""A CAN interface of the Linux kernel: one raw SocketCAN socket. A shell: it decides nothing.

An interface that vanishes (an adapter pulled out) and comes back under its name is bound again: by itself the kernel
leaves such a socket deaf for ever. Bit rate, bring-up and restart after bus-off are the system's business, never ours.
No broadcast-manager task: it would repeat the last frame for ever when this process hangs.
Source: Documentation/networking/can.rst of the Linux kernel; `struct can_frame` in linux/can.h.
"""

import errno
import select
import socket
import struct

from vehicle_gateway.can.frame import Frame

_LAYOUT = struct.Struct("=IB3x8s")  # identifier and flags, length, data
_NOT_CLASSIC = socket.CAN_EFF_FLAG | socket.CAN_RTR_FLAG | socket.CAN_ERR_FLAG
_EVERYTHING = struct.pack("=II", 0, 0)  # filter: identifier and mask
_GONE = (errno.ENODEV, errno.ENXIO)


class SocketCan:
    """Raises OSError when there is no such interface or no SocketCAN, ValueError when none is named."""

    def __init__(self, interface: str) -> None:
        if not interface:
            raise ValueError("no interface named")  # the kernel would take all of them
        self._interface = interface
        self._socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self._poll = select.poll()
        self._poll.register(self._socket, select.POLLIN)
        self._bound = False
        try:
            self._bind()
        except OSError:
            self._socket.close()
            raise

    def _bind(self) -> None:
        """Asked for by name first: binding to a name that is not there has the kernel look for a module, each time anew."""
        if all(name != self._interface for _, name in socket.if_nameindex()):
            raise OSError(errno.ENODEV, "No such device")
        self._socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, _EVERYTHING)  # a vanished interface takes it along
        self._socket.bind((self._interface,))
        self._bound = True

    def receive(self, timeout_s: float) -> Frame | None:
        """The next frame of somebody else; None after the time-out. Raises ValueError, OSError."""
        if not self._bound:
            self._bind()
        if not self._poll.poll(timeout_s * 1e3):
            return None
        try:
            return unpack(self._socket.recv(_LAYOUT.size, socket.MSG_DONTWAIT))
        except BlockingIOError:
            return None
        except OSError as error:
            self._notice(error)
            raise

    def send(self, frame: Frame) -> None:
        """Raises OSError; the reader binds again when the interface has gone: the kernel tells it only once, here or there."""
        try:
            self._socket.send(pack(frame), socket.MSG_DONTWAIT)
        except OSError as error:
            self._notice(error)
            raise

    def _notice(self, error: OSError) -> None:
        if error.errno in _GONE:
            self._bound = False

    def close(self) -> None:
        self._socket.close()


def pack(frame: Frame) -> bytes:
    return _LAYOUT.pack(frame.arbitration_id, len(frame.data), frame.data)


def unpack(raw: bytes) -> Frame:
    """Raises ValueError on anything but a classic data frame with an 11-bit identifier."""
    identifier, length, data = _LAYOUT.unpack(raw)
    if identifier & _NOT_CLASSIC or length > len(data):
        raise ValueError("not a classic data frame")
    return Frame(identifier, data[:length])
