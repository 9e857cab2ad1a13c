"""What the tower says: commands, the operator's state, STOP, the window's state, and the window's input to the cockpit."""

from enum import StrEnum
from typing import Annotated

from msgspec import Meta

from wire.messages.base import (
    CAMERAS_MAX,
    Angle,
    CommandAcceleration,
    Count,
    DeviceDelay,
    DurationNs,
    Gear,
    Indicators,
    Lights,
    Message,
    Milliseconds,
    Name,
    Ratio,
    RoadWheelAngle,
    SignedRatio,
    SteeringWheelAngle,
    Text,
    TimeNs,
    Wipers,
)

Hmac = Annotated[str, Meta(max_length=64)]
Displayed = Annotated[dict[Name, TimeNs], Meta(max_length=CAMERAS_MAX)]  # by camera


class InputKind(StrEnum):
    """What of the window's devices the operator uses: how its levels are to be understood."""

    KEYBOARD = "keyboard"  # steer is a key: -1, 0 or 1
    GAMEPAD = "gamepad"  # steer is a stick
    WHEEL = "wheel"  # steering_wheel_angle_rad counts, steer does not


class DriveCommand(Message):
    """One command of the operator. A level: only the newest counts. Sent on every device event, 100 to 250 Hz."""

    lease_epoch: Count  # fencing token: the car drops every other epoch than the current one
    sequence: Count  # strictly increasing within the life of the cockpit
    sent_ns: TimeNs  # tower clock
    event_ns: TimeNs  # tower clock: the newest device event contained in this command
    echoed_vehicle_ns: TimeNs  # vehicle clock: stamp of the newest VehicleState received; 0 before the first
    echoed_boot_id: Name  # boot id that stamp belongs to; "" before the first
    displayed_capture_ns: Displayed  # vehicle clock: capture stamp of the picture on screen, per camera
    road_wheel_angle_rad: RoadWheelAngle
    acceleration_m_s2: CommandAcceleration
    gear: Gear
    indicators: Indicators
    hazard: bool
    horn: bool
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    dead_man: bool  # the operator holds the dead-man control, the sample is fresh, the window has focus
    override: bool = False  # pass what the collision guard stops for; counts below walking pace only
    scan_out_delay_ms: DeviceDelay = 0.0  # from the flip to light, as the window says; the car adds it to the loop age
    scan_out_bound_ms: DeviceDelay = 0.0  # the delay is within +- this
    hmac: Hmac = ""  # of all fields above under the lease's key: wire.signature


class TowerStop(Message):
    """The STOP button. An event with its own reliable key; needs no lease. The car answers in GatewayStatus.stop_number."""

    number: Annotated[int, Meta(ge=1, le=2**53)]  # counts presses; also how the tower recognises the confirmation
    sent_ns: TimeNs
    operator: Name


class Question(Message):
    """The operator's last question for a hand-over, and what became of it: the tower's side of `HandOver`."""

    number: Count = 0  # the tower's own count, as in HandOverRequest; 0: none yet
    action: Name = ""
    state: Name = ""  # "", requested, refused, granted, committed, expired (also without an answer), aborted
    rule: Text = ""  # why it was refused or came to nothing
    hand_over: Count = 0  # the car's number of the grant


class OperatorStatus(Message):
    """The cockpit's state, 20 Hz and on change: for the car's hand-over rules, for the window, for the recording."""

    stamp_ns: TimeNs
    operator: Name
    device: Name  # "scripted", "keyboard", "gamepad (its name)", a wheel's name
    device_note: Text = ""  # what happened to the controls: "Logitech G920 unplugged"; "" once they may be used again
    device_hint: Text = ""  # what to do with the devices: press and release a pedal, install the udev rule; "" when nothing
    lease_epoch: Count  # 0: none
    lease_note: Text  # why there is no lease, or ""
    dead_man: bool
    armed: bool  # every pedal has reported and was seen released
    wheel_phase: Name  # idle, align, ready, active, release
    steering_wheel_angle_rad: SteeringWheelAngle
    steering_wheel_torque: SignedRatio  # normalised, as sent to the wheel
    steer_asked: SignedRatio = 0.0  # what key or stick asks for, left positive, also before the wheel is the operator's; 0: a wheel
    alignment_error_rad: Angle  # at the steering wheel: operator's angle minus the car's
    throttle: Ratio
    brake: Ratio
    road_wheel_angle_rad: RoadWheelAngle  # what is commanded
    acceleration_m_s2: CommandAcceleration
    gear: Gear
    indicators: Indicators
    hazard: bool
    horn: bool
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    hand_over_note: Text  # last answer of the car to a hand-over query, in words; "" when none
    question: Question = Question()
    stop_number: Count  # last STOP sent; 0: none
    stop_state: Name  # "", sent, confirmed, unconfirmed
    clock_offset_ns: DurationNs  # vehicle clock = tower clock + offset (minimum-RTT sample of the last 10 s)
    clock_bound_ns: DurationNs  # the offset is within +- this; 0 before the first exchange
    round_trip_ms: Milliseconds  # of the newest exchange


class OperatorInput(Message):
    """Keyboard or gamepad as the window sees it, 60 Hz, coded by level: a lost message heals with the next one."""

    stamp_ns: TimeNs
    sequence: Count
    focus: bool  # without focus every control counts as released
    device: Name  # "keyboard", "gamepad (its name)", a wheel's name
    kind: InputKind = InputKind.KEYBOARD
    touched: bool  # a driving control was touched since the window started: selects this device
    touches: Count = 0  # how often one was touched after all had been let go
    unplugged: Name = ""  # the device that was in use and is gone; "" again once another is touched
    steer: SignedRatio  # left positive
    steering_wheel_angle_rad: SteeringWheelAngle = 0.0  # of a wheel
    pedals_reported: bool = True  # the device has said at least once where its pedals (and its wheel) are
    throttle: Ratio
    brake: Ratio
    dead_man: bool
    gear: Gear
    indicators: Indicators
    hazard: bool
    horn: bool
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    accept_presses: Count  # counters, not edges: accept a take-over / take control
    hand_back_presses: Count
    return_presses: Count  # within the guard time after a hand-back: return control to the operator
    stop_presses: Count
    clear_presses: Count  # ask for the STOPPED car to be released after the cause is gone
    engage_presses: Count  # ask the car to start driving itself


class ShownFrame(Message):
    camera: Name
    capture_ns: TimeNs  # vehicle clock, from inside the picture
    decoded_ns: TimeNs  # tower clock
    shown_ns: TimeNs  # tower clock: after the flip that brought it on screen


class WindowStatus(Message):
    """After every flip of the window (display rate): what is on screen. Feeds DriveCommand.displayed_capture_ns."""

    stamp_ns: TimeNs
    sequence: Count
    displayed_capture_ns: Displayed  # vehicle clock, newest picture on screen per camera
    frozen: bool  # FROZEN stands over a picture
    shown: Annotated[tuple[ShownFrame, ...], Meta(max_length=64)]  # brought on screen by this flip, usually none or one
    frames_dropped: Count  # decoded but replaced before they could be shown, since start
    scan_out_delay_ms: DeviceDelay = 0.0  # of this screen, after the flip: compositor, scan-out, panel; as configured
    scan_out_bound_ms: DeviceDelay = 0.0
    checks: dict[Name, Name] = {}  # of the pre-drive checklist: pending, passed, failed; empty when there is none


class ClockPing(Message):
    number: Count
    sent_ns: TimeNs  # tower clock


class ClockPong(Message):
    number: Count
    ping_sent_ns: TimeNs  # tower clock, echoed
    received_ns: TimeNs  # vehicle clock
    sent_ns: TimeNs  # vehicle clock
