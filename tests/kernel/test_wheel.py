"""A G920 drives a car, is pulled out in the middle of it, and drives again only when it is armed anew and asked to.

The wheel is a real input device of a real kernel (uinput); cockpit, gateway and ECU are the programs themselves, joined by
the real link and by CAN (vcan). The car's body, on the actuator bus, is the test's. There is no window and no camera: this
car's description requires none. Emulated, everything is slow, so the car has longer limits (LIMITS).
"""

import json
import threading
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from vehicle_gateway.can.actuator_codec import DemandState, PlantReport, decode_demand, encode_plant_motion, encode_plant_report
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.can.settings import CanSettings
from wire import certificates
from wire.clock import Clock
from wire.configuration import shipped
from wire.link import open_link
from wire.messages.base import Gear
from wire.messages.vehicle import Mode
from wire.settings import LinkSettings
from wire.topics import Role

NAME = "Logitech G920"
STEERING, THROTTLE, BRAKE = 0, 1, 2  # evdev codes of the G920's axes
RELEASED, FLAT = 255, 120  # pedals; they are inverted
MIDDLE = 32768
DEAD_MAN, ACCEPT = 293, 288  # left paddle, A
PERIOD_S = 0.02
ASKS_AGAIN_NS = 5_000_000_000
LIMITS = """
[vehicle_gateway.limits.failsafe]
command_gentle_ms = 1000.0
command_lost_ms = 2000.0
feedback_lost_ms = 1000.0
[vehicle_gateway.limits.safe_stop]
blind_speed_m_s = 8.0
[vehicle_gateway.limits.hand_over]
commit_ms = 2000.0
command_fresh_ms = 500.0
[vehicle_gateway.simulation.ecu]
command_timeout_ms = 1000.0
sensor_timeout_ms = 1000.0
[haptics.alignment]
telemetry_age_max_ms = 1000.0
"""


class G920:
    """The wheel in its own process, and everything it has said."""

    def __init__(self, stack: ExitStack, start) -> None:
        self.said: list[dict] = []
        self._process = start("g920.py", piped=True)
        reader = threading.Thread(target=self._listen)
        reader.start()
        stack.callback(reader.join)
        stack.callback(self._process.wait)
        stack.callback(self._process.kill)

    def _listen(self) -> None:
        for line in self._process.stdout:
            self.said.append(json.loads(line))

    def do(self, *words: object) -> None:
        print(*words, file=self._process.stdin, flush=True)

    def uploads(self, effect: str) -> list[list[int]]:
        return [said["words"] for said in self.said if said["what"] == "upload" and said["effect"] == effect]

    def rest(self) -> None:
        """Rim in the middle, both pedals touched and released: what an operator does who sits down."""
        self.do("axis", STEERING, MIDDLE)
        for pedal in (THROTTLE, BRAKE):
            self.do("axis", pedal, FLAT)
            self.do("axis", pedal, RELEASED)


class Body:
    """The car's body: rolls as the ECU's demand says, tells its motion."""

    def __init__(self, stack: ExitStack, settings: CanSettings) -> None:
        self.speed_m_s = 0.0
        self._demand = DemandState()
        self._bus = stack.enter_context(open_bus(settings, "actuator", self._on_frame, Clock()))
        stop = threading.Event()
        thread = threading.Thread(target=self._live, args=(stop,))
        thread.start()
        stack.callback(thread.join)
        stack.callback(stop.set)

    def _on_frame(self, frame, _) -> None:
        self._demand, _ = decode_demand(self._demand, frame)

    def _live(self, stop: threading.Event) -> None:
        number, before_ns = 0, Clock().now_ns()
        while not stop.wait(PERIOD_S):
            now_ns = Clock().now_ns()
            self._roll((now_ns - before_ns) / 1e9)
            number, before_ns = number + 1, now_ns
            holds = self.speed_m_s == 0.0
            self._bus.send(encode_plant_report(PlantReport(Gear.DRIVE, holds, Controls()), number))
            self._bus.send(encode_plant_motion(Motion(self.speed_m_s, 0.0, 0.0, 0.0), number))

    def _roll(self, dt_s: float) -> None:
        demand = self._demand.demand
        if demand is not None:
            self.speed_m_s = max(self.speed_m_s + (demand.drive_m_s2 - demand.brake_m_s2) * dt_s, 0.0)


class Drive:
    """What the tower's hub lets a window know."""

    def __init__(self, link, wheel: G920, body: Body) -> None:
        self.wheel, self.body = wheel, body
        self.asked_ns = 0
        self._operator, self._gateway = link.level("operator_status"), link.level("gateway_status")

    @property
    def operator(self):
        newest = self._operator.get()
        return newest.message if newest else None

    @property
    def status(self):
        newest = self._gateway.get()
        return newest.message if newest else None

    def mode(self):
        return self.status.mode if self.status else None


def configuration(folder: Path) -> tuple[Path, LinkSettings]:
    trusted = folder / "certificates"
    certificates.make(trusted)
    vehicle = shipped("simulated.toml").read_text(encoding="utf-8").split("[vehicle]")[1].split("[vehicle_gateway")[0]
    config = folder / "car.toml"
    config.write_text(
        f'[wire.pace]\nfifo_priority = 0\n[wire.link]\ncertificates = "{trusted}"\n'
        f"[vehicle]{vehicle.replace('required = true', 'required = false')}\n"
        f'[vehicle_gateway]\nmemory = "{folder / "memory.json"}"\n'
        '[vehicle_gateway.can]\ninterface = "socketcan"\nchannel = "vcan2"\nactuator_channel = "vcan3"\n'
        f'[tower.cockpit]\noperator = "ann"\ndevice = "keyboard"\n{LIMITS}',
        encoding="utf-8",
    )
    return config, LinkSettings(certificates=str(trusted))


@pytest.fixture(scope="module")
def drive(system, start, program, until, tmp_path_factory) -> Iterator[Drive]:
    config, settings = configuration(tmp_path_factory.mktemp("drive"))
    can = CanSettings(interface="socketcan", channel="vcan2", actuator_channel="vcan3")
    with ExitStack() as stack:
        for name in (can.channel, can.actuator_channel):
            system(f"ip link add dev {name} type vcan")
            stack.callback(system, f"ip link delete {name}")
            system(f"ip link set {name} up")
        wheel = G920(stack, start)
        wheel.do("plug")
        for name, command in (("vehicle-gateway", "run"), ("vehicle-gateway", "ecu"), ("tower", "cockpit")):
            stack.enter_context(program(name, command, "--config", config))
        body = Body(stack, can)
        stop = threading.Event()
        stack.callback(stop.set)
        link = stack.enter_context(open_link(settings, Role.WINDOW, Clock(), stop))
        made = Drive(link, wheel, body)
        until(lambda: made.status and made.operator and made.operator.lease_epoch, "the tower has the car's lease")
        yield made


def test_a_g920_is_found_armed_and_driven_pulled_out_and_drives_again_only_when_armed_and_asked_to(drive, until, figure):
    """One story for one start: everything takes half a minute to come up."""
    found_but_drives_nothing_before_its_pedals_have_spoken(drive, until)
    armed_it_drives_and_the_spring_is_uploaded(drive, until)
    pulled_out_the_car_stops_and_the_cockpit_says_why(drive, until, figure)
    back_it_drives_only_when_armed_and_asked_to(drive, until, figure)


def press(wheel: G920, button: int) -> None:
    wheel.do("button", button, 1)
    wheel.do("button", button, 0)


def asked_for_and_given(drive: Drive) -> bool:
    """Asks, and asks again where a hand-over came to nothing, as an operator does: a busy machine lets one expire."""
    now_ns, mode = Clock().now_ns(), drive.mode()
    if mode not in (Mode.HANDING_OVER, Mode.REMOTE) and now_ns - drive.asked_ns > ASKS_AGAIN_NS:
        press(drive.wheel, ACCEPT)
        drive.asked_ns = now_ns
    return mode is Mode.REMOTE


def found_but_drives_nothing_before_its_pedals_have_spoken(drive: Drive, until) -> None:
    until(lambda: drive.wheel.uploads("damper"), "the wheel is found: its effects are uploaded")
    drive.wheel.do("button", DEAD_MAN, 1)
    until(lambda: drive.operator.device == NAME, "the paddle selects it")
    assert not drive.operator.armed, "the kernel's first 0 on an inverted axis is full throttle"
    assert drive.operator.throttle == 0.0
    assert drive.mode() is Mode.STANDBY


def armed_it_drives_and_the_spring_is_uploaded(drive: Drive, until) -> None:
    drive.wheel.rest()
    until(lambda: drive.operator.armed, "armed")
    until(lambda: asked_for_and_given(drive), "the operator drives")
    drive.wheel.do("axis", THROTTLE, FLAT)
    until(lambda: drive.body.speed_m_s > 3.0, "the car rolls")
    until(lambda: any(coefficient > 0 for coefficient, *_ in drive.wheel.uploads("spring")), "the rim has a spring")


def pulled_out_the_car_stops_and_the_cockpit_says_why(drive: Drive, until, figure) -> None:
    assert drive.mode() is Mode.REMOTE
    began_ns, speed = Clock().now_ns(), drive.body.speed_m_s
    drive.wheel.do("unplug")
    until(lambda: not drive.operator.dead_man, "the dead-man counts as released")  # the kernel lets every button of it go
    noticed_ns = Clock().now_ns()
    until(lambda: drive.operator.device_note == f"{NAME} unplugged", "and the cockpit says why")
    assert not drive.operator.dead_man
    assert drive.operator.throttle == 0.0
    until(lambda: drive.mode() in (Mode.SAFE_STOP, Mode.STOPPED), "the car makes a safe stop")
    stopping_ns = Clock().now_ns()
    until(lambda: drive.mode() is Mode.STOPPED and drive.body.speed_m_s == 0.0, "it stands")
    figure(
        f"wheel, pulled out at {speed:.1f} m/s: known after {(noticed_ns - began_ns) / 1e6:.0f} ms, safe stop after "
        f"{(stopping_ns - began_ns) / 1e6:.0f} ms (command_lost_ms is 2000), standing after "
        f"{(Clock().now_ns() - began_ns) / 1e9:.1f} s"
    )


def back_it_drives_only_when_armed_and_asked_to(drive: Drive, until, figure) -> None:
    drive.wheel.said.clear()
    began_ns = Clock().now_ns()
    drive.wheel.do("plug")
    until(lambda: drive.wheel.uploads("damper"), "the wheel is found again")
    figure(f"wheel, plugged in again: felt after {(Clock().now_ns() - began_ns) / 1e9:.1f} s")
    drive.wheel.do("button", DEAD_MAN, 1)
    press(drive.wheel, ACCEPT)
    until(lambda: drive.operator.hand_over_note.startswith("take"), "it is asked for without having been armed")
    assert drive.operator.device_note == f"{NAME} unplugged"
    assert not drive.operator.dead_man
    assert drive.mode() is Mode.STOPPED
    drive.wheel.rest()
    until(lambda: drive.operator.armed and not drive.operator.device_note, "armed anew")
    until(lambda: asked_for_and_given(drive), "the operator drives again")
    drive.wheel.do("axis", THROTTLE, FLAT)
    until(lambda: drive.body.speed_m_s > 0.5, "the car rolls again")
