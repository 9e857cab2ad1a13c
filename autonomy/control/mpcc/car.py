"""What the tracker reckons the car to be: axles, tyres, resistances, actuators. Pure.

Forces are over the mass of the car throughout (m/s2), so the mass itself matters only here. The defaults are the compact car of
1450 kg that the project simulates; a real car's are measured (steady-state circles, coasting, steps of each actuator).
"""

from typing import Annotated, NamedTuple

from msgspec import Meta

from autonomy.car_shape import CarShape
from autonomy.control.mpcc.stages import STAGE_S
from wire.messages.base import Message

GRAVITY_M_S2 = 9.81
KINEMATIC_BELOW_M_S = 2.0  # slip angles say nothing at walking pace
DYNAMIC_ABOVE_M_S = 5.0
STABLE = 2.7  # of the classic Runge-Kutta rule: decay rate times step, at most

Positive = Annotated[float, Meta(gt=0.0, le=1e6)]
Lag = Annotated[float, Meta(ge=0.005, le=1.0)]  # s, time constant


class CarModel(Message):
    mass_kg: Annotated[float, Meta(ge=100.0, le=50_000.0)] = 1450.0
    front_share: Annotated[float, Meta(gt=0.2, lt=0.8)] = 0.55  # of the weight, at rest
    yaw_inertia_kg_m2: Positive = 2200.0
    gravity_height_m: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.55
    front_stiffness_n_rad: Positive = 95_000.0  # cornering stiffness of both tyres of the axle
    rear_stiffness_n_rad: Positive = 105_000.0
    friction: Annotated[float, Meta(ge=0.05, le=1.2)] = 0.9  # dry asphalt
    front_drive: Annotated[float, Meta(ge=0.0, le=1.0)] = 1.0  # share of the drive force; brakes share as the axles are loaded
    rolling_m_s2: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.118  # resistance at any speed
    drag_1_m: Annotated[float, Meta(ge=0.0, le=0.01)] = 0.00029  # and with its square
    steering_lag_s: Lag = 0.05
    drive_lag_s: Lag = 0.12
    brake_lag_s: Lag = 0.06
    dead_time_s: Annotated[float, Meta(ge=0.0, le=0.3)] = 0.02  # from a command to the first that an actuator does of it


class Car(NamedTuple):
    """The same, as the kernels read it; forces, stiffnesses and inertia over the mass."""

    wheelbase: float
    front: float  # centre of gravity to front axle
    rear: float
    height: float
    inertia: float  # m2
    front_stiffness: float  # m/s2 per rad
    rear_stiffness: float
    friction: float
    front_drive: float
    rolling: float
    drag: float
    steering_lag: float
    drive_lag: float
    brake_lag: float
    dead_time: float


def car_of(model: CarModel, shape: CarShape) -> Car:
    """Raises ValueError for a car whose tyres act too fast for the stages."""
    front, rear = shape.wheelbase_m * (1 - model.front_share), shape.wheelbase_m * model.front_share
    stiffness = model.front_stiffness_n_rad, model.rear_stiffness_n_rad
    aside = sum(stiffness) / model.mass_kg
    turning = (front**2 * stiffness[0] + rear**2 * stiffness[1]) / model.yaw_inertia_kg_m2
    if max(aside, turning) * STAGE_S / DYNAMIC_ABOVE_M_S > STABLE:
        raise ValueError(
            f"the car's lateral motion decays with {max(aside, turning):.0f} m/s2 over its speed, the tracker can follow "
            f"{STABLE * DYNAMIC_ABOVE_M_S / STAGE_S:.0f}: check mass, yaw inertia and cornering stiffness"
        )
    car = Car(
        wheelbase=shape.wheelbase_m,
        front=front,
        rear=rear,
        height=model.gravity_height_m,
        inertia=model.yaw_inertia_kg_m2 / model.mass_kg,
        front_stiffness=stiffness[0] / model.mass_kg,
        rear_stiffness=stiffness[1] / model.mass_kg,
        friction=model.friction,
        front_drive=model.front_drive,
        rolling=model.rolling_m_s2,
        drag=model.drag_1_m,
        steering_lag=model.steering_lag_s,
        drive_lag=model.drive_lag_s,
        brake_lag=model.brake_lag_s,
        dead_time=model.dead_time_s,
    )
    return Car(*map(float, car))  # an integer would have the kernels compiled anew for its type
