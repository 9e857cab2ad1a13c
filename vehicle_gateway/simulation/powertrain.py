"""The simulated car from actuator demand to motion: steering, drive, brakes, gears and the body on its springs. Pure.

Without a demand the brakes close by themselves and the steering stays where it is. A person's foot on the brake always
adds. Not modelled: dead time inside an actuator, engine speed, brake temperature, a person's accelerator pedal.
"""

from math import cos, sin
from typing import Annotated, NamedTuple

from msgspec import Meta

from vehicle_gateway.can.actuator_codec import Demand
from vehicle_gateway.can.ecu_codec import Controls
from vehicle_gateway.simulation.single_track import Body, Chassis, ChassisParameters, chassis, step_body
from wire.messages.base import Gear, Message
from wire.messages.vehicle import VehicleDescription

NOBODY = Controls()
SHIFT_BELOW_M_S = 0.3  # the gearbox refuses to change direction above this
HOLDING_FROM_M_S2 = 0.5  # brake force (over the mass) from which a standing car counts as held
TRACTION_SIGN = {Gear.DRIVE: 1.0, Gear.REVERSE: -1.0, Gear.NEUTRAL: 0.0, Gear.PARK: 0.0}
PARK_M_S2 = 4.0  # what the parking pawl holds, as brake force over the mass

Lag = Annotated[float, Meta(ge=0.005, le=2.0)]  # s, time constant
Positive = Annotated[float, Meta(gt=0.0, le=100.0)]


class ActuatorParameters(Message):
    steering_lag_s: Lag = 0.05
    steering_rate_max_rad_s: Positive = 0.5  # at the road wheels; 400 deg/s at the steering wheel with a ratio of 14
    drive_lag_s: Lag = 0.12  # electric drive
    brake_lag_s: Lag = 0.06  # electro-hydraulic brake
    brake_max_m_s2: Positive = 10.0
    self_closing_m_s2: Positive = 6.0  # brakes when nobody demands anything
    torque_to_rate_rad_s_nm: Positive = 0.05  # how fast a person turns the road wheels when the steering gives way
    pitch_per_m_s2: Annotated[float, Meta(ge=0.0, le=0.05)] = 0.004  # rad; 2.2 deg at 1 g
    roll_per_m_s2: Annotated[float, Meta(ge=0.0, le=0.05)] = 0.008  # rad; 4.5 deg at 1 g
    body_frequency_rad_s: Positive = 9.0  # 1.4 Hz
    body_damping: Positive = 0.45  # of critical


class CarParameters(NamedTuple):
    chassis: Chassis
    actuators: ActuatorParameters
    road_wheel_angle_max_rad: float


class Car(NamedTuple):
    """State of the whole car."""

    body: Body = Body()
    road_wheel_angle_rad: float = 0.0
    drive_m_s2: float = 0.0  # force at the wheels over the mass, forward positive
    brake_m_s2: float = 0.0  # >= 0
    gear: Gear = Gear.DRIVE
    pitch_rad: float = 0.0  # nose down positive (ISO 8855)
    roll_rad: float = 0.0  # left side up positive
    pitch_rate_rad_s: float = 0.0
    roll_rate_rad_s: float = 0.0

    @property
    def brake_holding(self) -> bool:
        return self.body.vx_m_s == 0.0 and self.brake_m_s2 >= HOLDING_FROM_M_S2


def car_parameters(
    vehicle: VehicleDescription, chassis_parameters: ChassisParameters, actuators: ActuatorParameters
) -> CarParameters:
    return CarParameters(
        chassis(chassis_parameters, vehicle.mass_kg, vehicle.wheelbase_m), actuators, vehicle.road_wheel_angle_max_rad
    )


def step(car: Car, demand: Demand | None, dt_s: float, p: CarParameters, controls: Controls = NOBODY) -> Car:
    """The car dt_s later (made for 1 ms).

    demand    None: nobody demands anything, the brakes close
    controls  of the person in the driver's seat
    """
    a = p.actuators
    gear = _gear(car, demand)
    drive_target = 0.0 if demand is None else demand.drive_m_s2 * TRACTION_SIGN[gear]
    drive = car.drive_m_s2 + (drive_target - car.drive_m_s2) * min(dt_s / a.drive_lag_s, 1.0)
    brake = car.brake_m_s2 + (_brake_target(demand, controls, a) - car.brake_m_s2) * min(dt_s / a.brake_lag_s, 1.0)
    angle = _angle(car.road_wheel_angle_rad, demand, controls, dt_s, p)
    parked = PARK_M_S2 if gear is Gear.PARK else 0.0
    mass = p.chassis.mass_kg
    body = step_body(car.body, angle, drive * mass, max(brake, parked) * mass, dt_s, p.chassis)
    w, d = a.body_frequency_rad_s, 2 * a.body_damping * a.body_frequency_rad_s
    pitch_rate = (
        car.pitch_rate_rad_s + (w * w * (-a.pitch_per_m_s2 * body.ax_m_s2 - car.pitch_rad) - d * car.pitch_rate_rad_s) * dt_s
    )
    roll_rate = car.roll_rate_rad_s + (w * w * (a.roll_per_m_s2 * body.ay_m_s2 - car.roll_rad) - d * car.roll_rate_rad_s) * dt_s
    return Car(
        body, angle, drive, brake, gear, car.pitch_rad + pitch_rate * dt_s, car.roll_rad + roll_rate * dt_s, pitch_rate, roll_rate
    )


def _gear(car: Car, demand: Demand | None) -> Gear:
    if demand is None or demand.gear is car.gear or abs(car.body.vx_m_s) > SHIFT_BELOW_M_S:
        return car.gear
    return demand.gear


def _brake_target(demand: Demand | None, controls: Controls, a: ActuatorParameters) -> float:
    asked = a.self_closing_m_s2 if demand is None else demand.brake_m_s2
    return min(max(asked, controls.driver_brake * a.brake_max_m_s2), a.brake_max_m_s2)


def _angle(angle_rad: float, demand: Demand | None, controls: Controls, dt_s: float, p: CarParameters) -> float:
    """The road wheels move towards the demand with a lag, never faster than the rate, never beyond the stops."""
    a = p.actuators
    if demand is None:
        return angle_rad
    rate = (
        (demand.road_wheel_angle_rad - angle_rad) / max(a.steering_lag_s, dt_s)
        if not demand.steering_free
        else controls.driver_torque_nm * a.torque_to_rate_rad_s_nm
    )
    step_max = a.steering_rate_max_rad_s
    moved = angle_rad + min(max(rate, -step_max), step_max) * dt_s
    return min(max(moved, -p.road_wheel_angle_max_rad), p.road_wheel_angle_max_rad)


def wheel_speeds_m_s(car: Car, chassis_: Chassis, track_m: float) -> tuple[float, float, float, float]:
    """Rolling speeds front left, front right, rear left, rear right (no wheel slip), along each wheel."""
    body, half = car.body, track_m / 2
    lateral_f = body.vy_m_s + chassis_.front_m * body.yaw_rate_rad_s
    c, s = cos(car.road_wheel_angle_rad), sin(car.road_wheel_angle_rad)
    left, right = body.vx_m_s - half * body.yaw_rate_rad_s, body.vx_m_s + half * body.yaw_rate_rad_s
    return left * c + lateral_f * s, right * c + lateral_f * s, left, right
