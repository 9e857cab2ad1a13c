"""The bus between threads and sockets of this machine. Every wait is for an arrival, never for time."""

import errno
import os
import queue
import socket
from contextlib import ExitStack, contextmanager

import msgpack
import pytest
from can.interfaces.udp_multicast.utils import unpack_message

from vehicle_gateway.can.bus import Bus, _pack, _unpack, open_bus
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.own_frames import spare_own_frames
from vehicle_gateway.can.settings import CanSettings
from wire.clock import Clock
from wire.configuration import ConfigurationError

PORT = 20000 + os.getpid() % 20000 * 2  # another test run on this machine has another
GROUP = "239.74.163.90"
FRAME, MARKER = Frame(0x123, b"\x01\x02\x03"), Frame(0x7F0, b"\xaa")
ARRIVES_S = 5.0


@contextmanager
def listening(settings, bus="vehicle"):
    got = queue.Queue()
    with open_bus(settings, bus, lambda frame, received_ns: got.put((frame, received_ns)), Clock()) as opened:
        yield opened, got


@pytest.fixture(params=["udp_multicast", "virtual"])
def settings(request):
    return CanSettings(interface=request.param, channel=GROUP, port=PORT, actuator_port=PORT + 1)


def test_a_frame_reaches_everybody_else_and_not_its_sender(settings):
    with listening(settings) as (one, own), listening(settings) as (_, second), listening(settings) as (_, third):
        before_ns = Clock().now_ns()
        assert one.send(FRAME)
        for other in (second, third):
            frame, received_ns = other.get(timeout=ARRIVES_S)
            assert frame == FRAME
            assert received_ns >= before_ns
        assert own.empty()


def test_frames_keep_their_order(settings):
    with listening(settings) as (one, _), listening(settings) as (_, got):
        for number in range(200):
            one.send(Frame(0x100, bytes([number])))
        assert [got.get(timeout=ARRIVES_S)[0].data[0] for _ in range(200)] == list(range(200))


def test_the_vehicle_bus_and_the_actuator_bus_are_two(settings):
    with (
        listening(settings) as (vehicle, _),
        listening(settings, "actuator") as (actuator, _),
        listening(settings, "actuator") as (_, got),
    ):
        vehicle.send(FRAME)
        actuator.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER


def test_another_group_on_the_same_port_never_hears_us():
    ours = CanSettings(channel=GROUP, port=PORT)
    theirs = CanSettings(channel="239.74.163.91", port=PORT)
    with listening(ours) as (one, _), listening(theirs) as (other, _), listening(theirs) as (_, got):
        one.send(FRAME)
        other.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER


def test_a_plain_datagram_to_the_port_does_not_get_in():
    with (
        listening(CanSettings(channel=GROUP, port=PORT)) as (_, got),
        listening(CanSettings(channel=GROUP, port=PORT)) as (one, _),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as outside,
    ):
        outside.sendto(_pack(FRAME), ("127.0.0.1", PORT))
        one.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER


def test_rubbish_on_the_group_is_counted_and_the_reader_goes_on():
    settings = CanSettings(channel=GROUP, port=PORT)
    with ExitStack() as stack:
        bus, got = stack.enter_context(listening(settings))
        one, _ = stack.enter_context(listening(settings))
        outside = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        outside.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        for rubbish in (b"\xc1", b"", msgpack.packb({"data": 5}), msgpack.packb([1, 2])):
            outside.sendto(rubbish, (GROUP, PORT))
        one.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER
        assert bus.dropped["can unreadable"] == 4
        assert bus.reading


def test_the_datagram_is_the_one_python_can_reads():
    message = unpack_message(_pack(FRAME), replace={"timestamp": 0.0}, check=True)
    assert (message.arbitration_id, bytes(message.data), message.dlc) == (FRAME.arbitration_id, FRAME.data, 3)
    assert not (message.is_extended_id or message.is_fd or message.is_error_frame or message.is_remote_frame)


@pytest.mark.parametrize(
    "change",
    [
        {"is_extended_id": True},
        {"is_remote_frame": True},
        {"is_error_frame": True},
        {"is_fd": True},
        {"data": bytes(9)},
        {"data": "text"},
        {"arbitration_id": 0x800},
        {"arbitration_id": -1},
        {"arbitration_id": 1.5},
    ],
)
def test_anything_but_a_classic_data_frame_is_refused(change):
    content = msgpack.unpackb(_pack(FRAME))
    with pytest.raises(ValueError, match="frame"):
        _unpack(msgpack.packb({**content, **change}))


def test_a_bus_that_cannot_be_opened_names_the_setting():
    with (
        pytest.raises(ConfigurationError, match=r"\[vehicle_gateway.can\] vehicle bus.*set interface, channel and port"),
        listening(CanSettings(channel="10.0.0.1", port=PORT)),
    ):
        pass


def test_a_frame_that_the_closed_bus_refuses_is_counted_and_does_not_raise():
    with listening(CanSettings(channel=GROUP, port=PORT)) as (bus, _):
        pass
    assert not bus.send(FRAME)
    assert sum(bus.dropped.values()) == 1


def test_two_buses_on_one_kernel_interface_are_refused_with_the_fix():
    with (
        pytest.raises(ConfigurationError, match="name a second one with actuator_channel"),
        listening(CanSettings(interface="socketcan", channel="can0"), "actuator"),
    ):
        pass


class Down:
    """An interface that is down, and up again at the third reading."""

    def __init__(self) -> None:
        self.readings = 0

    def receive(self, _: float) -> Frame | None:
        self.readings += 1
        if self.readings < 3:
            raise OSError(errno.ENETDOWN, "Network is down")
        return MARKER

    def send(self, frame: Frame) -> None:
        raise OSError(errno.ENOBUFS, "No buffer space available")

    def close(self) -> None: ...


def test_an_interface_that_is_down_is_counted_by_its_error_and_heard_again_when_it_is_up():
    got = queue.Queue()
    bus = Bus(Down(), lambda frame, _: got.put(frame), Clock(), 0, None)
    assert got.get(timeout=ARRIVES_S) == MARKER
    assert not bus.send(FRAME)
    bus.close()
    assert bus.dropped == {"can receive: ENETDOWN": 2, "can send: ENOBUFS": 1}


def test_a_reader_may_close_its_own_bus():
    closed, opened = queue.Queue(), queue.Queue()

    def on_frame(_: Frame, __: int) -> None:
        opened.get(timeout=ARRIVES_S).close()
        closed.put(True)

    transport = Down()
    transport.readings = 2
    opened.put(Bus(transport, on_frame, Clock(), 0, None))
    assert closed.get(timeout=ARRIVES_S)


def test_what_a_socket_has_sent_itself_does_not_come_back_to_its_receiver_and_all_else_does():
    with ExitStack() as stack:
        receiver, own, same_port, other = (stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) for _ in range(4))
        receiver.bind(("127.0.0.1", 0))
        receiver.settimeout(ARRIVES_S)
        own.bind(("127.0.0.1", 0))
        same_port.bind(("127.0.0.2", own.getsockname()[1]))
        if not spare_own_frames(receiver, own.getsockname()):
            pytest.skip("this system cannot filter datagrams")
        for sender, said in ((own, b"own"), (same_port, b"same port"), (own, b"own"), (other, b"other")):
            sender.sendto(said, receiver.getsockname())
        assert [receiver.recv(64) for _ in range(2)] == [b"same port", b"other"]
