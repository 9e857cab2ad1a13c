"""`vehicle-gateway simulate`: the shell around the simulated world. Owns the actuator bus, the link, the referee's log.

The plant is integrated at 1 kHz in batches, on a 250 Hz pace, and goes on whatever dies around it: the hub, the ECU,
the recorder. Decides nothing: what a silent ECU means is the world's to say.
"""

import random
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from vehicle_gateway.can.actuator_codec import (
    Demand,
    DemandState,
    decode_demand,
    encode_plant_motion,
    encode_plant_report,
    encode_plant_wheels,
)
from vehicle_gateway.can.bus import Bus, open_bus
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.settings import VehicleGatewaySettings, refuse_beside_a_car
from vehicle_gateway.simulation import referee, sensors
from vehicle_gateway.simulation.outbox import Outbox
from vehicle_gateway.simulation.powertrain import wheel_speeds_m_s
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.simulation.world import (
    advance,
    as_cameras_see_it,
    build,
    motion_of,
    outline_of,
    report_of,
    slope_rad,
    things_to_see,
    valid_demand,
)
from wire.clock import car_clock
from wire.configuration import ConfigurationError, read_sections
from wire.latest import Latest
from wire.link_threads import beneath
from wire.messages.base import encode
from wire.messages.vehicle import VehicleDescription
from wire.pace import Pace
from wire.road import Road
from wire.scenario import find_scenario, read_map, read_scenario
from wire.settings import WireSettings
from wire.topics import PROGRAMS, TOPICS, Role

PERIOD_S = 0.004
STEP_NS = 1_000_000
CATCH_UP_MAX = 100  # steps; a machine that was asleep for longer loses the rest
RATES_HZ = {
    "can motion": 100,
    "can rest": 50,
    "imu": 100,
    "gnss": 10,
    "wheel_speeds": 50,
    "object_list": 10,
    "world_state": round(TOPICS["world_state"].rate_hz),
    "referee": 10,
    "car_health": 1,
}


def run(config: Path, stop: threading.Event) -> int:
    """The simulated car until `stop` is set. Raises ConfigurationError and LinkError at start."""
    read = read_sections(config, {"wire": WireSettings, "vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings})
    wire: WireSettings = read["wire"]
    gateway: VehicleGatewaySettings = read["vehicle_gateway"]
    refuse_beside_a_car(gateway)
    clock, demands = car_clock(wire.clock), Demands()
    with (
        _referee_log(wire.session.folder) as log,
        Outbox(wire.link, Role.SIMULATE, clock, beneath(wire.pace.fifo_priority)) as outbox,
        open_bus(gateway.can, "actuator", demands.on_frame, clock, fifo_priority=wire.pace.fifo_priority) as bus,
        Pace(PERIOD_S, clock, stop, fifo_priority=wire.pace.fifo_priority) as pace,
    ):
        simulation = Simulation(read["vehicle"], gateway.simulation, demands, bus, outbox, log, pace)
        for now_ns in pace:
            simulation.cycle(now_ns)
            if not bus.reading:
                return 1  # the reader has died and said why
    return 0


@contextmanager
def _referee_log(folder: str) -> Iterator[IO[bytes] | None]:
    """The referee's own log, unbuffered: every line is in the file when it is written. None when no folder is set.

    Raises ConfigurationError when it cannot be written.
    """
    if not folder:
        yield None
        return
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
        log = open(Path(folder) / "referee.jsonl", "ab", buffering=0)  # noqa: SIM115 - closed below, whatever happens
    except OSError as error:
        raise ConfigurationError(
            f"{folder}: cannot be written: {error.strerror}; choose another with [wire.session] folder"
        ) from None
    with log:
        yield log


class Demands:
    """Newest demand from the ECU, decoded on the bus's reader thread."""

    def __init__(self) -> None:
        self._state = DemandState()
        self.latest: Latest[DemandState] = Latest()
        self.dropped: dict[str, int] = {}

    def on_frame(self, frame: Frame, received_ns: int) -> None:
        before = self._state.demand
        self._state, reason = decode_demand(self._state, frame)
        if reason:
            self.dropped[reason] = self.dropped.get(reason, 0) + 1
        elif self._state.demand is not before:
            self.latest.put(self._state, received_ns)


class Schedule:
    """When each thing is due: at its own rate, never twice for a missed turn."""

    def __init__(self, rates_hz: dict[str, int], now_ns: int) -> None:
        self._period_ns = {name: 1_000_000_000 // rate for name, rate in rates_hz.items()}
        self._next_ns = dict.fromkeys(rates_hz, now_ns)

    def due(self, name: str, now_ns: int) -> bool:
        if now_ns < self._next_ns[name]:
            return False
        period_ns = self._period_ns[name]
        self._next_ns[name] += ((now_ns - self._next_ns[name]) // period_ns + 1) * period_ns
        return True


class Simulation:
    def __init__(
        self,
        vehicle: VehicleDescription,
        settings: SimulationSettings,
        demands: Demands,
        bus: Bus,
        outbox: Outbox,
        log: IO[bytes] | None,
        pace: Pace,
    ) -> None:
        scenario, map_file = read_scenario(find_scenario(settings.scenario))
        self._settings, self._demands, self._bus = settings, demands, bus
        self._outbox, self._log, self._pace = outbox, log, pace
        self.stage, self.world = build(
            scenario, Road(read_map(map_file)), vehicle, settings, random.Random(f"{scenario.seed} people")
        )
        self._random = random.Random(f"{scenario.seed} sensors")
        self._biases = sensors.draw_biases(settings.sensors, self._random)
        self._simulated_ns: int | None = None
        self._schedule: Schedule | None = None
        self._counter = 0
        self._lost_ms = 0

    def cycle(self, now_ns: int) -> None:
        before = self.world
        self.world = advance(before, self.stage, self._demand(now_ns), self._steps(now_ns))
        schedule = self._schedule = self._schedule or Schedule(RATES_HZ, now_ns)
        self._tell_ecu(schedule, now_ns)
        self._sense(schedule, now_ns)
        if schedule.due("world_state", now_ns):
            self._outbox.put("world_state", as_cameras_see_it(self.world, now_ns))
        news = referee.tells_news(before.referee, self.world.referee)
        if schedule.due("referee", now_ns) or news:
            self._tell_verdict(now_ns)
        if schedule.due("car_health", now_ns):
            self._outbox.put("car_health", self._pace.health(PROGRAMS[Role.SIMULATE], "plant", self._dropped()))

    def _demand(self, now_ns: int) -> Demand | None:
        newest = self._demands.latest.get()
        if newest is None:
            return None
        return valid_demand(newest.message.demand, newest.received_ns, now_ns, self._settings.demand_timeout_ms)

    def _steps(self, now_ns: int) -> int:
        """Whole milliseconds to catch up with the clock."""
        if self._simulated_ns is None:
            self._simulated_ns = now_ns
        due = (now_ns - self._simulated_ns) // STEP_NS
        self._simulated_ns += due * STEP_NS
        self._lost_ms += max(due - CATCH_UP_MAX, 0)
        return min(due, CATCH_UP_MAX)

    def _tell_ecu(self, schedule: Schedule, now_ns: int) -> None:
        if schedule.due("can rest", now_ns):
            self._bus.send(encode_plant_report(report_of(self.world), self._counter))
            wheels = wheel_speeds_m_s(self.world.car, self.stage.parameters.chassis, self._settings.sensors.track_m)
            self._bus.send(encode_plant_wheels(wheels, self._counter))
        if schedule.due("can motion", now_ns):
            self._bus.send(encode_plant_motion(motion_of(self.world.car), self._counter))
            self._counter += 1

    def _sense(self, schedule: Schedule, now_ns: int) -> None:
        car, settings, biases, rng = self.world.car, self._settings.sensors, self._biases, self._random
        if schedule.due("imu", now_ns):
            self._outbox.put("imu", sensors.imu(car, biases, settings, rng, now_ns, slope_rad(self.stage, self.world)))
        if schedule.due("wheel_speeds", now_ns):
            self._outbox.put("wheel_speeds", sensors.wheel_speeds(car, self.stage.parameters, biases, settings, rng, now_ns))
        if schedule.due("gnss", now_ns):
            self._outbox.put("gnss", sensors.gnss(car, biases, settings, rng, now_ns))
        if schedule.due("object_list", now_ns):
            self._outbox.put(
                "object_list",
                sensors.object_list(
                    outline_of(car, self.stage), things_to_see(self.world, self.stage), self.stage.buildings, settings, rng, now_ns
                ),
            )

    def _tell_verdict(self, now_ns: int) -> None:
        verdict = referee.report(
            self.world.referee, self.world.car, self.stage.road, now_ns, self.world.elapsed_s, self.world.station_m
        )
        self._outbox.put("referee", verdict)
        if self._log is not None:
            try:
                self._log.write(encode(verdict) + b"\n")
            except OSError:
                self._outbox.dropped["referee log"] += 1  # a full disk does not stop the car's plant

    def _dropped(self) -> dict[str, int]:
        lost = {"milliseconds lost": self._lost_ms} if self._lost_ms else {}
        counted = {**self._demands.dropped, **self._bus.dropped, **self._outbox.dropped, **lost}
        return {reason: count for reason, count in counted.items() if count}
