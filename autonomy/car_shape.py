"""The car's outline, seen from the middle of its rear axle: what planning and control need of a VehicleDescription."""

from dataclasses import dataclass

from wire.messages.vehicle import VehicleDescription


@dataclass(frozen=True, slots=True, kw_only=True)
class CarShape:
    front_m: float  # rear axle to front bumper
    rear_m: float  # rear axle to rear bumper, positive
    half_width_m: float
    wheelbase_m: float
    road_wheel_angle_max_rad: float
    braking_max_m_s2: float  # what the brakes can do, positive


def car_shape(vehicle: VehicleDescription) -> CarShape:
    return CarShape(
        front_m=vehicle.length_m - vehicle.rear_overhang_m,
        rear_m=vehicle.rear_overhang_m,
        half_width_m=vehicle.width_m / 2,
        wheelbase_m=vehicle.wheelbase_m,
        road_wheel_angle_max_rad=vehicle.road_wheel_angle_max_rad,
        braking_max_m_s2=vehicle.braking_max_m_s2,
    )
