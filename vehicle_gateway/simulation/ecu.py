"""`vehicle-gateway ecu`: the shell of the simulated drive-by-wire ECU. Owns both CAN buses' ends; has no link at all,
so it tells the health of its loop on CAN.

Every new command is passed on to the actuators at once, on the reader thread; a 100 Hz cycle does everything else, and
demands when no command has since the last one. What a command or its absence means is `ecu_core`'s to say. Prints nothing in
normal operation; frames that it refuses, once a second.
"""

import logging
import threading
from collections import Counter
from contextlib import ExitStack
from pathlib import Path

from msgspec.structs import replace

from vehicle_gateway.can.actuator_codec import PlantState, decode_plant, encode_demand
from vehicle_gateway.can.bus import Bus, open_bus
from vehicle_gateway.can.ecu_codec import (
    CommandState,
    decode_command,
    encode_controls,
    encode_drive_state,
    encode_motion,
    encode_wheels,
)
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.health_codec import LOOP, SHIPPED
from vehicle_gateway.can.settings import DRIVE_BY_WIRE
from vehicle_gateway.can.watch_codec import SHIPPED as WATCH
from vehicle_gateway.can.watch_codec import StopState, decode_stop
from vehicle_gateway.settings import VehicleGatewaySettings, refuse_beside_a_car
from vehicle_gateway.simulation.ecu_core import EcuInputs, EcuSettings, EcuState, ecu_step
from wire.clock import car_clock
from wire.configuration import ConfigurationError, read_sections
from wire.logs import fields
from wire.messages.health import LoopHealth
from wire.messages.vehicle import VehicleDescription
from wire.pace import Pace
from wire.settings import WireSettings
from wire.topics import ECU

PERIOD_S = 0.01
HEALTH_CYCLES = 100  # once a second
log = logging.getLogger(__name__)


def run(config: Path, stop: threading.Event) -> int:
    """The ECU until `stop` is set. Raises ConfigurationError at start."""
    read = read_sections(config, {"wire": WireSettings, "vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings})
    priority = read["wire"].pace.fifo_priority
    gateway: VehicleGatewaySettings = read["vehicle_gateway"]
    refuse_beside_a_car(gateway)
    if gateway.can.vehicle != DRIVE_BY_WIRE:
        raise ConfigurationError(
            f'[vehicle_gateway.can] vehicle = "{gateway.can.vehicle}": the simulated ECU speaks "{DRIVE_BY_WIRE}" only; set that'
        )
    clock = car_clock(read["wire"].clock)
    with ExitStack() as stack:
        ecu = Ecu(gateway.simulation.ecu)
        ecu.vehicle_bus = stack.enter_context(open_bus(gateway.can, "vehicle", ecu.on_vehicle_frame, clock, fifo_priority=priority))
        ecu.actuator_bus = stack.enter_context(open_bus(gateway.can, "actuator", ecu.on_plant_frame, clock, fifo_priority=priority))
        pace = stack.enter_context(Pace(PERIOD_S, clock, stop, fifo_priority=priority))
        for number, now_ns in enumerate(pace, start=1):
            ecu.cycle(now_ns)
            if number % HEALTH_CYCLES == 0:
                ecu.tell_health(pace.health(ECU, LOOP), number // HEALTH_CYCLES)
                ecu.tell_refused()
            if not (ecu.vehicle_bus.reading and ecu.actuator_bus.reading):
                return 1  # a reader has died and said why
    return 0


class Ecu:
    """Joins the two readers and the cycle under one lock."""

    def __init__(self, settings: EcuSettings) -> None:
        self._settings = settings
        self._lock = threading.Lock()
        self._commands, self._plant = CommandState(), PlantState()
        self._inputs, self._state = EcuInputs(), EcuState()
        self._stop = StopState()
        self._refused: Counter[str] = Counter()  # frames of the vehicle bus by reason, since it was last told
        self._demands = self._cycles = self._motions = 0  # counters of the frames sent
        self._demanded = False  # by a command, since the last cycle
        self.vehicle_bus: Bus | None = None
        self.actuator_bus: Bus | None = None

    def on_vehicle_frame(self, frame: Frame, received_ns: int) -> None:
        with self._lock:
            if frame.arbitration_id == WATCH.stop.arbitration_id:
                self._obey(frame, received_ns)
                return
            before = self._commands
            self._commands, reason = decode_command(before, frame)
            if reason:
                self._refused[reason] += 1
            self._inputs = replace(self._inputs, body=self._commands.body)
            if self._commands.command is not before.command:
                self._inputs = replace(self._inputs, command=self._commands.command, command_ns=received_ns)
                self._demand(received_ns)
                self._demanded = True

    def _obey(self, frame: Frame, received_ns: int) -> None:
        self._stop, reason = decode_stop(self._stop, frame)
        if not reason and self._stop.fault:
            self._inputs = replace(self._inputs, stop_ns=received_ns)

    def on_plant_frame(self, frame: Frame, received_ns: int) -> None:
        with self._lock:
            before = self._plant
            self._plant, _ = decode_plant(before, frame)
            if self._plant.report is not None:
                self._inputs = replace(self._inputs, controls=self._plant.report.controls)
            if self._plant.motion is not before.motion and self._plant.motion is not None:
                self._inputs = replace(self._inputs, motion=self._plant.motion, motion_ns=received_ns)
                self._motions += 1
                _send(self.vehicle_bus, encode_motion(self._plant.motion, self._motions))

    def cycle(self, now_ns: int) -> None:
        """100 Hz: step and demand unless a command just did, and every other time the rest of the feedback."""
        with self._lock:
            if not self._demanded:
                self._demand(now_ns)
            self._demanded = False
            self._cycles += 1
            report = self._plant.report
            if self._cycles % 2 or report is None:
                return
            counter, condition = self._cycles // 2, self._state.condition
            body = self._inputs.body  # lamps and wipers have no sensor: what the ECU demands of them
            state = encode_drive_state(report.gear, condition, report.brake_holding, counter, body.lights, body.wipers)
            _send(self.vehicle_bus, state)
            _send(self.vehicle_bus, encode_controls(report.controls, counter))
            if self._plant.wheels_m_s is not None:
                _send(self.vehicle_bus, encode_wheels(self._plant.wheels_m_s, counter))

    def tell_health(self, health: LoopHealth, counter: int) -> None:
        for frame in SHIPPED.encode(health, counter):
            _send(self.vehicle_bus, frame)

    def tell_refused(self) -> None:
        """Into the log, when there were any."""
        with self._lock:
            refused, self._refused = self._refused, Counter()
        for reason, frames in refused.items():
            log.warning("refused", extra=fields(reason=reason, frames=frames))

    def _demand(self, now_ns: int) -> None:
        self._state, demand = ecu_step(self._state, self._inputs, now_ns, self._settings)
        self._demands += 1
        _send(self.actuator_bus, encode_demand(demand, self._demands))


def _send(bus: Bus | None, frame: Frame) -> None:
    """A frame that comes in while the other bus is still being opened has nowhere to go yet."""
    if bus is not None:
        bus.send(frame)
