"""What the operator's controls ask of the car: one DriveCommand. Pure; no signature, no sending.

A sample that is old or not finite counts as released: no dead-man, no throttle, no brake, no horn. The wheel keeps its last angle.
"""

from dataclasses import dataclass, replace
from math import isfinite

from msgspec import Struct

from tower.cockpit.devices import Controls
from tower.cockpit.pedals import PedalSettings, acceleration_m_s2
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.operating import DriveCommand
from wire.messages.vehicle import VehicleDescription

SAMPLE_AGE_MAX_NS = 100_000_000  # architecture, "Failsafe": an older sample counts as released
ROAD_WHEEL_ANGLE_LIMIT_RAD = 0.8  # of the message
ACCELERATION_LIMITS_M_S2 = (-10.0, 5.0)  # of the message


class Wanted(Struct, frozen=True, kw_only=True):
    """The commanded part of a DriveCommand."""

    road_wheel_angle_rad: float = 0.0
    acceleration_m_s2: float = 0.0
    gear: Gear = Gear.DRIVE
    indicators: Indicators = Indicators.OFF
    hazard: bool = False
    horn: bool = False
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    dead_man: bool = False
    override: bool = False  # of the collision guard


@dataclass(frozen=True, slots=True, kw_only=True)
class Stamps:
    """What a command says about when: see DriveCommand for the clocks."""

    sent_ns: int
    event_ns: int
    echoed_vehicle_ns: int
    echoed_boot_id: str
    displayed_capture_ns: dict[str, int]
    scan_out_delay_ms: float = 0.0
    scan_out_bound_ms: float = 0.0


def trusted(controls: Controls, previous: Controls, now_ns: int) -> Controls:
    """The controls as they may be used: released when the sample is older than 100 ms or not finite.

    previous  what was trusted a tick ago: its wheel stays where the new one is not a number
    """
    wheel_known = isfinite(controls.wheel.angle_rad) and isfinite(controls.wheel.rate_rad_s)
    known = wheel_known and isfinite(controls.throttle) and isfinite(controls.brake)
    if known and controls.sample_ns > 0 and now_ns - controls.sample_ns <= SAMPLE_AGE_MAX_NS:
        return controls
    return replace(
        controls,
        wheel=controls.wheel if wheel_known else previous.wheel,
        throttle=0.0,
        brake=0.0,
        throttle_reported=False,
        brake_reported=False,
        dead_man=False,
        horn=False,
    )


def wanted(
    controls: Controls, steering_wheel_angle_rad: float, armed: bool, description: VehicleDescription, pedals: PedalSettings
) -> Wanted:
    """What trusted controls ask for.

    steering_wheel_angle_rad  to be commanded: the wheel's angle less the rest of a misalignment
    armed                     every pedal was seen released; otherwise the throttle does nothing
    """
    limit = min(description.road_wheel_angle_max_rad, ROAD_WHEEL_ANGLE_LIMIT_RAD)
    angle = steering_wheel_angle_rad / description.steering_ratio
    throttle = controls.throttle if armed and controls.dead_man else 0.0
    acceleration = acceleration_m_s2(throttle, controls.brake, description.acceleration_max_m_s2, pedals)
    low, high = ACCELERATION_LIMITS_M_S2
    return Wanted(
        road_wheel_angle_rad=min(max(angle, -limit), limit),
        acceleration_m_s2=min(max(acceleration, low), high),
        gear=controls.gear,
        indicators=controls.indicators,
        hazard=controls.hazard,
        horn=controls.horn,
        lights=controls.lights,
        wipers=controls.wipers,
        dead_man=controls.dead_man,
    )


def built(want: Wanted, lease_epoch: int, sequence: int, stamps: Stamps) -> DriveCommand:
    """The unsigned command."""
    return DriveCommand(
        lease_epoch=lease_epoch,
        sequence=sequence,
        sent_ns=stamps.sent_ns,
        event_ns=stamps.event_ns,
        echoed_vehicle_ns=stamps.echoed_vehicle_ns,
        echoed_boot_id=stamps.echoed_boot_id,
        displayed_capture_ns=stamps.displayed_capture_ns,
        scan_out_delay_ms=stamps.scan_out_delay_ms,
        scan_out_bound_ms=stamps.scan_out_bound_ms,
        road_wheel_angle_rad=want.road_wheel_angle_rad,
        acceleration_m_s2=want.acceleration_m_s2,
        gear=want.gear,
        indicators=want.indicators,
        hazard=want.hazard,
        horn=want.horn,
        lights=want.lights,
        wipers=want.wipers,
        dead_man=want.dead_man,
        override=want.override,
    )


# Below this a wheel did not move: 0.03 deg at the steering wheel, two counts of a G920.
_STEERING_STEP_RAD = 0.0005
_ACCELERATION_STEP_M_S2 = 0.01


def moved(want: Wanted, sent: Wanted, steering_ratio: float) -> bool:
    """Whether wheel or pedals changed since the command sent last."""
    turned = abs(want.road_wheel_angle_rad - sent.road_wheel_angle_rad) * steering_ratio > _STEERING_STEP_RAD
    return turned or abs(want.acceleration_m_s2 - sent.acceleration_m_s2) > _ACCELERATION_STEP_M_S2


def is_urgent(want: Wanted, sent: Wanted | None, was_moving: bool, steering_ratio: float) -> bool:
    """Whether a command should go out at once: on every switch, and where wheel or pedals BEGIN to move. While they go on
    (was_moving: in the command sent last), the next regular command is soon enough, and the car is spared every other cycle."""
    if sent is None:
        return True
    return _switches(want) != _switches(sent) or (not was_moving and moved(want, sent, steering_ratio))


def _switches(want: Wanted) -> tuple[object, ...]:
    return want.gear, want.indicators, want.hazard, want.horn, want.lights, want.wipers, want.dead_man, want.override
