"""Checks of the bus, and of a drive-by-wire car's DBC against its limits and against what the gateway waits for. Pure.

A Toyota's: vehicle_gateway.check.toyota.
That the DBC has the messages and signals we speak is checked where it is read (vehicle_gateway.can.dbc).
"""

from collections.abc import Iterable, Mapping

from vehicle_gateway.can.codec import PART_AGE_MAX
from vehicle_gateway.can.dbc import NEEDED
from vehicle_gateway.can.layout import Field
from vehicle_gateway.check.facts import Check, Facts, Outcome, Verdict

ANGLE_STEP_RAD = 0.001  # 0.06 deg: finer than any steering follows
ACCELERATION_STEP_M_S2, SPEED_STEP_M_S = 0.05, 0.05
MISSED_MAX = 5  # frames that may be late before the feedback counts as lost


def _signal(facts: Facts, message: str, name: str) -> Field:
    return next(field for field in facts.layouts[message].fields if field.name == name)


def _covers(facts: Facts, message: str, name: str, low: float, high: float, step: float) -> Outcome:
    return covers(message, _signal(facts, message, name), low, high, step)


def covers(message: str, field: Field, low: float, high: float, step: float) -> Outcome:
    """Whether a signal carries a range, as finely as is needed."""
    return Outcome(
        f"{message}.{field.name} {field.low:g} to {field.high:g} in steps of {field.scale:g}; needed {low:g} to {high:g}, {step:g}",
        field.low <= low and field.high >= high and abs(field.scale) <= step,
        "widen the signal's range or scale in the DBC, or narrow the limit of [vehicle] to what the car's bus can carry",
    )


def _commanded_angle(facts: Facts) -> Outcome:
    most = facts.vehicle.road_wheel_angle_max_rad
    return _covers(facts, "ACTUATION_COMMAND", "ROAD_WHEEL_ANGLE", -most, most, ANGLE_STEP_RAD)


def _commanded_acceleration(facts: Facts) -> Outcome:
    car = facts.vehicle
    low, high = -car.braking_max_m_s2, car.acceleration_max_m_s2
    return _covers(facts, "ACTUATION_COMMAND", "ACCELERATION", low, high, ACCELERATION_STEP_M_S2)


def _measured_angle(facts: Facts) -> Outcome:
    most = facts.vehicle.road_wheel_angle_max_rad
    return _covers(facts, "MOTION_FEEDBACK", "ROAD_WHEEL_ANGLE", -most, most, ANGLE_STEP_RAD)


def _measured_speed(facts: Facts) -> Outcome:
    most = facts.vehicle.speed_max_remote_m_s
    return _covers(facts, "MOTION_FEEDBACK", "SPEED", -most / 2, 1.5 * most, SPEED_STEP_M_S)


def _identities(facts: Facts) -> Outcome:
    layouts = [facts.layouts[name] for name in NEEDED]
    ids, data_ids = {each.arbitration_id for each in layouts}, {each.data_id for each in layouts}
    return Outcome(
        f"{len(NEEDED)} frames, {len(ids)} identifiers, {len(data_ids)} E2E data ids",
        len(ids) == len(data_ids) == len(NEEDED) and 0 not in data_ids,
        'give every frame a BA_ "E2EDataId" of its own: a frame taken for another must fail its CRC',
    )


def _in_time(facts: Facts, names: Iterable[str], limit_ms: float, times: int, of_what: str) -> Outcome:
    return in_time({name: facts.layouts[name].cycle_ms for name in names}, limit_ms, times, of_what)


def in_time(cycles: Mapping[str, int], limit_ms: float, times: int, of_what: str) -> Outcome:
    """Whether so many of these frames come in a time. cycles: [ms], by name."""
    told = ", ".join(f"{name} {cycle} ms" for name, cycle in cycles.items())
    return Outcome(
        f"{told}; {times} of them in {limit_ms:g} ms ({of_what})",
        all(0 < cycle * times <= limit_ms for cycle in cycles.values()),
        f'set BA_ "GenMsgCycleTime" to what the bus shows (candump -td), or {of_what} to more',
    )


def _feedback_in_time(facts: Facts) -> Outcome:
    lost_ms = facts.gateway.limits.failsafe.feedback_lost_ms
    return _in_time(facts, ("MOTION_FEEDBACK",), lost_ms, MISSED_MAX, "failsafe.feedback_lost_ms")


def _rest_in_time(facts: Facts) -> Outcome:
    motion_ms = facts.layouts["MOTION_FEEDBACK"].cycle_ms
    return _in_time(
        facts, ("DRIVE_STATE", "LOCAL_CONTROLS"), PART_AGE_MAX * motion_ms, 2, f"{PART_AGE_MAX} frames of MOTION_FEEDBACK"
    )


def _override_in_time(facts: Facts) -> Outcome:
    override_ms = facts.gateway.limits.authority.override_ms
    return _in_time(facts, ("LOCAL_CONTROLS",), override_ms, 2, "authority.override_ms")


def _commands_in_time(facts: Facts) -> Outcome:
    timeout_ms = facts.gateway.simulation.ecu.command_timeout_ms
    return _in_time(facts, ("ACTUATION_COMMAND",), timeout_ms, MISSED_MAX, "simulation.ecu.command_timeout_ms")


def _interface(facts: Facts) -> Outcome:
    can = facts.gateway.can
    there = ", ".join(sorted(facts.around.can_interfaces)) or "none"
    return Outcome(
        f"{can.interface} {can.channel}" + (f"; this machine has {there}" if can.interface == "socketcan" else ""),
        can.interface != "socketcan" or can.channel in facts.around.can_interfaces,
        f"in the car: ip link set {can.channel} up type can bitrate 500000",
        Verdict.WARNING,
    )


def _bus_of_a_real_car(facts: Facts) -> Outcome:
    can = facts.gateway.can
    return Outcome(
        f"{can.interface}, {'no' if facts.is_driven_by_its_own_sensors else 'a'} scenario",
        can.interface == "socketcan" or not facts.is_driven_by_its_own_sensors,
        '[vehicle_gateway.can] interface = "socketcan": the other two stay within one machine',
    )


BUS_CHECKS = (
    Check("CAN interface", _interface),
    Check("CAN of a real car", _bus_of_a_real_car),
)
CAN_CHECKS = (
    Check("CAN: steering that can be sent", _commanded_angle),
    Check("CAN: acceleration that can be sent", _commanded_acceleration),
    Check("CAN: steering that is measured", _measured_angle),
    Check("CAN: speed that is measured", _measured_speed),
    Check("CAN: frames told apart", _identities),
    Check("CAN: motion in time", _feedback_in_time),
    Check("CAN: rest of the feedback in time", _rest_in_time),
    Check("CAN: a person's override in time", _override_in_time),
    Check("CAN: commands in time", _commands_in_time),
)
