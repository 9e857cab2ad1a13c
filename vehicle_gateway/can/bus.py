"""One CAN bus of this process: a socket, one reader thread, frames out. A shell: it decides nothing.

What may go out, `vehicle_gateway.can.transmit` says; the gateway's bus has its car's list, and nothing else can be sent.

`udp_multicast` is CAN between processes with no CAN in the kernel, in the datagram format of python-can's interface of
that name (its viewer and logger can look on). Ours differs in where it goes: it binds to the group, joins it on the
loopback interface alone and takes only what comes from this machine, with hop limit 0. So it works with no network at
all, nothing leaves the machine or enters from outside, and sessions with another group or port never see each other.
`socketcan` is an interface of the kernel, `virtual` joins threads of one process.
"""

import errno
import socket
import struct
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, Protocol

import msgpack  # type: ignore[import-untyped]

from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.own_frames import spare_own_frames
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.socketcan import SocketCan
from vehicle_gateway.can.transmit import Permit, Sending, admit
from vehicle_gateway.can.virtual import Virtual
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.pace import raise_priority

LOOPBACK = "127.0.0.1"
READ_TIMEOUT_S = 0.1  # how long closing a bus may take
_IDENTIFIER_MAX = 0x7FF  # 11 bit


class Transport(Protocol):
    def receive(self, timeout_s: float) -> Frame | None:
        """The next frame of somebody else; None after the time-out. Raises ValueError on one not classic CAN."""

    def send(self, frame: Frame) -> None:
        """Raises OSError."""

    def close(self) -> None: ...


class Bus:
    """What `open_bus` hands out. `dropped` counts frames by reason; `reading` turns false when the reader has died."""

    def __init__(
        self,
        transport: Transport,
        on_frame: Callable[[Frame, int], None],
        clock: Clock,
        fifo_priority: int,
        permits: Mapping[int, Permit] | None,
    ) -> None:
        self._transport = transport
        self._permits, self._sending = permits, Sending()
        self._on_frame = on_frame
        self._clock = clock
        self._fifo_priority = fifo_priority
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._read, name="can", daemon=True)
        self.dropped: Counter[str] = Counter()
        self.reading = True
        self._thread.start()

    def send(self, frame: Frame) -> bool:
        """Hand a frame to the bus. False, and counted, when it may not be sent or is not taken; never blocks, never raises.

        With a list of permits: from one thread only.
        """
        if self._permits is not None:
            self._sending, refusal = admit(self._sending, frame, self._clock.now_ns(), self._permits)
            if refusal:
                self.dropped[f"can not sent {frame.arbitration_id:#05x}: {refusal}"] += 1
                return False
        try:
            self._transport.send(frame)
        except OSError as error:
            self.dropped[f"can send: {errno.errorcode.get(error.errno or 0, type(error).__name__)}"] += 1
            return False
        return True

    def _read(self) -> None:
        raise_priority(self._fifo_priority)
        try:
            while not self._closing.is_set():
                self._read_one()
        finally:
            self.reading = False

    def _read_one(self) -> None:
        try:
            frame = self._transport.receive(READ_TIMEOUT_S)
        except ValueError:
            self.dropped["can unreadable"] += 1
        except OSError as error:
            self.dropped[f"can receive: {errno.errorcode.get(error.errno or 0, type(error).__name__)}"] += 1
            self._closing.wait(READ_TIMEOUT_S)  # an interface that is down says so without end
        else:
            if frame is not None:
                self._on_frame(frame, self._clock.now_ns())

    def close(self) -> None:
        self._closing.set()
        if threading.current_thread() is not self._thread:
            self._thread.join()
        self._transport.close()


@contextmanager
def open_bus(
    settings: CanSettings,
    bus: str,
    on_frame: Callable[[Frame, int], None],
    clock: Clock,
    *,
    fifo_priority: int = 0,
    permits: Mapping[int, Permit] | None = None,
) -> Iterator[Bus]:
    """One bus of the car; leaving the context closes it.

    bus       "vehicle" (gateway and ECU) or "actuator" (ECU and plant)
    on_frame  on_frame(frame, received_ns) for every frame of the others, on the reader thread: decode and put, no more
    fifo_priority  of the reader thread, where the system allows it (wire.pace)
    permits   all that may be sent (a codec's `permits`); None, for what stands in for a car, is anything
    Raises ConfigurationError when the bus cannot be opened.
    """
    try:
        channel, port = _place(settings, bus)
        transport = _OPEN[settings.interface](channel, port, settings.hop_limit)
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"[vehicle_gateway.can] {bus} bus: cannot open {settings.interface} {settings.channel} {settings.port}: "
            f"{error}; set interface, channel and port"
        ) from None
    opened = Bus(transport, on_frame, clock, fifo_priority, permits)
    try:
        yield opened
    finally:
        opened.close()


def _place(settings: CanSettings, bus: str) -> tuple[str, int]:
    """Channel and port. Raises ValueError when the two buses would be one."""
    if bus == "actuator" and settings.interface == "socketcan" and settings.actuator_channel in ("", settings.channel):
        raise ValueError("an interface has no ports; name a second one with actuator_channel")
    places = {
        "vehicle": (settings.channel, settings.port),
        "actuator": (settings.actuator_channel or settings.channel, settings.actuator_port),
    }
    return places[bus]


class _Multicast:
    def __init__(self, group: str, port: int, hop_limit: int) -> None:
        self._to = (group, port)
        self._timeout_s = 0.0  # of the kernel's: none
        self._in = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._out = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._configure(group, port, hop_limit)
        except OSError:
            self.close()
            raise

    def _configure(self, group: str, port: int, hop_limit: int) -> None:
        self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._in.bind((group, port))  # to the group, not to every address: other groups and plain datagrams stay out
        self._in.setsockopt(
            socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(LOOPBACK))
        )
        self._out.bind((LOOPBACK, 0))
        self._own = self._out.getsockname()
        spare_own_frames(self._in, self._own)
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))
        self._out.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hop_limit)
        self._out.setblocking(False)

    def receive(self, timeout_s: float) -> Frame | None:
        if timeout_s != self._timeout_s:
            self._timeout_s = timeout_s
            self._in.setsockopt(
                socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", *divmod(round(timeout_s * 1e6), 1_000_000))
            )
        try:
            data, sender = self._in.recvfrom(4096)  # one call into the kernel; a time-out of Python's would make it three
        except BlockingIOError:
            return None
        if sender == self._own or not sender[0].startswith("127."):
            return None
        return _unpack(data)

    def send(self, frame: Frame) -> None:
        self._out.sendto(_pack(frame), self._to)

    def close(self) -> None:
        self._in.close()
        self._out.close()


def _pack(frame: Frame) -> bytes:
    """The datagram python-can's udp_multicast would send for this frame."""
    packed: bytes = msgpack.packb(
        {
            "timestamp": 0.0,
            "arbitration_id": frame.arbitration_id,
            "is_extended_id": False,
            "is_remote_frame": False,
            "is_error_frame": False,
            "channel": None,
            "dlc": len(frame.data),
            "data": frame.data,
            "is_fd": False,
            "bitrate_switch": False,
            "error_state_indicator": False,
        }
    )
    return packed


def _unpack(datagram: bytes) -> Frame:
    """Raises ValueError on anything but a classic data frame with an 11-bit identifier."""
    try:
        content: Any = msgpack.unpackb(datagram)
        frame = Frame(content["arbitration_id"], content["data"])
        special = (content["is_extended_id"], content["is_remote_frame"], content["is_error_frame"], content["is_fd"])
    except (msgpack.UnpackException, KeyError, TypeError) as error:
        raise ValueError(f"not a frame: {error}") from None
    if type(frame.arbitration_id) is not int or type(frame.data) is not bytes:
        raise ValueError("not a frame: wrong types")
    if not 0 <= frame.arbitration_id <= _IDENTIFIER_MAX or len(frame.data) > 8 or any(special):
        raise ValueError("not a classic data frame")
    return frame


_OPEN: dict[str, Callable[[str, int, int], Transport]] = {
    "udp_multicast": _Multicast,
    "socketcan": lambda channel, _port, _hops: SocketCan(channel),
    "virtual": lambda channel, port, _hops: Virtual(f"{channel}:{port}"),
}
