"""Our buses on a CAN interface of a real kernel (vcan): frames, a broken interface, and the real ECU on the other end."""

import errno
import queue
import socket
import struct
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from math import copysign

import pytest

from vehicle_gateway.can.actuator_codec import (
    DemandState,
    PlantReport,
    decode_demand,
    encode_plant_motion,
    encode_plant_report,
)
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.codec import FeedbackState, decode, encode_command
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.settings import CanSettings
from wire.clock import Clock
from wire.configuration import ConfigurationError, shipped
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode

SETTINGS = CanSettings(interface="socketcan", channel="vcan0", actuator_channel="vcan1")
FRAME, MARKER = Frame(0x123, b"\x01\x02\x03"), Frame(0x7F0, b"\xaa")
ARRIVES_S = 10.0
ECU_TIMEOUT_MS = 1000.0  # instead of 100: the guest is emulated, and a busy machine stops it for a while


@pytest.fixture(autouse=True)
def interfaces(system):
    system("ip -batch -", *(f"link add dev {name} up type vcan" for name in ("vcan0", "vcan1")))
    yield
    system("ip -batch -", *(f"link delete {name}" for name in ("vcan0", "vcan1")))


@contextmanager
def listening(bus="vehicle", settings=SETTINGS):
    got = queue.Queue()
    with open_bus(settings, bus, lambda frame, received_ns: got.put((frame, received_ns)), Clock()) as opened:
        yield opened, got


@contextmanager
def raw_socket(channel="vcan0"):
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as outside:
        outside.bind((channel,))
        yield outside


def test_a_frame_reaches_everybody_else_and_not_its_sender():
    with listening() as (one, own), listening() as (_, second), listening() as (_, third):
        before_ns = Clock().now_ns()
        assert one.send(FRAME)
        for other in (second, third):
            frame, received_ns = other.get(timeout=ARRIVES_S)
            assert frame == FRAME
            assert received_ns >= before_ns
        assert own.empty()


def test_frames_keep_their_order_and_every_length_comes_through():
    sent = [Frame(0x100 + number, bytes(range(number % 9))) for number in range(200)]
    with listening() as (one, _), listening() as (_, got):
        assert all(one.send(frame) for frame in sent)
        assert [got.get(timeout=ARRIVES_S)[0] for _ in sent] == sent


def test_the_vehicle_bus_and_the_actuator_bus_are_two_interfaces():
    with listening() as (vehicle, _), listening("actuator") as (actuator, _), listening("actuator") as (_, got):
        vehicle.send(FRAME)
        actuator.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER


def test_extended_and_remote_frames_are_counted_and_reading_goes_on():
    with listening() as (bus, got), raw_socket() as outside:
        for identifier in (0x123 | socket.CAN_EFF_FLAG, 0x123 | socket.CAN_RTR_FLAG):
            outside.send(struct.pack("=IB3x8s", identifier, 3, b"\x01\x02\x03"))
        outside.send(struct.pack("=IB3x8s", MARKER.arbitration_id, 1, MARKER.data))
        assert got.get(timeout=ARRIVES_S)[0] == MARKER
        assert bus.dropped["can unreadable"] == 2


def test_an_interface_that_was_down_is_told_and_heard_again_when_it_is_up(system, until):
    with listening() as (bus, got), listening() as (one, _):
        system("ip link set vcan0 down")
        assert not one.send(FRAME)
        assert one.dropped["can send: ENETDOWN"] == 1
        until(lambda: bus.dropped["can receive: ENETDOWN"], "the reader hears of it")
        system("ip link set vcan0 up")
        assert one.send(MARKER)
        assert got.get(timeout=ARRIVES_S)[0] == MARKER


def test_an_adapter_pulled_out_and_put_back_is_used_again(system, until):
    with listening() as (bus, got), listening() as (one, _):
        system("ip link delete vcan0")
        assert not one.send(FRAME)
        until(lambda: bus.dropped["can receive: ENODEV"] > 1, "the reader tries again")
        system("ip link add dev vcan0 type vcan")
        system("ip link set vcan0 up")
        until(lambda: one.send(MARKER) and not got.empty(), "both are bound to the new one")
        assert got.get(timeout=ARRIVES_S)[0] == MARKER
        assert bus.reading


def test_a_full_transmit_queue_is_counted_and_never_waited_for(system):
    system("tc qdisc add dev vcan0 root netem delay 30s limit 10")  # a bus on which nothing moves
    with listening() as (one, _):
        taken = [one.send(FRAME) for _ in range(20)]
        assert taken == [True] * 10 + [False] * 10
        assert one.dropped[f"can send: {errno.errorcode[errno.ENOBUFS]}"] == 10


@pytest.mark.parametrize(
    ("settings", "bus", "says"),
    [
        (CanSettings(interface="socketcan", channel="can7"), "vehicle", r"socketcan can7.*No such device.*set interface"),
        (CanSettings(interface="socketcan", channel=""), "vehicle", "no interface named"),
        (CanSettings(interface="socketcan", channel="vcan0"), "actuator", "second one with actuator_channel"),
    ],
)
def test_an_interface_that_cannot_be_used_is_one_line_that_names_the_setting(settings, bus, says):
    with pytest.raises(ConfigurationError, match=says), listening(bus, settings):
        pass


class Car:
    """The gateway's and the plant's ends around the real ECU: commands go out as `manner` says, the car rolls as demanded."""

    def __init__(self, stack: ExitStack) -> None:
        self.acceleration_m_s2 = 0.0
        self.manner = "good"  # or "silent", "corrupted", "repeated"
        self.speed_m_s = 0.0
        self.damaged = 0  # frames of the ECU
        self.feedback, self.demand = FeedbackState(), DemandState()
        self.commanded_ns = 0  # just before the last good command
        self.demanded_ns: list[tuple[int, bool]] = []  # when, and whether it brakes
        self.vehicle = stack.enter_context(open_bus(SETTINGS, "vehicle", self._on_feedback, Clock()))
        self.actuator = stack.enter_context(open_bus(SETTINGS, "actuator", self._on_demand, Clock()))

    def _on_feedback(self, frame: Frame, _: int) -> None:
        self.feedback, reason = decode(self.feedback, frame)
        self.damaged += reason in ("can crc", "can range")

    def _on_demand(self, frame: Frame, received_ns: int) -> None:
        before = self.demand.demand
        self.demand, _ = decode_demand(self.demand, frame)
        if self.demand.demand is not before:
            self.demanded_ns.append((received_ns, self.demand.demand.brake_m_s2 > 0.0))

    def following(self) -> bool:
        newest = self.feedback.feedback
        return newest is not None and newest.ecu_following

    def braked_ns(self) -> int | None:
        """When it first braked after the last good command."""
        return next((at for at, brakes in self.demanded_ns if brakes and at > self.commanded_ns), None)

    def live(self, stop: threading.Event) -> None:
        number = 0
        while not stop.wait(0.02):
            number += 1
            self._roll()
            self.actuator.send(encode_plant_report(PlantReport(Gear.DRIVE, False, Controls()), number))
            self.actuator.send(encode_plant_motion(Motion(self.speed_m_s, 0.0, 0.0, 0.0), number))
            self._command(number)

    def _roll(self) -> None:
        demand = self.demand.demand
        if demand is not None:
            slower = min(demand.brake_m_s2 * 0.02, abs(self.speed_m_s))
            self.speed_m_s += demand.drive_m_s2 * 0.02 - copysign(slower, self.speed_m_s)

    def _command(self, number: int) -> None:
        if self.manner == "silent":
            return
        if self.manner == "good":
            self.commanded_ns = Clock().now_ns()
        counter = 7 if self.manner == "repeated" else number
        wanted = Actuation(road_wheel_angle_rad=0.1, acceleration_m_s2=self.acceleration_m_s2)
        for frame in encode_command(wanted, Mode.REMOTE, False, counter):
            flipped = Frame(frame.arbitration_id, frame.data[:-1] + bytes([frame.data[-1] ^ 0x10]))
            self.vehicle.send(flipped if self.manner == "corrupted" else frame)


@pytest.fixture
def car(program, tmp_path) -> Iterator[Car]:
    vehicle = shipped("simulated.toml").read_text(encoding="utf-8").split("[vehicle]")[1].split("[vehicle_gateway")[0]
    config = tmp_path / "car.toml"
    config.write_text(
        f"[wire.pace]\nfifo_priority = 0\n[vehicle]{vehicle}"
        f'[vehicle_gateway.can]\ninterface = "socketcan"\nchannel = "vcan0"\nactuator_channel = "vcan1"\n'
        f"[vehicle_gateway.simulation.ecu]\ncommand_timeout_ms = {ECU_TIMEOUT_MS}\nsensor_timeout_ms = {ECU_TIMEOUT_MS}\n"
    )
    stop = threading.Event()
    with ExitStack() as stack, program("vehicle-gateway", "ecu", "--config", config):
        made = Car(stack)
        thread = threading.Thread(target=made.live, args=(stop,))
        thread.start()
        yield made
        stop.set()
        thread.join()


def test_the_real_ecu_follows_our_frames_and_brakes_by_itself_without_good_ones(car, until, figure):
    until(car.following, "the ECU follows")
    assert car.demand.demand.road_wheel_angle_rad == pytest.approx(0.1, abs=0.001)
    for manner in ("silent", "corrupted", "repeated"):
        car.acceleration_m_s2 = 2.0
        until(lambda: car.following() and car.speed_m_s > 1.0, f"the car drives, before {manner}")
        car.manner = manner
        until(lambda: not car.following(), f"the ECU says it does not follow {manner}")
        braked_ns = until(car.braked_ns, "it brakes")  # told on the other bus, by another thread
        after_ms = (braked_ns - car.commanded_ns) / 1e6
        figure(f"CAN, commands {manner}: the ECU brakes {after_ms:.0f} ms after the last good one (set to {ECU_TIMEOUT_MS:.0f})")
        assert after_ms >= ECU_TIMEOUT_MS
        until(lambda: car.speed_m_s == 0.0, f"the car stands, {manner}")
        car.acceleration_m_s2, car.manner = 0.0, "good"
        until(car.following, f"the ECU follows again, after {manner}")
    assert car.damaged == 0
