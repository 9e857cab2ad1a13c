"""What the car's gateway says: who drives and why, the car's state, what it is, every cycle it made."""

from enum import StrEnum
from typing import Annotated

import msgspec
from msgspec import Meta

from wire.messages.automation import TakeoverRequest
from wire.messages.base import (
    Acceleration,
    Angle,
    CommandAcceleration,
    Count,
    DeviceDelay,
    Gear,
    Indicators,
    Length,
    Lights,
    Message,
    Milliseconds,
    Name,
    Rate,
    RoadWheelAngle,
    Seconds,
    Speed,
    Text,
    TimeNs,
    Wipers,
)


class Mode(StrEnum):
    STANDBY = "standby"
    AUTONOMOUS = "autonomous"
    TAKEOVER_REQUESTED = "takeover_requested"
    HANDING_OVER = "handing_over"
    REMOTE = "remote"
    HANDING_BACK = "handing_back"
    LOCAL_DRIVER = "local_driver"
    SAFE_STOP = "safe_stop"
    STOPPED = "stopped"
    EMERGENCY_STOP = "emergency_stop"


class Actuation(Message):
    """What was asked of the car, or what was really sent to CAN."""

    road_wheel_angle_rad: RoadWheelAngle
    acceleration_m_s2: CommandAcceleration
    gear: Gear = Gear.DRIVE
    indicators: Indicators = Indicators.OFF
    hazard: bool = False
    horn: bool = False
    lights: Lights = Lights.LOW  # a car on the road is seen, whoever drives
    wipers: Wipers = Wipers.OFF


class MotionToMotion(Message):
    """From what moved before the camera to the car's own answer, as of the newest command; the required camera that is worst."""

    total_ms: Milliseconds  # sum of picture, camera, scan_out and the slower one of steering and acceleration
    bound_ms: Milliseconds  # the total is within +- this
    picture_ms: Milliseconds  # from the capture stamp to the arrival of the command, measured on the car's clock
    camera_ms: Milliseconds  # before the stamp, as configured
    scan_out_ms: Milliseconds  # after the flip, as the tower says
    steering_ms: Milliseconds  # from a command sent to CAN to the road wheels' feedback
    acceleration_ms: Milliseconds
    steering_measured: bool  # false: the configured default
    acceleration_measured: bool


class VehicleState(Message):
    """50 Hz. Measured by the car's own sensors (CAN feedback), and what the gate made of the last command."""

    stamp_ns: TimeNs  # vehicle clock; the tower echoes it
    boot_id: Name
    sequence: Count
    speed_m_s: Speed
    acceleration_m_s2: Acceleration
    yaw_rate_rad_s: Rate
    road_wheel_angle_rad: RoadWheelAngle
    gear: Gear
    lights: Lights = Lights.OFF  # really on, as the car's own feedback says
    wipers: Wipers = Wipers.OFF
    requested: Actuation
    applied: Actuation
    rules: tuple[Name, ...]  # of the gate, those that changed the request; () when nothing was changed
    speed_cap_m_s: Speed
    # as it is judged. Worst required camera: arrival of the command minus the capture stamp of the picture it was given on, what
    # the picture took before the stamp and after the flip, at most, and the car's own answer where its owner wants it
    loop_age_ms: Milliseconds
    command_age_ms: Milliseconds  # since the last valid command was received
    feedback_age_ms: Milliseconds = 0.0  # since the car last told on CAN how it moves; 1e9: never
    guard: Name = ""  # the collision guard: off, blind, clear, holding, braking, overridden; "": no word of it
    loop_age_actuation_ms: Milliseconds = 0.0  # the car's own answer in the loop age, at most; 0: it is not judged
    motion_to_motion: MotionToMotion | None = None  # None: no command that names a picture yet


class HandOver(Message):
    """The hand-over in progress or the last one. What was refused never began: only the reply and the audit trail tell it."""

    number: Count  # the car's own count of grants; 0: none yet
    action: Name
    state: Name  # "", granted, committed, expired, aborted
    rule: Text
    question: Count = 0  # the tower's number of the question that was granted


class StopWay(Message):
    """The way that a stop would take that begins with everybody silent now; metres of the rear axle, from the car on."""

    along: Name = ""  # corridor: tracked closed loop; held: the wheels as they are; "": the same, nothing is known of it
    free_m: Length = 0.0  # how much of it is known to be free
    stop_m: Length = 0.0  # where the car would stand, the silence until it brakes included


class Succession(Message):
    """The next operator, named by a supervisor while another one drives; the car changes hands when both are ready."""

    operator: Name = ""  # "": nobody is named
    lease_epoch: Count = 0  # of his own lease, with which he drives nothing yet; 0: his cockpit has not asked
    agreed: bool = False  # the driver has passed the car on
    refused: Text = ""  # the rule that would refuse him to take over now; "" when none would
    remaining_s: Seconds = 0.0  # then the driver drives on


class GatewayStatus(Message):
    """20 Hz and on change. Only the authority owns the mode; everybody else displays it."""

    stamp_ns: TimeNs
    boot_id: Name
    mode: Mode
    mode_since_ns: TimeNs
    cause: Text  # why the mode was entered, in words for the operator
    lease_holder: Name  # operator, "" when none
    lease_epoch: Count
    lease_certificate: Name = ""  # of the holder: common name
    lease_fingerprint: Name = ""  # SHA-256 of that certificate, in hexadecimal
    lease_silent_s: Seconds = 0.0  # since the holder was last heard; from 5 s on the next one may have it
    certificate_left_s: Seconds | None = None  # until it expires, or the car's own; None: nobody's, or not known
    lease_note: Text = ""  # why the last lease was taken from its holder, or what a supervisor did since; "" with a new lease
    hand_over: HandOver
    request: TakeoverRequest | None  # the open take-over request, with its reasons
    budget_remaining_s: Seconds  # of the open request; 0 when none or over
    guard_remaining_s: Seconds  # after a hand-back: time in which one press returns control
    hand_back_ready: bool
    hand_back_note: Text  # what is missing for a hand-back
    take_refused: Text  # the rule that would refuse a take-over now, "" when none would
    failsafe: Name  # worst active cause of the failsafe, "" when none
    stop_number: Count  # last TowerStop received: the confirmation of STOP
    stops_in_ten_minutes: Count
    dropped: dict[Name, Count]  # messages dropped since start, by reason
    stop_way: StopWay = StopWay()
    succession: Succession = Succession()
    watchdog_silent_s: Seconds | None = None  # since its last frame, or since our start; None: this car obeys none


class CameraCalibration(Message):
    """Pinhole camera, no distortion. Mounted in the car's frame (origin: rear axle on the ground)."""

    name: Name
    required: bool  # the operator may only drive with a fresh picture of this camera
    width_px: Annotated[int, Meta(ge=64, le=7680)]
    height_px: Annotated[int, Meta(ge=64, le=4320)]
    frame_rate_hz: Annotated[float, Meta(ge=1.0, le=120.0)]
    focal_length_px: Annotated[float, Meta(ge=10.0, le=20000.0)]
    x_m: Annotated[float, Meta(ge=-10.0, le=10.0)]
    y_m: Annotated[float, Meta(ge=-5.0, le=5.0)]
    z_m: Annotated[float, Meta(ge=0.0, le=5.0)]
    yaw_rad: Angle  # positive looks left
    pitch_rad: Angle  # positive looks down
    exposure_delay_ms: DeviceDelay = 0.0  # from light to the capture stamp: exposure, readout, driver; 0 for a simulated one
    exposure_bound_ms: DeviceDelay = 0.0  # the delay is within +- this


class VehicleDescription(Message):
    """Geometry, limits and cameras of one car: asked for, and repeated at 1 Hz. Configuration section [vehicle]."""

    vehicle_id: Name
    length_m: Length
    width_m: Length
    height_m: Length
    wheelbase_m: Annotated[float, Meta(ge=0.5, le=12.0)]
    rear_overhang_m: Length  # rear axle to rear bumper
    steering_ratio: Annotated[float, Meta(ge=1.0, le=40.0)]  # steering wheel angle / road wheel angle
    road_wheel_angle_max_rad: Annotated[float, Meta(ge=0.1, le=0.8)]
    acceleration_max_m_s2: Annotated[float, Meta(ge=0.1, le=5.0)]
    braking_max_m_s2: Annotated[float, Meta(ge=1.0, le=10.0)]
    speed_max_remote_m_s: Annotated[float, Meta(ge=0.5, le=40.0)]
    mass_kg: Annotated[float, Meta(ge=100.0, le=60000.0)]
    cameras: tuple[CameraCalibration, ...]


class GatewayCycle(Message):
    """Every cycle of the gateway: its time, every input it used, every output. Local, recorded; replay feeds it again."""

    number: Count
    now_ns: TimeNs  # the one clock reading of the cycle
    inputs: msgspec.Raw  # vehicle_gateway.cycle.Inputs as JSON
    outputs: msgspec.Raw  # vehicle_gateway.cycle.Outputs as JSON
    can_sent_ns: TimeNs  # vehicle clock, after the frame was handed to the bus
    command_sequence: Count  # of the newest valid DriveCommand; 0: none
    new_command: bool  # this cycle was the first to use it
    loop_age_ms: Milliseconds  # of that command, as it is judged; 0 when none
    mode: Mode
    rules: tuple[Name, ...]
    # vehicle_gateway.replay.Start, what the cycle started from: in the first cycle that is recorded, and now and then
    start: msgspec.Raw = msgspec.field(default_factory=lambda: msgspec.Raw(b"null"))
