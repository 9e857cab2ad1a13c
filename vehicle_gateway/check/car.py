"""Checks of geometry, braking and the order of the failsafe's times. Pure; each compares a few numbers of the configuration."""

from math import degrees, tan

from vehicle_gateway.can.settings import TOYOTA
from vehicle_gateway.check.facts import Check, Facts, Outcome, Verdict
from vehicle_gateway.safe_stop import stopping_distance_m
from wire.messages.automation import STOPPING_CORRIDOR_M

WIDTH_MAX_M, HEIGHT_MAX_M = 2.55, 4.0  # EU directive 96/53/EC
TURNING_RADIUS_M = (2.5, 15.0)  # of the rear axle's middle: a fork-lift to a long bus
STEERING_LOCK_RAD = (2.0, 16.0)  # less is a kart; more does not fit into the messages (wire.messages.base)
FRICTION_M_S2 = 10.0  # a dry road holds no more
WHEEL_RANGE_RAD = 7.854  # 900 degrees from lock to lock: G920, G29, G923
WIDE_TURNS = "nothing to mend: this car takes no more over its bus; choose routes without tight turns"
CYCLE_MS = 10.0  # of the gateway, at the least


def _overhang(facts: Facts) -> Outcome:
    car = facts.vehicle
    front = car.length_m - car.rear_overhang_m - car.wheelbase_m
    return Outcome(
        f"{car.length_m:g} m long, {car.wheelbase_m:g} m wheelbase; overhang {car.rear_overhang_m:g} m behind, {front:.2f} before",
        0.0 < front < car.wheelbase_m and car.rear_overhang_m < car.wheelbase_m,
        "measure [vehicle] length_m, wheelbase_m and rear_overhang_m again: wheelbase and overhang are parts of the length",
    )


def _outline(facts: Facts) -> Outcome:
    car = facts.vehicle
    return Outcome(
        f"{car.width_m:g} m wide, {car.height_m:g} m high; at most {WIDTH_MAX_M:g} and {HEIGHT_MAX_M:g} m",
        0.5 <= car.width_m <= WIDTH_MAX_M and 0.5 <= car.height_m <= HEIGHT_MAX_M,
        "measure [vehicle] width_m (mirrors included) and height_m again",
    )


def _bounded_by_its_bus(facts: Facts) -> bool:
    """Whether the car takes less steering from us than its wheels could turn."""
    return facts.gateway.can.vehicle == TOYOTA


def _turning(facts: Facts) -> Outcome:
    radius = facts.vehicle.wheelbase_m / tan(facts.vehicle.road_wheel_angle_max_rad)
    low, high = TURNING_RADIUS_M
    return Outcome(
        f"wheelbase {facts.vehicle.wheelbase_m:g} m and {facts.vehicle.road_wheel_angle_max_rad:g} rad: radius {radius:.1f} m, "
        f"of {low:g} to {high:g} m",
        low <= radius <= high,
        WIDE_TURNS
        if radius > high and _bounded_by_its_bus(facts)
        else "[vehicle] road_wheel_angle_max_rad is at the ROAD wheels: arctan of wheelbase over turning radius of the rear axle",
        Verdict.WARNING if radius > high and _bounded_by_its_bus(facts) else Verdict.ERROR,
    )


def _steering_range(facts: Facts) -> Outcome:
    lock = facts.vehicle.steering_ratio * facts.vehicle.road_wheel_angle_max_rad
    low, high = STEERING_LOCK_RAD
    return Outcome(
        f"ratio {facts.vehicle.steering_ratio:g} x {facts.vehicle.road_wheel_angle_max_rad:g} rad = {lock:.2f} rad "
        f"({degrees(lock):.0f} deg) each way, of {low:g} to {high:g} rad",
        low <= lock <= high,
        WIDE_TURNS
        if lock < low and _bounded_by_its_bus(facts)
        else "turn the steering wheel from lock to lock: half of it over steering_ratio is road_wheel_angle_max_rad",
        Verdict.WARNING if lock < low and _bounded_by_its_bus(facts) else Verdict.ERROR,
    )


def _steering_reach(facts: Facts) -> Outcome:
    lock = facts.vehicle.steering_ratio * facts.vehicle.road_wheel_angle_max_rad
    return Outcome(
        f"lock at {degrees(lock):.0f} deg, device {facts.device}; a 900 deg wheel turns {degrees(WHEEL_RANGE_RAD):.0f} each way",
        lock <= WHEEL_RANGE_RAD or facts.device in ("keyboard", "scripted"),
        "with a 900 deg wheel the last of the lock is out of reach: fine on roads, not for parking",
        Verdict.WARNING,
    )


def _friction(facts: Facts) -> Outcome:
    return Outcome(
        f"brakes {facts.vehicle.braking_max_m_s2:g} m/s2, a dry road holds {FRICTION_M_S2:g}",
        facts.vehicle.braking_max_m_s2 <= FRICTION_M_S2,
        "[vehicle] braking_max_m_s2: what a full braking on a dry road was measured to give",
    )


def _braking_order(facts: Facts) -> Outcome:
    stop, failsafe = facts.gateway.limits.safe_stop, facts.gateway.limits.failsafe
    steps = (-failsafe.gentle_braking_m_s2, stop.braking_m_s2, stop.braking_max_m_s2, facts.vehicle.braking_max_m_s2)
    return Outcome(
        "gentle {:g} <= safe stop {:g} <= its most {:g} <= car {:g} m/s2".format(*steps),
        list(steps) == sorted(steps),
        "order failsafe.gentle_braking_m_s2, safe_stop.braking_m_s2, safe_stop.braking_max_m_s2 and [vehicle] braking_max_m_s2",
    )


def _stop_within_corridor(facts: Facts) -> Outcome:
    stop, speed = facts.gateway.limits.safe_stop, facts.vehicle.speed_max_remote_m_s
    reaction_s = facts.gateway.limits.failsafe.command_lost_ms / 1e3
    distance = stopping_distance_m(speed, reaction_s, stop.braking_max_m_s2, stop.jerk_m_s3)
    return Outcome(
        f"from {3.6 * speed:.0f} km/h after {reaction_s:g} s of silence: {distance:.1f} m; a corridor is {STOPPING_CORRIDOR_M:g} m",
        distance <= STOPPING_CORRIDOR_M,
        "lower [vehicle] speed_max_remote_m_s, or raise safe_stop.braking_max_m_s2 where the car can",
    )


def _cap_at_the_start(facts: Facts) -> Outcome:
    first, most = facts.gateway.limits.cap.speed_first_m_s, facts.vehicle.speed_max_remote_m_s
    return Outcome(
        f"{3.6 * first:.0f} km/h in the first {facts.gateway.limits.cap.first_s:g} s, then {3.6 * most:.0f} km/h",
        first <= most,
        "cap.speed_first_m_s is above [vehicle] speed_max_remote_m_s: it has no effect",
        Verdict.WARNING,
    )


def _silence_order(facts: Facts) -> Outcome:
    limits = facts.gateway.limits.failsafe
    return Outcome(
        f"three cycles {3 * CYCLE_MS:g} < gentle {limits.command_gentle_ms:g} < safe stop {limits.command_lost_ms:g} ms",
        3 * CYCLE_MS < limits.command_gentle_ms < limits.command_lost_ms,
        "set failsafe.command_gentle_ms below failsafe.command_lost_ms",
    )


def _hand_over_command(facts: Facts) -> Outcome:
    fresh, gentle = facts.gateway.limits.hand_over.command_fresh_ms, facts.gateway.limits.failsafe.command_gentle_ms
    return Outcome(
        f"a command counts as fresh for {fresh:g} ms, the car brakes after {gentle:g} ms",
        fresh <= gentle,
        "lower hand_over.command_fresh_ms: a hand-over would commit on a command the failsafe calls late",
    )


def _ecu_order(facts: Facts) -> Outcome:
    ecu, limits = facts.gateway.simulation.ecu, facts.gateway.limits.failsafe
    plant = facts.gateway.simulation.demand_timeout_ms
    return Outcome(
        f"three cycles {3 * CYCLE_MS:g} < ECU {ecu.command_timeout_ms:g} <= safe stop {limits.command_lost_ms:g} ms; "
        f"actuators {plant:g} <= ECU",
        3 * CYCLE_MS < ecu.command_timeout_ms <= limits.command_lost_ms and plant <= ecu.command_timeout_ms,
        "[vehicle_gateway.simulation.ecu] command_timeout_ms: what the car's ECU waits for a dead gateway, below command_lost_ms",
    )


def _ecu_braking(facts: Facts) -> Outcome:
    ecu = facts.gateway.simulation.ecu
    return Outcome(
        f"ECU {ecu.braking_m_s2:g} and {ecu.emergency_m_s2:g} m/s2 by itself, car {facts.vehicle.braking_max_m_s2:g}",
        max(ecu.braking_m_s2, ecu.emergency_m_s2) <= facts.vehicle.braking_max_m_s2,
        "lower braking_m_s2 or emergency_m_s2 of the ECU, or measure [vehicle] braking_max_m_s2 again",
    )


CAR_CHECKS = (
    Check("length and wheelbase", _overhang),
    Check("width and height", _outline),
    Check("turning radius", _turning),
    Check("steering range", _steering_range),
    Check("steering within the wheel's reach", _steering_reach),
    Check("brakes and the road", _friction),
    Check("brakes in order", _braking_order),
    Check("safe stop within the corridor", _stop_within_corridor),
    Check("speed at the start", _cap_at_the_start),
    Check("silence in order", _silence_order),
    Check("hand-over on a fresh command", _hand_over_command),
    Check("ECU before safe stop", _ecu_order),
    Check("ECU brakes", _ecu_braking),
)
