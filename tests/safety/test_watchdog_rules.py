"""A gateway that hangs while something repeats its frames: watchdog, ECU and plant in a closed loop. And the program itself."""

import threading

import pytest

from tests.vehicle_gateway.test_ecu import PARAMETERS, VEHICLE_TOML
from vehicle_gateway import watchdog_program
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.codec import FOLLOWING, encode_command
from vehicle_gateway.can.ecu_codec import Command, Motion, encode_motion
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.can.watch_codec import SHIPPED, Fault, StopState, decode_stop
from vehicle_gateway.safe_stop import stopping_distance_m
from vehicle_gateway.simulation.ecu_core import EcuInputs, EcuSettings, EcuState, ecu_step
from vehicle_gateway.simulation.powertrain import Car, step
from vehicle_gateway.simulation.single_track import Body
from vehicle_gateway.watchdog import Heard, Watch, WatchLimits, watch_step
from wire.clock import Clock
from wire.configuration import ConfigurationError
from wire.messages.base import Gear
from wire.messages.vehicle import Actuation, Mode

MS = 1_000_000
ECU = EcuSettings()


class Stuck:
    """Every 10 ms a fresh command frame of a gateway that drives with 0.5 m/s2; from `hung_ms` on nothing new stands behind it."""

    def __init__(self, speed, watched, hung_ms):
        self.now, self.ms, self.watched, self.hung_ms = 10**12, 0, watched, hung_ms
        self.car = Car(body=Body(vx_m_s=speed))
        self.ecu = EcuState(condition=FOLLOWING, acceleration_m_s2=0.0)
        self.watch, self.stop_ns, self.sources = Watch(), None, 0
        self.asked_m = None  # where the watchdog first asked for a stop

    def run(self, ms):
        for _ in range(round(ms / 10)):
            self.tick()
        return self

    def tick(self):
        self.now, self.ms = self.now + 10 * MS, self.ms + 10
        self.sources += self.ms <= self.hung_ms
        body = self.car.body
        heard = Heard(
            command_ns=self.now,
            mode=Mode.REMOTE,
            acceleration_m_s2=0.5,
            sources=self.sources % 65535,
            motion_ns=self.now,
            speed_m_s=body.vx_m_s,
        )
        if self.watched and self.ms % 20 == 0:
            self.watch = watch_step(self.watch, heard, self.now, WatchLimits())
            if self.watch.fault:
                self.stop_ns, self.asked_m = self.now, body.x_m if self.asked_m is None else self.asked_m
        given = EcuInputs(
            command=Command(Mode.REMOTE, 0.0, 0.5, Gear.DRIVE, False),
            command_ns=self.now,
            motion=Motion(body.vx_m_s, 0.0, body.forward_m_s2, 0.0),
            motion_ns=self.now,
            stop_ns=self.stop_ns,
        )
        self.ecu, demand = ecu_step(self.ecu, given, self.now, ECU)
        for _ in range(10):
            self.car = step(self.car, demand, 0.001, PARAMETERS)


def test_the_ecu_alone_would_follow_a_hung_gateway_whose_frames_are_repeated_with_fresh_counters():
    assert Stuck(5.0, False, 1000).run(6000).car.body.vx_m_s > 6.0


@pytest.mark.parametrize("speed", [3.0, 8.33])
def test_with_the_watchdog_that_car_stands_within_the_formula_and_stays(speed):
    stuck = Stuck(speed, True, 1000).run(1000)
    assert stuck.watch.fault is Fault.NONE
    stuck.run(8000)
    assert stuck.watch.fault is Fault.STARVED
    reached = speed + 0.5 * 1.75 + 0.1
    bound = stopping_distance_m(reached, 0.03 + 2 * 0.06, ECU.braking_m_s2, ECU.jerk_m_s3)  # two cycles, twice the brake's lag
    assert stuck.car.body.vx_m_s == 0.0
    assert stuck.car.body.x_m - stuck.asked_m <= bound
    x = stuck.car.body.x_m
    assert stuck.run(5000).car.body.x_m == x


def test_the_program_hears_a_gateway_fall_silent_and_asks_the_ecu_to_stop(tmp_path):
    config = tmp_path / "car.toml"
    config.write_text(
        '[wire.pace]\nfifo_priority = 0\n[vehicle_gateway.can]\ninterface = "virtual"\nchannel = "watchdog-test"\n' + VEHICLE_TOML
    )
    can, stop, asked, content = CanSettings(interface="virtual", channel="watchdog-test"), threading.Event(), threading.Event(), []
    state, result = StopState(), []

    def on_frame(frame, _):
        nonlocal state
        state, reason = decode_stop(state, frame)
        content.append((state.fault, reason))
        if state.fault:
            asked.set()

    with open_bus(can, "vehicle", on_frame, Clock()) as bus:
        thread = threading.Thread(target=lambda: result.append(watchdog_program.run(config, stop)))
        thread.start()
        actuation = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=-1.0)
        counter = 0
        while not content and counter < 500:
            threading.Event().wait(0.01)  # until it is there
            counter += 1
        for frame in encode_command(actuation, Mode.STANDBY, True, 1):
            bus.send(frame)
        bus.send(SHIPPED.encode_sources(10**9, 1))
        bus.send(encode_motion(Motion(0.0, 0.0, 0.0, 0.0), 1))
        heard = asked.wait(5.0)
        stop.set()
        thread.join(5.0)
    assert (heard, result, state.fault) == (True, [0], Fault.SILENT)
    assert content[0] == (Fault.NONE, "")


def test_a_car_whose_ecu_obeys_no_watchdog_is_told_so(tmp_path):
    config = tmp_path / "car.toml"
    config.write_text('[vehicle_gateway.can]\nvehicle = "toyota"\n' + VEHICLE_TOML)
    with pytest.raises(ConfigurationError, match="GATEWAY_SOURCES"):
        watchdog_program.run(config, threading.Event())
