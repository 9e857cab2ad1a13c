"""A wheel's event to the CAN frame that carries it: the real cockpit, gateway, ECU and car, over the loopback link.

An event is injected where the device's events enter the cockpit (benchmarks.datagram_wheel); the operator drives, the car
stands. Time ends when the ACTUATION_COMMAND with the new angle has arrived on the multicast CAN bus in this process. One
clock. The camera and the window are this process: pictures are always 60 ms old. Beside each event, in the same run, a bare
UDP datagram goes to another process and one comes back. Not measured: USB, the wheel's driver, a real CAN controller.
"""

import json
import random
import socket
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import monotonic, monotonic_ns

from benchmarks.datagram_wheel import PROFILE
from benchmarks.figures import Figure, figure, percentile
from benchmarks.rig import RigError
from benchmarks.session import program, running, session
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.ecu_codec import CommandState, decode_command
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.settings import VehicleGatewaySettings
from wire.clock import Clock
from wire.configuration import read_sections
from wire.latest import Latest
from wire.link import Link, open_link
from wire.messages.operating import WindowStatus
from wire.messages.sensing import CameraStatus
from wire.messages.vehicle import GatewayStatus, Mode, VehicleDescription, VehicleState
from wire.ports import free_udp_ports
from wire.settings import PaceSettings, WireSettings
from wire.topics import Role

NAME = "wheel"
EVENTS = 400
REACH_MS = {"p50": 4.0, "p99": 10.0}
PAUSE_S = (0.023, 0.041)  # between events: never in step with any loop
PATIENCE_S = 20.0  # until the operator drives
LOST_S = 0.5  # an event that has not arrived by then is lost
PICTURE_AGE_NS = 60_000_000
STEP_COUNTS = 60  # of the axis: 0.2 deg of a real wheel, 1 mrad at the road wheels
BRAKES_M_S2 = -0.7  # more than a released throttle, engine braking of 0.5
STOPWATCH_PRIORITY = 20  # of the thread that takes the time: the same in both cases
RELAY = "import socket,sys\ns=socket.socket(socket.AF_INET,socket.SOCK_DGRAM)\ns.bind(('127.0.0.1',int(sys.argv[1])))\n" + (
    "while True:\n d,a=s.recvfrom(64)\n s.sendto(d,a)"
)
BUTTON = {name: button for button, name in PROFILE.buttons.items()}


def figures() -> Iterator[Figure]:
    for fifo_priority, case in ((0, "plain"), (PaceSettings().fifo_priority, f"SCHED_FIFO {PaceSettings().fifo_priority}")):
        with tempfile.TemporaryDirectory(prefix="wheel-") as folder:
            events_ms, datagrams_ms = measure(Path(folder), fifo_priority)
        for what, share in (("p50", 0.50), ("p99", 0.99)):
            peer = ("a bare UDP datagram there and back", percentile(datagrams_ms, share))
            yield figure(NAME, case, what, "ms", percentile(events_ms, share), peer=peer, at_most=REACH_MS[what])


def measure(folder: Path, fifo_priority: int) -> tuple[list[float], list[float]]:
    """Milliseconds of every event and of every datagram. Raises RigError when the operator does not come to drive."""
    with driven(folder, fifo_priority) as (bench, _, _):
        return bench.events()


@contextmanager
def driven(folder: Path, fifo_priority: int) -> Iterator[tuple["Bench", Path, int]]:
    """The session with the operator driving, its configuration, and the cockpit's process id. Raises RigError."""
    config = session(folder, fifo_priority, device="keyboard")
    wheel_port, relay_port = free_udp_ports(2)
    commands = (
        (sys.executable, "-m", "benchmarks.datagram_wheel", str(config), str(wheel_port)),
        program("vehicle-gateway", "run", "--config", str(config)),
        program("vehicle-gateway", "simulate", "--config", str(config)),
        program("vehicle-gateway", "ecu", "--config", str(config)),
        (sys.executable, "-c", RELAY, str(relay_port)),
    )
    with running(folder, *commands) as (cockpit, *_), Bench(config, wheel_port, relay_port) as bench:
        bench.take_the_wheel()
        yield bench, config, cockpit.pid


class Bench:
    """This process: the wheel's hand, the camera, the window, and the stopwatch on the CAN bus."""

    def __init__(self, config: Path, wheel_port: int, relay_port: int) -> None:
        sections = read_sections(
            config, {"wire": WireSettings, "vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings}
        )
        self._link_settings, self._can = sections["wire"].link, sections["vehicle_gateway"].can
        self._cameras = [camera.name for camera in sections["vehicle"].cameras]
        self._wheel, self._relay = ("127.0.0.1", wheel_port), ("127.0.0.1", relay_port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.settimeout(LOST_S)
        self._commands = CommandState()
        self.braked_ns, self._asked_m_s2 = 0, 0.0
        self._angle_rad, self._changed_ns, self._changed = 0.0, 0, threading.Event()
        self.status: GatewayStatus | None = None
        self._stop, self._stack = threading.Event(), ExitStack()

    def __enter__(self) -> "Bench":
        clock = Clock()
        self._stack.enter_context(open_bus(self._can, "vehicle", self._on_frame, clock, fifo_priority=STOPWATCH_PRIORITY))
        links = [
            self._stack.enter_context(open_link(self._link_settings, role, clock, self._stop)) for role in (Role.VIDEO, Role.WINDOW)
        ]
        self.state: Latest[VehicleState] = links[1].level("vehicle_state")
        links[1].on("gateway_status", lambda status, _: setattr(self, "status", status))
        thread = threading.Thread(target=self._tell, args=links, daemon=True)
        thread.start()
        self._stack.callback(thread.join)
        self._stack.callback(self._stop.set)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        self._socket.close()

    def _tell(self, video: Link, window: Link) -> None:
        """Camera and window, 30 Hz: each picture is new and 60 ms old."""
        number = 0
        while not self._stop.wait(1 / 30):
            number, now_ns = number + 1, monotonic_ns()
            for name in self._cameras:
                video.publish("camera_status", camera_status(name, number, now_ns))
            shown = dict.fromkeys(self._cameras, now_ns - PICTURE_AGE_NS)
            window.publish(
                "window_status",
                WindowStatus(
                    stamp_ns=now_ns, sequence=number, displayed_capture_ns=shown, frozen=False, shown=(), frames_dropped=0
                ),
            )

    def _on_frame(self, frame: Frame, received_ns: int) -> None:
        self._commands, _ = decode_command(self._commands, frame)
        command = self._commands.command
        if command is not None and command.acceleration_m_s2 < BRAKES_M_S2 <= self._asked_m_s2:
            self.braked_ns = received_ns
        self._asked_m_s2 = command.acceleration_m_s2 if command is not None else self._asked_m_s2
        if command is not None and command.road_wheel_angle_rad != self._angle_rad:
            self._angle_rad, self._changed_ns = command.road_wheel_angle_rad, received_ns
            self._changed.set()

    def inject(self, **readings: float) -> int:
        """Send what the device would report; when."""
        sent_ns = monotonic_ns()
        self._socket.sendto(json.dumps([sent_ns, list(readings.items())]).encode(), self._wheel)
        return sent_ns

    def take_the_wheel(self) -> None:
        """Pedals released, the rim in the middle, the dead-man held, a press: until the car says that the operator drives."""
        self.wait(lambda: self.status is not None, "the gateway to speak")
        middle = (PROFILE.steering.left + PROFILE.steering.right) / 2
        pedals = {PROFILE.throttle.axis: PROFILE.throttle.released, PROFILE.brake.axis: PROFILE.brake.released}
        self.inject(**{PROFILE.steering.axis: middle, **pedals, BUTTON["dead_man"]: 1.0})

        def pressed() -> bool:
            self.inject(**{BUTTON["accept"]: 1.0})
            self._stop.wait(0.1)
            self.inject(**{BUTTON["accept"]: 0.0})
            return self.status is not None and self.status.mode is Mode.REMOTE

        self.wait(pressed, "the operator to drive")
        self.pause(3.0)  # smaller steps while control changes hands, and what is left of a misalignment is blended out

    def pause(self, seconds: float) -> None:
        self._stop.wait(seconds)

    def wait(self, done: Callable[[], bool], what: str) -> None:
        """Raises RigError after a while."""
        until = monotonic() + PATIENCE_S
        while not done():
            if monotonic() > until:
                status = self.status
                raise RigError(f"waited {PATIENCE_S:g} s for {what}: {status and (status.mode, status.cause, status.take_refused)}")
            self._stop.wait(0.1)

    def events(self) -> tuple[list[float], list[float]]:
        events_ms, datagrams_ms = [], []
        pauses, middle = random.Random(1), (PROFILE.steering.left + PROFILE.steering.right) / 2
        for number in range(EVENTS):
            self._stop.wait(pauses.uniform(*PAUSE_S))
            self._changed.clear()
            sent_ns = self.inject(**{PROFILE.steering.axis: middle + STEP_COUNTS * ((number + 1) % 2)})
            if not self._changed.wait(LOST_S):
                raise RigError(f"event {number} did not reach the bus within {LOST_S:g} s")
            events_ms.append((self._changed_ns - sent_ns) / 1e6)
            begin_ns = monotonic_ns()
            self._socket.sendto(b"x", self._relay)
            self._socket.recv(64)
            datagrams_ms.append((monotonic_ns() - begin_ns) / 1e6)
        return events_ms, datagrams_ms


def camera_status(name: str, number: int, now_ns: int) -> CameraStatus:
    """A camera as it should be."""
    return CameraStatus(
        stamp_ns=now_ns,
        camera=name,
        source="simulated",
        live=True,
        newest_capture_ns=now_ns,
        frames=number,
        repeated=0,
        bitrate_kbps=3000.0,
        encode_ms=5.0,
        watching=1,
    )
