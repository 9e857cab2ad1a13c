"""Two cars for trackers to drive: the one the project simulates, and another that the tracker does not know. 1 ms a step.

The other is heavier, softer, on a wet road, with slower actuators and tyres that take their way to build up force (relaxation
length); integrated at 0.25 ms, in a form of its own. Neither has sensors: what is measured is the drive's to say.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import atan2, cos, sin, tan
from typing import NamedTuple

from autonomy.car_shape import CarShape, car_shape
from vehicle_gateway.can.actuator_codec import Demand
from vehicle_gateway.simulation.ecu_core import EcuSettings, split_force
from vehicle_gateway.simulation.powertrain import ActuatorParameters, Car, car_parameters, step
from vehicle_gateway.simulation.single_track import GRAVITY_M_S2, ChassisParameters
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear
from wire.messages.vehicle import VehicleDescription

VEHICLE: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
SHAPE: CarShape = car_shape(VEHICLE)


class Truth(NamedTuple):
    x_m: float
    y_m: float
    heading_rad: float
    speed_m_s: float
    lateral_m_s: float
    yaw_rate_rad_s: float
    road_wheel_angle_rad: float
    acceleration_m_s2: float


@dataclass(frozen=True, slots=True)
class Plant:
    """A car at rest in (0, 0), its step under a demand (angle, acceleration in force), and what is true of it."""

    start: object
    advance: Callable[[object, float, float], object]
    look: Callable[[object], Truth]


def simulated(friction: float = ChassisParameters().friction, slope_rad: float = 0.0) -> Plant:
    """The project's own: chassis, actuators and the ECU's share of force and brakes."""
    parameters = car_parameters(VEHICLE, ChassisParameters(friction=friction, slope_rad=slope_rad), ActuatorParameters())
    ecu = EcuSettings()

    def advance(car: object, angle_rad: float, acceleration_m_s2: float) -> Car:
        assert isinstance(car, Car)
        drive, brake = split_force(acceleration_m_s2, car.body.vx_m_s, Gear.DRIVE, ecu)
        return step(car, Demand(angle_rad, drive, brake), 0.001, parameters)

    def look(car: object) -> Truth:
        assert isinstance(car, Car)
        body = car.body
        lateral = body.vy_m_s - parameters.chassis.rear_m * body.yaw_rate_rad_s
        pose = (body.x_m, body.y_m, body.heading_rad)
        felt = body.ax_m_s2 + GRAVITY_M_S2 * sin(slope_rad)  # as by an accelerometer: not what gravity does along the slope
        return Truth(*pose, body.vx_m_s, lateral, body.yaw_rate_rad_s, car.road_wheel_angle_rad, felt)

    return Plant(Car(), advance, look)


class Other(NamedTuple):
    """State of the other car; the pose is the centre of gravity's."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0
    u: float = 0.0
    v: float = 0.0
    r: float = 0.0
    angle: float = 0.0
    push: float = 0.0  # m/s2
    front: float = 0.0  # lateral forces, N
    rear: float = 0.0
    u_rate: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class OtherCar:
    mass_kg: float = 1450.0 * 1.15
    inertia_kg_m2: float = 2200.0 * 1.2
    front_m: float = 1.25
    rear_m: float = VEHICLE.wheelbase_m - 1.25
    front_n_rad: float = 95_000.0 * 0.85
    rear_n_rad: float = 105_000.0 * 0.9
    friction: float = 0.6
    relaxation_m: float = 0.4
    steering_lag_s: float = 0.07
    push_lag_s: float = 0.15
    rate_max_rad_s: float = 0.5
    drag: float = 0.1  # m/s2 that its ECU does not know of
    angle_error_rad: float = 0.003  # of the steering's own middle


def other(car: OtherCar) -> Plant:
    """From standstill with its rear axle in (0, 0)."""

    def advance(state: object, angle_rad: float, acceleration_m_s2: float) -> Other:
        assert isinstance(state, Other)
        for _ in range(4):
            state = other_step(state, angle_rad + car.angle_error_rad, acceleration_m_s2, 0.00025, car)
        return state

    def look(state: object) -> Truth:
        assert isinstance(state, Other)
        c, s = cos(state.heading), sin(state.heading)
        pose = (state.x - car.rear_m * c, state.y - car.rear_m * s, state.heading)
        measured = state.angle - car.angle_error_rad
        lateral = state.v - car.rear_m * state.r
        return Truth(*pose, state.u, lateral, state.r, measured, state.u_rate - lateral * state.r)

    return Plant(Other(x=car.rear_m), advance, look)


def other_step(state: Other, angle_rad: float, acceleration_m_s2: float, dt_s: float, car: OtherCar) -> Other:
    """Lateral forces grow over the relaxation length towards Fiala's; so standstill is no special case."""
    x, y, heading, u, v, r, angle, push, front, rear, _ = state
    rate = min(max((angle_rad - angle) / car.steering_lag_s, -car.rate_max_rad_s), car.rate_max_rad_s)
    push += (acceleration_m_s2 - push) * dt_s / car.push_lag_s
    weight, wheelbase = car.mass_kg * 9.81, car.front_m + car.rear_m
    load_front = weight * car.rear_m / wheelbase
    rolling = max(u, 0.3)
    slip_front, slip_rear = angle - atan2(v + car.front_m * r, rolling), -atan2(v - car.rear_m * r, rolling)
    share = dt_s * rolling / car.relaxation_m
    front += (brush(slip_front, car.front_n_rad, car.friction * load_front) - front) * share
    rear += (brush(slip_rear, car.rear_n_rad, car.friction * (weight - load_front)) - rear) * share
    damping = 40.0 * max(1.0 - u / 0.5, 0.0)  # a standing car does not slide about on its own slow tyres
    u_rate = push - (car.drag if u > 0.05 else 0.0) - front * sin(angle) / car.mass_kg + v * r
    v_rate = (front * cos(angle) + rear) / car.mass_kg - u * r - damping * v
    r_rate = (car.front_m * front * cos(angle) - car.rear_m * rear) / car.inertia_kg_m2 - damping * r
    u_next = max(u + u_rate * dt_s, 0.0)
    c, s = cos(heading), sin(heading)
    return Other(
        x + (u * c - v * s) * dt_s,
        y + (u * s + v * c) * dt_s,
        heading + r * dt_s,
        u_next,
        v + v_rate * dt_s,
        r + r_rate * dt_s,
        angle + rate * dt_s,
        push,
        front,
        rear,
        (u_next - u) / dt_s,
    )


def brush(slip_rad: float, stiffness: float, grip: float) -> float:
    """Fiala's force from the parabola of pressure under the tyre: what sticks and what slides are summed up."""
    share = min(stiffness * abs(tan(slip_rad)) / (3.0 * grip), 1.0)
    force = grip * (1.0 - (1.0 - share) ** 3)
    return force if slip_rad >= 0.0 else -force
