"""The ECU alone, and the closed loop of codec, ECU and plant in simulated time: no process, no socket, no clock."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st
from msgspec.structs import replace

from tests.messages import vehicle_description
from vehicle_gateway.can import actuator_codec, ecu_codec
from vehicle_gateway.can.actuator_codec import DemandState, PlantReport, PlantState, decode_demand, decode_plant
from vehicle_gateway.can.bus import open_bus
from vehicle_gateway.can.codec import FAULT, FOLLOWING, TIMED_OUT, FeedbackState, decode, encode_command
from vehicle_gateway.can.e2e import Trail
from vehicle_gateway.can.ecu_codec import Body, Command, CommandState, Controls, Motion, decode_command
from vehicle_gateway.can.settings import CanSettings
from vehicle_gateway.simulation import ecu as ecu_shell
from vehicle_gateway.simulation.ecu import Ecu
from vehicle_gateway.simulation.ecu_core import EcuInputs, EcuSettings, EcuState, ecu_step, split_force
from vehicle_gateway.simulation.powertrain import ActuatorParameters, Car, car_parameters, step
from vehicle_gateway.simulation.single_track import Body as CarBody
from vehicle_gateway.simulation.single_track import ChassisParameters
from wire.clock import Clock
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.vehicle import Actuation, Mode

VEHICLE = vehicle_description()
SETTINGS, ACTUATORS = EcuSettings(), ActuatorParameters()
PARAMETERS = car_parameters(VEHICLE, ChassisParameters(), ACTUATORS)
MS = 1_000_000
COMMAND = Command(Mode.REMOTE, 0.1, 1.0, Gear.DRIVE, False)
FOLLOWING_STATE = EcuState(condition=FOLLOWING, acceleration_m_s2=0.0, stepped_ns=0)


def inputs(command=COMMAND, age_ms=0, speed=5.0, motion_age_ms=0, now_ms=1000, **changes):
    return EcuInputs(
        command=command,
        command_ns=(now_ms - age_ms) * MS,
        motion=Motion(speed, 0.0, 0.0, 0.0),
        motion_ns=(now_ms - motion_age_ms) * MS,
        **changes,
    )


def once(state, given_inputs, now_ms=1000):
    return ecu_step(state, given_inputs, now_ms * MS, SETTINGS)


def test_before_the_first_frame_nothing_is_commanded_demanded_or_measured():
    assert CommandState() == CommandState(command=None, body=Body(Indicators.OFF, False, False, Lights.OFF, Wipers.OFF), trails={})
    assert DemandState() == DemandState(demand=None, trail=Trail(None, None, 0))
    assert PlantState() == PlantState(motion=None, report=None, wheels_m_s=None, trails={})


def test_it_follows_a_fresh_command():
    state, demand = once(FOLLOWING_STATE, inputs())
    resistance = SETTINGS.rolling_m_s2 + SETTINGS.drag_1_m * 25.0
    assert state.condition == FOLLOWING
    assert demand[:3] == (0.1, pytest.approx(1.0 + resistance), 0.0)


def test_it_starts_with_the_brakes_on_and_the_hazard_lights():
    _, demand = once(EcuState(), EcuInputs())
    assert (demand.drive_m_s2, demand.brake_m_s2, demand.hazard) == (0.0, 4.0, True)


@pytest.mark.parametrize(
    ("command_ms", "motion_ms", "condition"), [(100, 100, FOLLOWING), (101, 0, TIMED_OUT), (0, 101, FAULT), (101, 101, FAULT)]
)
def test_it_times_out_after_100_ms_and_not_before(command_ms, motion_ms, condition):
    assert once(FOLLOWING_STATE, inputs(age_ms=command_ms, motion_age_ms=motion_ms))[0].condition == condition


@pytest.mark.parametrize("condition", [TIMED_OUT, FAULT])
@pytest.mark.parametrize(("speed", "follows"), [(3.0, False), (0.06, False), (-0.06, False), (0.04, True), (0.0, True)])
def test_it_follows_again_only_when_the_car_stands(condition, speed, follows):
    state, _ = once(replace(FOLLOWING_STATE, condition=condition), inputs(speed=speed))
    assert (state.condition == FOLLOWING) == follows


def test_on_its_own_it_brakes_with_limited_jerk_holds_the_steering_and_warns():
    state, given_inputs = once(FOLLOWING_STATE, inputs())[0], inputs()
    brakes = []
    for tick in range(12, 80):
        state, demand = ecu_step(state, replace(given_inputs, motion_ns=(1000 + tick * 10) * MS), (1000 + tick * 10) * MS, SETTINGS)
        brakes.append(demand.brake_m_s2)
        assert (demand.road_wheel_angle_rad, demand.drive_m_s2, demand.hazard) == (0.1, 0.0, True)
    steps = [b - a for a, b in zip(brakes, brakes[1:], strict=False)]
    assert max(steps) <= SETTINGS.jerk_m_s3 * 0.01 + 1e-9
    assert brakes[-1] == pytest.approx(SETTINGS.braking_m_s2 - SETTINGS.rolling_m_s2 - SETTINGS.drag_1_m * 25.0)
    assert brakes == sorted(brakes)


@given(
    acceleration=st.floats(-10, 5),
    speed=st.floats(-2, 20),
    gear=st.sampled_from(Gear),
    mode=st.sampled_from(Mode),
    hold=st.booleans(),
    age=st.integers(0, 300),
    motion_age=st.integers(0, 300),
    emergency=st.booleans(),
    condition=st.sampled_from([FOLLOWING, TIMED_OUT, FAULT]),
)
def test_it_never_drives_and_brakes_at_once_and_never_drives_without_a_fresh_command(
    acceleration, speed, gear, mode, hold, age, motion_age, emergency, condition
):
    state, demand = once(
        replace(FOLLOWING_STATE, condition=condition),
        inputs(Command(mode, 0.0, acceleration, gear, hold), age, speed, motion_age, controls=Controls(emergency_button=emergency)),
    )
    assert demand.drive_m_s2 >= 0.0
    assert demand.brake_m_s2 >= 0.0
    assert demand.drive_m_s2 == 0.0 or demand.brake_m_s2 == 0.0
    if age > 100 or motion_age > 100 or emergency or mode is Mode.LOCAL_DRIVER or gear in (Gear.NEUTRAL, Gear.PARK):
        assert demand.drive_m_s2 == 0.0
    if emergency:
        assert demand.brake_m_s2 >= SETTINGS.emergency_m_s2
    if state.condition == FOLLOWING and acceleration < -1.0:
        assert demand.brake_m_s2 >= -acceleration - SETTINGS.rolling_m_s2 - SETTINGS.drag_1_m * speed**2 - 1e-9


def test_brake_hold_holds_a_standing_car_and_leaves_a_moving_one_to_the_command():
    hold = COMMAND._replace(acceleration_m_s2=-0.5, brake_hold=True)
    assert once(FOLLOWING_STATE, inputs(hold, speed=0.0))[1].brake_m_s2 == SETTINGS.hold_m_s2
    assert once(FOLLOWING_STATE, inputs(hold, speed=3.0))[1].brake_m_s2 < 0.5


def test_with_a_local_driver_the_steering_gives_way_and_nothing_drives_but_a_commanded_brake_counts():
    local = COMMAND._replace(mode=Mode.LOCAL_DRIVER)
    demand = once(FOLLOWING_STATE, inputs(local))[1]
    assert (demand.steering_free, demand.drive_m_s2) == (True, 0.0)
    assert once(FOLLOWING_STATE, inputs(local._replace(acceleration_m_s2=-3.0)))[1].brake_m_s2 > 2.5
    assert not once(FOLLOWING_STATE, inputs(local, age_ms=200))[1].steering_free


def test_lamps_are_those_commanded_until_it_brakes_on_its_own():
    body = Body(Indicators.LEFT, False, True, Lights.HIGH, Wipers.SLOW)
    following = once(FOLLOWING_STATE, inputs(body=body))[1]
    assert (following.indicators, following.hazard, following.horn) == (Indicators.LEFT, False, True)
    alone = once(FOLLOWING_STATE, inputs(age_ms=200, body=body))[1]
    assert (alone.indicators, alone.hazard, alone.horn) == (Indicators.OFF, True, False)
    for demand in (following, alone):  # lamps and wipers stay as they were: it is dark, or rains, all the same
        assert (demand.lights, demand.wipers) == (Lights.HIGH, Wipers.SLOW)


def test_a_demand_of_zero_never_creeps_and_a_rolling_car_keeps_its_speed():
    assert split_force(0.0, 0.0, Gear.DRIVE, SETTINGS) == (0.0, 0.0)
    assert split_force(0.0, 5.0, Gear.DRIVE, SETTINGS) == (pytest.approx(SETTINGS.rolling_m_s2 + SETTINGS.drag_1_m * 25), 0.0)
    assert split_force(0.0, -2.0, Gear.REVERSE, SETTINGS)[0] == pytest.approx(SETTINGS.rolling_m_s2 + SETTINGS.drag_1_m * 4)
    assert split_force(-2.0, -5.0, Gear.DRIVE, SETTINGS) == (0.0, 2.0)  # rolling the other way: all of the brake


class Loop:
    """Gateway's codec, ECU and plant joined by frames alone, 1 ms at a time."""

    def __init__(self, speed=0.0, parameters=PARAMETERS):
        self.parameters = parameters
        self.car = Car(body=CarBody(vx_m_s=speed))
        self.ms = 0
        self.feedback, self.commands, self.plant, self.demands = FeedbackState(), CommandState(), PlantState(), DemandState()
        self.ecu, self.inputs = EcuState(), EcuInputs()
        self.counter = 0
        self.dropped: list[str] = []

    def run(self, milliseconds, actuation=None, mode=Mode.REMOTE, hold=False, demands=True):
        for _ in range(milliseconds):
            self.ms += 1
            if self.ms % 10 == 0:
                self._plant_speaks()
                if actuation is not None:
                    self._gateway_speaks(actuation, mode, hold)
                if demands:
                    self._ecu_speaks()
            self.car = step(self.car, self.demands.demand, 0.001, self.parameters)
        return self

    def _take(self, decoded):
        state, reason = decoded
        if reason:
            self.dropped.append(reason)
        return state

    def _plant_speaks(self):
        self.counter += 1
        body = self.car.body
        motion = Motion(body.vx_m_s, self.car.road_wheel_angle_rad, body.forward_m_s2, body.yaw_rate_rad_s)
        report = PlantReport(self.car.gear, self.car.brake_holding, Controls())
        for frame in (
            actuator_codec.encode_plant_report(report, self.counter),
            actuator_codec.encode_plant_motion(motion, self.counter),
        ):
            self.plant = self._take(decode_plant(self.plant, frame))
        self.inputs = replace(self.inputs, motion=self.plant.motion, motion_ns=self.ms * MS)
        for frame in (
            ecu_codec.encode_drive_state(self.plant.report.gear, self.ecu.condition, self.plant.report.brake_holding, self.counter),
            ecu_codec.encode_controls(self.plant.report.controls, self.counter),
            ecu_codec.encode_motion(self.plant.motion, self.counter),
        ):
            self.feedback = self._take(decode(self.feedback, frame))

    def _gateway_speaks(self, actuation, mode, hold):
        for frame in encode_command(actuation, mode, hold, self.counter):
            self.commands = self._take(decode_command(self.commands, frame))
        self.inputs = replace(self.inputs, command=self.commands.command, body=self.commands.body, command_ns=self.ms * MS)

    def _ecu_speaks(self):
        self.ecu, demand = ecu_step(self.ecu, self.inputs, self.ms * MS, SETTINGS)
        self.demands = self._take(decode_demand(self.demands, actuator_codec.encode_demand(demand, self.counter)))


def drive(acceleration, angle=0.0):
    return Actuation(road_wheel_angle_rad=angle, acceleration_m_s2=acceleration)


def test_the_loop_drives_with_the_acceleration_that_was_commanded():
    loop = Loop().run(500, drive(-1.0)).run(3000, drive(1.5))
    lag = ACTUATORS.drive_lag_s + ACTUATORS.brake_lag_s
    assert loop.feedback.feedback.speed_m_s == pytest.approx(1.5 * (3.0 - lag), rel=0.05)
    assert loop.feedback.feedback.ecu_following
    assert loop.dropped == []


@pytest.mark.parametrize("speed", [2.0, 4.0, 8.33, 13.9])
def test_when_commands_end_the_car_stands_within_the_formula(speed):
    """v t_r + v^2 / 2a + v a / 2j - a^3 / 24 j^2: a ramp of a/j seconds, then constant braking (integrated by hand).

    t_r is the time-out, one cycle of the ECU, and the mean delay of the brakes.
    """
    loop = Loop().run(300, drive(-1.0))
    loop.car = loop.car._replace(body=CarBody(vx_m_s=speed), brake_m_s2=0.0)
    loop.run(200, drive(0.0))
    start, v = loop.car.body.x_m, loop.car.body.vx_m_s
    loop.run(8000)
    a, j = SETTINGS.braking_m_s2, SETTINGS.jerk_m_s3
    reaction = SETTINGS.command_timeout_ms / 1000 + 0.010 + ACTUATORS.brake_lag_s
    if v > a * a / (2 * j):  # the ramp ends before the car stands
        bound = v * reaction + v * v / (2 * a) + v * a / (2 * j) - a**3 / (24 * j * j)
        assert bound - v * 0.02 - 0.1 < loop.car.body.x_m - start < bound + 0.02 * v
    assert loop.car.body.vx_m_s == 0.0
    assert loop.car.brake_holding
    assert loop.feedback.feedback.ecu_following is False


def test_commands_that_come_back_while_the_car_rolls_are_not_followed_until_it_stands():
    loop = Loop().run(300, drive(-1.0)).run(4000, drive(1.5))
    loop.run(150).run(400, drive(1.5))
    assert not loop.feedback.feedback.ecu_following
    assert loop.car.drive_m_s2 < 0.1
    loop.run(4000, drive(1.5))
    assert loop.feedback.feedback.ecu_following
    assert loop.car.body.vx_m_s > 0.5


def test_when_the_ecu_dies_the_plants_own_brakes_stop_the_car():
    loop = Loop().run(300, drive(-1.0)).run(4000, drive(1.5))
    loop.demands = DemandState()  # what the plant makes of 60 ms of silence
    start, v = loop.car.body.x_m, loop.car.body.vx_m_s
    loop.run(3000, drive(1.5), demands=False)
    assert loop.car.body.vx_m_s == 0.0
    expected = v * (ACTUATORS.brake_lag_s + ACTUATORS.drive_lag_s * 1.5 / 6.0) + v * v / (2 * ACTUATORS.self_closing_m_s2)
    assert loop.car.body.x_m - start == pytest.approx(expected, rel=0.05)


def test_it_stands_and_holds_for_ten_seconds_without_moving_a_millimetre():
    loop = Loop().run(500, drive(-1.0), hold=True)
    x = loop.car.body.x_m
    assert loop.run(10_000, drive(0.0), hold=True).car.body.x_m == x


class Collecting:
    def __init__(self):
        self.frames, self.reading = [], True

    def send(self, frame):
        self.frames.append(frame)
        return True


def joined_ecu():
    ecu = Ecu(SETTINGS)
    ecu.vehicle_bus, ecu.actuator_bus = Collecting(), Collecting()
    return ecu


def test_a_new_command_is_passed_on_at_once_without_waiting_for_the_cycle():
    ecu = joined_ecu()
    ecu.on_plant_frame(actuator_codec.encode_plant_motion(Motion(0.0, 0.0, 0.0, 0.0), 0), MS)
    command, _ = encode_command(drive(1.0, angle=0.2), Mode.REMOTE, False, 0)
    ecu.on_vehicle_frame(command, 2 * MS)
    (frame,) = ecu.actuator_bus.frames
    demand = decode_demand(DemandState(), frame)[0].demand
    assert (demand.road_wheel_angle_rad, demand.drive_m_s2 > 0.9) == (pytest.approx(0.2), True)
    ecu.on_vehicle_frame(command, 3 * MS)  # repeated: dropped, nothing passed on
    assert len(ecu.actuator_bus.frames) == 1


def test_a_cycle_demands_only_when_no_command_has_since_the_one_before():
    ecu = joined_ecu()
    for tick in range(4):
        if tick == 1:
            ecu.on_vehicle_frame(encode_command(drive(1.0), Mode.REMOTE, False, 0)[0], tick * 10 * MS - MS)
        ecu.cycle(tick * 10 * MS)
    assert len(ecu.actuator_bus.frames) == 4  # of which the command's is one: the cycle after it had nothing to add


def test_what_it_refused_is_told_once_with_its_reason(caplog):
    ecu = joined_ecu()
    command, _ = encode_command(drive(1.0), Mode.REMOTE, False, 0)
    for _ in range(3):
        ecu.on_vehicle_frame(command, MS)
    ecu.tell_refused()
    ecu.tell_refused()
    assert [record.fields for record in caplog.records] == [{"reason": "can counter", "frames": 2}]


def test_motion_is_passed_on_as_it_comes_and_the_rest_every_other_cycle():
    ecu, state = joined_ecu(), FeedbackState()
    ecu.on_plant_frame(actuator_codec.encode_plant_report(PlantReport(Gear.DRIVE, True, Controls(True)), 0), 0)
    ecu.on_plant_frame(actuator_codec.encode_plant_wheels((0.0, 0.0, 0.0, 0.0), 0), 0)
    for tick in range(1, 21):
        ecu.on_plant_frame(actuator_codec.encode_plant_motion(Motion(1.0, 0.0, 0.0, 0.0), tick), tick * 10 * MS)
        ecu.cycle(tick * 10 * MS)
    counts: dict[int, int] = {}
    for frame in ecu.vehicle_bus.frames:
        state, reason = decode(state, frame)
        assert reason == ""
        counts[frame.arbitration_id] = counts.get(frame.arbitration_id, 0) + 1
    assert counts == {0x200: 20, 0x210: 10, 0x220: 10, 0x230: 10}
    assert state.feedback.seat_occupied
    assert len(ecu.actuator_bus.frames) == 20


def test_frames_that_come_before_the_buses_are_joined_are_no_error():
    ecu = Ecu(SETTINGS)
    ecu.on_plant_frame(actuator_codec.encode_plant_motion(Motion(0.0, 0.0, 0.0, 0.0), 0), MS)
    ecu.on_vehicle_frame(encode_command(drive(1.0), Mode.REMOTE, False, 0)[0], 2 * MS)


def test_the_program_answers_on_the_actuator_bus_until_it_is_stopped(tmp_path):
    config = tmp_path / "car.toml"
    config.write_text(
        '[wire.pace]\nfifo_priority = 0\n[vehicle_gateway.can]\ninterface = "virtual"\nchannel = "ecu-test"\n' + VEHICLE_TOML
    )
    can, stop, seen = CanSettings(interface="virtual", channel="ecu-test"), threading.Event(), threading.Event()
    result = []
    with open_bus(can, "actuator", lambda frame, _: seen.set(), Clock()):
        thread = threading.Thread(target=lambda: result.append(ecu_shell.run(config, stop)))
        thread.start()
        answered = seen.wait(5.0)
        stop.set()
        thread.join(5.0)
    assert (answered, result) == (True, [0])


VEHICLE_TOML = """
[vehicle]
vehicle_id = "test"
length_m = 4.5
width_m = 1.76
height_m = 1.5
wheelbase_m = 2.7
rear_overhang_m = 0.9
steering_ratio = 14.0
road_wheel_angle_max_rad = 0.6
acceleration_max_m_s2 = 2.0
braking_max_m_s2 = 8.0
speed_max_remote_m_s = 8.33
mass_kg = 1450.0
cameras = []
"""
