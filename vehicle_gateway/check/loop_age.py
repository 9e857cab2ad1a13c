"""Checks of the loop age: its limits in order, and room for what its owner wants judged. Pure."""

from vehicle_gateway.check.facts import Check, Facts, Outcome, Verdict

LINK_MS = 100.0  # ours: what picture and command need on a good link, a picture's period included


def _order(facts: Facts) -> Outcome:
    cap, limits = facts.gateway.limits.cap, facts.gateway.limits.failsafe
    return Outcome(
        f"full speed to {cap.loop_age_free_ms:g} < slow from {cap.loop_age_slow_ms:g} <= safe stop {limits.loop_age_max_ms:g} ms",
        cap.loop_age_free_ms < cap.loop_age_slow_ms <= limits.loop_age_max_ms,
        "order cap.loop_age_free_ms, cap.loop_age_slow_ms and failsafe.loop_age_max_ms",
    )


def _room_for_the_car(facts: Facts) -> Outcome:
    """What is configured is judged until it is measured: above the failsafe's limit nobody could drive the car to measure it."""
    limits = facts.gateway.limits
    car, free_ms, most_ms = limits.actuation, limits.cap.loop_age_free_ms, limits.failsafe.loop_age_max_ms
    if not car.in_loop_age:
        return Outcome("the car's own answer is told, not judged", True)
    cameras = [each.exposure_delay_ms + each.exposure_bound_ms for each in facts.vehicle.cameras if each.required]
    car_ms = max(car.steering_ms + car.steering_bound_ms, car.acceleration_ms + car.acceleration_bound_ms)
    age_ms = max(cameras, default=0.0) + facts.screen_ms + car_ms + LINK_MS
    compared = (
        f"camera {max(cameras, default=0.0):g} + screen {facts.screen_ms:g} + car {car_ms:g} + link {LINK_MS:g} = {age_ms:g} ms; "
        f"full speed to {free_ms:g}, safe stop above {most_ms:g} ms"
    )
    if age_ms > most_ms:
        return Outcome(
            compared,
            False,
            "nobody could drive it: actuation.steering_ms, acceleration_ms and their bounds as a drive has measured them "
            "(motion_to_motion_ms in its summary.json), or actuation.in_loop_age = false",
        )
    return Outcome(
        compared,
        age_ms <= free_ms,
        f"it would begin at {free_ms / age_ms:.0%} of its speed and stay there: configure what was measured in actuation, "
        "or in cap.loop_age_free_ms what its owner answers for",
        Verdict.WARNING,
    )


LOOP_AGE_CHECKS = (
    Check("loop age in order", _order),
    Check("room for the car in the loop age", _room_for_the_car),
)
