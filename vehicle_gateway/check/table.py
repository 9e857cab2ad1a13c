"""All checks over one configuration, in the order in which they are shown. Pure."""

from vehicle_gateway.can.settings import DRIVE_BY_WIRE, TOYOTA
from vehicle_gateway.check.cameras import CAMERA_CHECKS, CAMERAS_CHECKS
from vehicle_gateway.check.can import BUS_CHECKS, CAN_CHECKS
from vehicle_gateway.check.car import CAR_CHECKS
from vehicle_gateway.check.facts import Facts, Finding, Verdict, finding
from vehicle_gateway.check.loop_age import LOOP_AGE_CHECKS
from vehicle_gateway.check.site import SITE_CHECKS
from vehicle_gateway.check.toyota import TOYOTA_CHECKS

CHECKS = (*CAR_CHECKS, *LOOP_AGE_CHECKS, *CAMERAS_CHECKS, *BUS_CHECKS, *SITE_CHECKS)
CHECKS_OF_ITS_BUS = {DRIVE_BY_WIRE: CAN_CHECKS, TOYOTA: TOYOTA_CHECKS}


def check(facts: Facts) -> tuple[Finding, ...]:
    """Every check's finding; the cameras' once for each camera."""
    whole = [finding(name, look(facts)) for name, look in (*CHECKS, *CHECKS_OF_ITS_BUS[facts.gateway.can.vehicle])]
    each = [
        finding(f"camera {camera.name}: {name}", look(facts, camera))
        for camera in facts.vehicle.cameras
        for name, look in CAMERA_CHECKS
    ]
    return (*whole, *each)


def is_consistent(findings: tuple[Finding, ...]) -> bool:
    """No error; warnings are somebody's to look at."""
    return all(found.verdict is not Verdict.ERROR for found in findings)
