"""A hill in a closed loop: the gateway's cycle, the simulated ECU and the plant on a slope, without frames between them."""

from math import sin
from random import Random

import pytest
from msgspec.structs import replace

from tests.messages import feedback
from tests.vehicle_gateway.test_ecu import ACTUATORS, VEHICLE
from vehicle_gateway.authority import Authority
from vehicle_gateway.can.actuator_codec import Demand
from vehicle_gateway.can.codec import FOLLOWING
from vehicle_gateway.can.ecu_codec import Command, Controls, Motion
from vehicle_gateway.cycle import step
from vehicle_gateway.simulation.ecu_core import EcuInputs, EcuSettings, EcuState, ecu_step
from vehicle_gateway.simulation.powertrain import Car, car_parameters
from vehicle_gateway.simulation.powertrain import step as step_car
from vehicle_gateway.simulation.settings import SimulationSettings
from vehicle_gateway.simulation.single_track import Body, ChassisParameters, on_slope
from vehicle_gateway.simulation.world import advance, build
from vehicle_gateway.state import GatewayLimits, Inputs, initial_state
from wire.configuration import shipped
from wire.messages.base import Gear
from wire.messages.vehicle import Mode
from wire.messages.vehicle import VehicleDescription as Vehicle
from wire.road import Road
from wire.scenario import read_map, read_scenario

CAR: Vehicle = replace(VEHICLE, cameras=())
WEAK = EcuSettings(hold_m_s2=0.6)  # an ECU that holds with too little by itself
SECOND = 10**9


class Hill:
    """The car on a slope; `gateway` False: it is dead."""

    def __init__(self, slope_rad, mode=Mode.STOPPED, ecu=EcuSettings(), gear=Gear.DRIVE):  # noqa: B008 - frozen
        flat = car_parameters(CAR, ChassisParameters(), ACTUATORS)
        self.parameters = flat._replace(chassis=on_slope(flat.chassis, slope_rad))
        self.now, self.gateway, self.settings = 10**12, True, ecu
        self.car = Car(body=Body(), brake_m_s2=6.0, gear=gear)
        self.ecu, self.command, self.command_ns, self.controls = EcuState(gear=gear), None, 0, Controls()
        state = initial_state("boot", self.now, 1, False)
        self.state = replace(state, authority=Authority(mode=mode, origin=mode), applied=replace(state.applied, gear=gear))
        self.out = None

    def run(self, seconds):
        for _ in range(round(seconds * 100)):
            self.tick()
        return self

    def tick(self):
        self.now += SECOND // 100
        body = self.car.body
        motion = Motion(round(body.vx_m_s, 2), self.car.road_wheel_angle_rad, body.forward_m_s2, body.yaw_rate_rad_s)
        if self.gateway:
            told = feedback(
                speed_m_s=motion.speed_m_s,
                gear=self.car.gear,
                ecu_following=self.ecu.condition == FOLLOWING,
                seat_occupied=self.controls.seat_occupied,
            )
            self.state, self.out = step(self.state, Inputs(feedback=told), self.now, CAR, GatewayLimits())
            asked = self.out.applied
            self.command = Command(
                self.out.mode, asked.road_wheel_angle_rad, asked.acceleration_m_s2, asked.gear, self.out.brake_hold
            )
            self.command_ns = self.now
        given = EcuInputs(
            command=self.command, command_ns=self.command_ns, motion=motion, motion_ns=self.now, controls=self.controls
        )
        self.ecu, demand = ecu_step(self.ecu, given, self.now, self.settings)
        for _ in range(10):
            self.car = step_car(self.car, demand, 0.001, self.parameters, self.controls)


@pytest.mark.parametrize("slope", [0.15, -0.15, 0.28, -0.28])
def test_the_brakes_hold_on_a_hill_and_without_the_gateway(slope):
    hill = Hill(slope).run(1.0)
    x = hill.car.body.x_m
    hill.run(5.0)
    hill.gateway = False
    hill.run(5.0)
    assert hill.car.body.x_m == x
    assert hill.state.causes == ()


@pytest.mark.parametrize("mode", [Mode.STOPPED, Mode.STANDBY])
@pytest.mark.parametrize("slope", [0.25, -0.25])
def test_a_held_car_that_rolls_is_held_harder_with_hazard_lights_and_stands_within_a_metre(slope, mode):
    """An ECU too weak to hold, and 2 m/s2 of ours where the slope pulls with 2.4: it starts to roll."""
    assert 9.81 * sin(0.25) > 2.0 + 0.12
    hill = Hill(slope, mode, WEAK)
    seen = set()
    for _ in range(1000):
        hill.tick()
        seen |= set(hill.state.causes)
    assert seen == {"rolled_away"}
    assert abs(hill.car.body.x_m) < 1.0
    assert hill.car.body.vx_m_s == 0.0
    assert hill.out.applied.acceleration_m_s2 == -6.0
    assert hill.out.applied.hazard
    assert hill.out.mode is Mode.STOPPED
    x = hill.car.body.x_m
    assert hill.run(10.0).car.body.x_m == x


def test_what_it_is_held_against_is_no_rolling_away_when_the_person_in_the_car_lets_it_roll():
    hill = Hill(0.1, Mode.LOCAL_DRIVER)
    hill.controls = Controls(seat_occupied=True)
    hill.car = hill.car._replace(brake_m_s2=0.0)
    hill.run(3.0)
    assert hill.car.body.vx_m_s < -1.0
    assert hill.out.mode is Mode.LOCAL_DRIVER
    assert hill.state.causes == ()


def test_a_slope_of_a_map_s_segment_is_felt_along_the_road_and_against_it():
    scenario, map_file = read_scenario(shipped("scenarios", "closed_road.toml"))
    told = read_map(map_file)
    first, *rest = told.segments
    road = Road(replace(told, segments=(replace(first, slope_rad=0.1), *rest)))
    assert (road.slope_rad(1.0), road.slope_rad(first.length_m + 1.0)) == (0.1, 0.0)
    stage, world = build(scenario, road, CAR, SimulationSettings(), Random(1))

    free = Demand(0.0, 0.0, 0.0)
    for turn, sign in ((0.0, -1.0), (3.14159, 1.0)):
        body = world.car.body._replace(heading_rad=world.car.body.heading_rad + turn, vx_m_s=0.0)
        start = replace(world, car=world.car._replace(body=body, brake_m_s2=0.0))
        rolled = advance(start, stage, free, 1000).car.body.vx_m_s
        assert rolled == pytest.approx(sign * (9.81 * sin(0.1) - 0.118), rel=0.05)
