"""What the drive-by-wire ECU does with the gateway's commands, and what it does without them. Pure.

Follows the newest valid command. Without one for 100 ms it brakes by itself, jerk-limited, holds the steering, switches
the hazard lights on, and holds the car; it follows again only when commands are back AND the car stands. Silent sensors
are a fault with the same answer. It never steers on its own and never releases the brakes without a command.
The emergency button in the car brakes whatever is commanded. A stop of the watchdog counts as silence of the gateway.
"""

from typing import Annotated

from msgspec import Meta, Struct

from vehicle_gateway.can.actuator_codec import Demand
from vehicle_gateway.can.codec import FAULT, FOLLOWING, TIMED_OUT
from vehicle_gateway.can.ecu_codec import DARK, Body, Command, Controls, Motion
from wire.messages.base import Gear, Indicators, Message
from wire.messages.vehicle import Mode

STANDS_BELOW_M_S = 0.05
STEP_MAX_S = 0.02  # a late cycle counts as this much: the ramp never jumps
_DIRECTION = {Gear.DRIVE: 1.0, Gear.REVERSE: -1.0}  # other gears pass no traction on

Timeout = Annotated[float, Meta(ge=20.0, le=1000.0)]
Deceleration = Annotated[float, Meta(gt=0.5, le=10.0)]


class EcuSettings(Message):
    command_timeout_ms: Timeout = 100.0  # ten missed cycles of the gateway
    sensor_timeout_ms: Timeout = 100.0
    stop_lasts_ms: Timeout = 100.0  # a stop of the watchdog, five of its frames
    braking_m_s2: Deceleration = 4.0  # ceiling of UN R157 for a minimal risk manoeuvre
    jerk_m_s3: Annotated[float, Meta(gt=0.5, le=100.0)] = 10.0
    emergency_m_s2: Deceleration = 6.0
    hold_m_s2: Deceleration = 3.0  # brake force over the mass that holds the car: 17 deg of slope
    rolling_m_s2: Annotated[float, Meta(ge=0.0, le=1.0)] = 0.118  # what the ECU knows of the car's resistance: constant
    drag_1_m: Annotated[float, Meta(ge=0.0, le=0.01)] = 0.00029  # and with the square of the speed


class EcuInputs(Struct, frozen=True):
    """What the buses said last; the times are the ECU's own receive times."""

    command: Command | None = None
    command_ns: int = 0
    body: Body = DARK
    motion: Motion | None = None
    motion_ns: int = 0
    controls: Controls = Controls()
    stop_ns: int | None = None  # when the watchdog last asked for a stop; None: never


class EcuState(Struct, frozen=True):
    """How it starts: no command yet, brakes firmly on."""

    condition: int = TIMED_OUT  # FOLLOWING, TIMED_OUT or FAULT, as the DRIVE_STATE frame says it
    angle_rad: float = 0.0  # last demanded
    acceleration_m_s2: float = -EcuSettings().braking_m_s2  # last demanded, in the direction of the gear
    gear: Gear = Gear.DRIVE
    stepped_ns: int | None = None


def ecu_step(state: EcuState, inputs: EcuInputs, now_ns: int, settings: EcuSettings) -> tuple[EcuState, Demand]:
    """One cycle: at once on every new command, and at 100 Hz while none comes."""
    condition = _condition(state.condition, inputs, now_ns, settings)
    dt_s = 0.0 if state.stepped_ns is None else min(max(now_ns - state.stepped_ns, 0) / 1e9, STEP_MAX_S)
    following = condition == FOLLOWING and inputs.command is not None
    if following and inputs.command is not None:
        angle, gear = inputs.command.road_wheel_angle_rad, inputs.command.gear
        acceleration = inputs.command.acceleration_m_s2
    else:
        angle, gear = state.angle_rad, state.gear
        acceleration = max(min(state.acceleration_m_s2, 0.0) - settings.jerk_m_s3 * dt_s, -settings.braking_m_s2)
    state = EcuState(condition, angle, acceleration, gear, now_ns)
    return state, _demand(state, inputs, following, settings)


def _condition(previous: int, inputs: EcuInputs, now_ns: int, settings: EcuSettings) -> int:
    """What is wrong now counts at once; what was wrong counts until the car stands."""
    if inputs.motion is None or now_ns - inputs.motion_ns > settings.sensor_timeout_ms * 1e6:
        return FAULT
    if inputs.stop_ns is not None and now_ns - inputs.stop_ns <= settings.stop_lasts_ms * 1e6:
        return TIMED_OUT  # the watchdog's word against the gateway's: as if the gateway were silent
    if inputs.command is None or now_ns - inputs.command_ns > settings.command_timeout_ms * 1e6:
        return TIMED_OUT
    return FOLLOWING if previous == FOLLOWING or _stands(inputs) else previous


def _stands(inputs: EcuInputs) -> bool:
    return inputs.motion is not None and abs(inputs.motion.speed_m_s) < STANDS_BELOW_M_S


def _demand(state: EcuState, inputs: EcuInputs, following: bool, settings: EcuSettings) -> Demand:
    speed = inputs.motion.speed_m_s if inputs.motion is not None else 0.0
    drive, brake = split_force(state.acceleration_m_s2, speed, state.gear, settings)
    if not following:
        drive = 0.0  # not even to make up for drag
    hold = not following or (inputs.command is not None and inputs.command.brake_hold)
    if hold and _stands(inputs):
        drive, brake = 0.0, max(brake, settings.hold_m_s2)
    if inputs.controls.emergency_button:
        drive, brake = 0.0, max(brake, settings.emergency_m_s2)
    local = following and inputs.command is not None and inputs.command.mode is Mode.LOCAL_DRIVER
    body = inputs.body
    return Demand(
        state.angle_rad,
        0.0 if local else drive,
        brake,
        state.gear,
        body.indicators if following else Indicators.OFF,
        body.hazard or not following,
        body.horn and following,
        body.lights,
        local,
        body.wipers,
    )


def split_force(acceleration_m_s2: float, speed_m_s: float, gear: Gear, settings: EcuSettings) -> tuple[float, float]:
    """(drive, brake), each >= 0 in m/s2, that give the acceleration in the direction of the gear.

    Rolling resistance and drag are made up for while the car moves that way. A demand <= 0 never drives a standing car.
    """
    direction = _DIRECTION.get(gear, 0.0)
    along = speed_m_s * direction
    if along < STANDS_BELOW_M_S and acceleration_m_s2 <= 0.0:
        return 0.0, -acceleration_m_s2
    resistance = settings.rolling_m_s2 + settings.drag_1_m * along * abs(along) if along > -STANDS_BELOW_M_S else 0.0
    force = acceleration_m_s2 + resistance
    return (force if direction else 0.0, 0.0) if force >= 0.0 else (0.0, -force)
