"""Checks of a Toyota: what its public messages can carry against what the configuration asks of the car. Pure."""

from math import degrees, radians

from vehicle_gateway.can.layout import Field
from vehicle_gateway.can.toyota_codec import STEERING_MAX_DEG, YIELD_NM
from vehicle_gateway.can.toyota_layout import toyota_layouts
from vehicle_gateway.check.can import ACCELERATION_STEP_M_S2, ANGLE_STEP_RAD, MISSED_MAX, SPEED_STEP_M_S, covers, in_time
from vehicle_gateway.check.facts import Check, Facts, Outcome

STEP_DEG = 0.1  # of the steering angle sensor, STEER_FRACTION
STEERING_RATE_MAX_DEG_S = 100.0  # opendbc car/toyota: the steering motor reports a fault when it lasts


def _field(message: str, name: str, scale: float) -> Field:
    """A signal in our units."""
    field = next(field for field in toyota_layouts()[message].fields if field.name == name)
    return field._replace(low=field.low * scale, high=field.high * scale, scale=field.scale * scale)


def _cycles(*names: str) -> dict[str, int]:
    return {name: toyota_layouts()[name].cycle_ms for name in names}


def _commanded_angle(facts: Facts) -> Outcome:
    most, field = facts.vehicle.road_wheel_angle_max_rad, _field("STEERING_LTA", "STEER_ANGLE_CMD", 1.0)
    at_the_road = _field("STEERING_LTA", "STEER_ANGLE_CMD", radians(1.0) / facts.vehicle.steering_ratio)
    outcome = covers("STEERING_LTA", at_the_road, -most, most, ANGLE_STEP_RAD)
    fix = f"[vehicle] road_wheel_angle_max_rad: at most {field.high:g} deg / steering_ratio, {at_the_road.high:.4f}"
    return outcome._replace(fix=fix)


def _steering_rate(facts: Facts) -> Outcome:
    gate = facts.gateway.limits.gate
    fastest = degrees(max(gate.road_wheel_rate_max_rad_s, gate.transition_road_wheel_rate_rad_s) * facts.vehicle.steering_ratio)
    return Outcome(
        f"{fastest:.0f} deg/s at the steering wheel, its motor follows {STEERING_RATE_MAX_DEG_S:g}",
        fastest <= STEERING_RATE_MAX_DEG_S,
        "lower limits.gate.road_wheel_rate_max_rad_s and transition_road_wheel_rate_rad_s",
    )


def _commanded_acceleration(facts: Facts) -> Outcome:
    car, field = facts.vehicle, _field("ACC_CONTROL", "ACCEL_CMD", 1.0)
    outcome = covers("ACC_CONTROL", field, -car.braking_max_m_s2, car.acceleration_max_m_s2, ACCELERATION_STEP_M_S2)
    return outcome._replace(fix=f"[vehicle] braking_max_m_s2 at most {-field.low:g}, acceleration_max_m_s2 at most {field.high:g}")


def _measured_angle(facts: Facts) -> Outcome:
    most, step = facts.vehicle.road_wheel_angle_max_rad, radians(STEP_DEG) / facts.vehicle.steering_ratio
    reach = radians(STEERING_MAX_DEG) / facts.vehicle.steering_ratio
    return Outcome(
        f"STEER_ANGLE_SENSOR {reach:.3f} rad in steps of {step:.5f} at the road wheels; needed {most:g}, {ANGLE_STEP_RAD:g}",
        reach >= most and step <= ANGLE_STEP_RAD,
        "measure [vehicle] steering_ratio again",
    )


def _measured_speed(facts: Facts) -> Outcome:
    most = facts.vehicle.speed_max_remote_m_s
    return covers("WHEEL_SPEEDS", _field("WHEEL_SPEEDS", "REAR_LEFT", 1 / 3.6), -most / 2, 1.5 * most, SPEED_STEP_M_S)


def _feedback_in_time(facts: Facts) -> Outcome:
    lost_ms = facts.gateway.limits.failsafe.feedback_lost_ms
    return in_time(_cycles("WHEEL_SPEEDS"), lost_ms, MISSED_MAX, "failsafe.feedback_lost_ms")


def _override_in_time(facts: Facts) -> Outcome:
    """One frame of the brake, which comes every 32 ms, must not be an override by itself: the next one has to follow first."""
    override_ms = facts.gateway.limits.authority.override_ms
    return in_time(_cycles("STEER_TORQUE_SENSOR", "PCM_CRUISE_2"), override_ms, 1, "authority.override_ms")


def _override_before_yielding(facts: Facts) -> Outcome:
    torque_nm = facts.gateway.limits.authority.override_torque_nm
    return Outcome(
        f"an override from {torque_nm:g}, the steering gives way from {YIELD_NM:g} (0.03 per unit of the sensor)",
        torque_nm <= YIELD_NM,
        "lower authority.override_torque_nm: the steering must not give way to a person whom the gateway has not noticed",
    )


def _commands_in_time(facts: Facts) -> Outcome:
    timeout_ms = facts.gateway.simulation.ecu.command_timeout_ms
    return in_time(_cycles("STEERING_LTA", "ACC_CONTROL"), timeout_ms, 2, "simulation.ecu.command_timeout_ms")


def _brakes_without_us(facts: Facts) -> Outcome:
    box = facts.gateway.can.watchdog_box
    return Outcome(
        f"watchdog_box = {str(box).lower()}",
        box or not facts.is_driven_by_its_own_sensors,
        "when commands end this car's cruise control lets go and the car rolls on: put a device between that brakes it, and say so",
    )


TOYOTA_CHECKS = (
    Check("CAN: steering that can be sent", _commanded_angle),
    Check("CAN: steering that can be followed", _steering_rate),
    Check("CAN: acceleration that can be sent", _commanded_acceleration),
    Check("CAN: steering that is measured", _measured_angle),
    Check("CAN: speed that is measured", _measured_speed),
    Check("CAN: motion in time", _feedback_in_time),
    Check("CAN: a person's override in time", _override_in_time),
    Check("CAN: override before the steering gives way", _override_before_yielding),
    Check("CAN: commands in time", _commands_in_time),
    Check("CAN: brakes when the gateway is silent", _brakes_without_us),
)
