"""Messages with many fields as they are when nothing is the matter, for tests that are about one or two of them."""

from msgspec.structs import replace

from vehicle_gateway.can.codec import Feedback
from wire.messages.automation import AutonomyStatus, Doubt
from wire.messages.base import Gear, Indicators
from wire.messages.operating import DriveCommand, OperatorStatus
from wire.messages.vehicle import GatewayStatus, HandOver, Mode, VehicleDescription

STATUS = GatewayStatus(
    stamp_ns=0,
    boot_id="b",
    mode=Mode.AUTONOMOUS,
    mode_since_ns=0,
    cause="",
    lease_holder="",
    lease_epoch=0,
    hand_over=HandOver(number=0, action="", state="", rule=""),
    request=None,
    budget_remaining_s=0.0,
    guard_remaining_s=0.0,
    hand_back_ready=False,
    hand_back_note="",
    take_refused="",
    failsafe="",
    stop_number=0,
    stops_in_ten_minutes=0,
    dropped={},
)
FIT = AutonomyStatus(
    stamp_ns=0,
    sequence=0,
    healthy=True,
    health_note="",
    doubt=Doubt.NOMINAL,
    evidence=(),
    request=None,
    clear_s=60.0,
    drivable_s=60.0,
    state_matched=True,
    match_note="",
    goal_reached=False,
)
COCKPIT = OperatorStatus(
    stamp_ns=1,
    operator="Anna",
    device="keyboard",
    lease_epoch=3,
    lease_note="",
    dead_man=False,
    armed=True,
    wheel_phase="idle",
    steering_wheel_angle_rad=0.0,
    steering_wheel_torque=0.0,
    alignment_error_rad=0.0,
    throttle=0.0,
    brake=0.0,
    road_wheel_angle_rad=0.0,
    acceleration_m_s2=0.0,
    gear=Gear.DRIVE,
    indicators=Indicators.OFF,
    hazard=False,
    horn=False,
    hand_over_note="",
    stop_number=0,
    stop_state="",
    clock_offset_ns=0,
    clock_bound_ns=1,
    round_trip_ms=20.0,
)
COMMAND = DriveCommand(
    lease_epoch=1,
    sequence=1,
    sent_ns=0,
    event_ns=0,
    echoed_vehicle_ns=0,
    echoed_boot_id="",
    displayed_capture_ns={},
    road_wheel_angle_rad=0.0,
    acceleration_m_s2=0.0,
    gear=Gear.DRIVE,
    indicators=Indicators.OFF,
    hazard=False,
    horn=False,
    dead_man=True,
)
CALM = Feedback(
    speed_m_s=0.0,
    acceleration_m_s2=0.0,
    yaw_rate_rad_s=0.0,
    road_wheel_angle_rad=0.0,
    gear=Gear.DRIVE,
    ecu_following=True,
    brake_holding=False,
    seat_occupied=False,
    driver_torque_nm=0.0,
    driver_brake=0.0,
    emergency_button=False,
    release_button=False,
)
CAR = VehicleDescription(
    vehicle_id="test",
    length_m=4.5,
    width_m=1.76,
    height_m=1.5,
    wheelbase_m=2.7,
    rear_overhang_m=0.9,
    steering_ratio=14.0,
    road_wheel_angle_max_rad=0.6,
    acceleration_max_m_s2=2.0,
    braking_max_m_s2=8.0,
    speed_max_remote_m_s=8.33,
    mass_kg=1450.0,
    cameras=(),
)


def vehicle_description(**changes: object) -> VehicleDescription:
    """A car without cameras."""
    return replace(CAR, **changes)


def gateway_status(**changes: object) -> GatewayStatus:
    """The car drives itself, nobody holds the lease."""
    return replace(STATUS, **changes)


def autonomy_status(**changes: object) -> AutonomyStatus:
    """Fit to drive for a minute, in no doubt, on the road that it would take."""
    return replace(FIT, **changes)


def operator_status(**changes: object) -> OperatorStatus:
    """A cockpit with lease 3 and a keyboard that nobody touches, on the car's own clock."""
    return replace(COCKPIT, **changes)


def drive_command(**changes: object) -> DriveCommand:
    """The first of lease 1: straight on, no faster, dead-man held; it has seen nothing of the car and is not signed."""
    return replace(COMMAND, **changes)


def feedback(**changes: object) -> Feedback:
    """Of a car that stands in D with nobody in it and follows what it is told."""
    return replace(CALM, **changes)
