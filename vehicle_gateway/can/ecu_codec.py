"""The vehicle bus as the ECU speaks it: commands in, feedback out. Pure; the mirror of vehicle_gateway.can.codec.

Never decides anything about driving.
"""

from collections.abc import Mapping
from typing import NamedTuple

from msgspec import Struct, field
from msgspec.structs import replace

from vehicle_gateway.can.codec import GEAR_NUMBER, GEARS, INDICATORS, LIGHTS, LIGHTS_NUMBER, MODES, WIPERS, WIPERS_NUMBER
from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.vehicle import Mode


class Command(NamedTuple):
    mode: Mode
    road_wheel_angle_rad: float
    acceleration_m_s2: float  # in the direction of the gear
    gear: Gear
    brake_hold: bool


class Body(NamedTuple):
    indicators: Indicators
    hazard: bool
    horn: bool
    lights: Lights
    wipers: Wipers


DARK = Body(Indicators.OFF, False, False, Lights.OFF, Wipers.OFF)


class Motion(NamedTuple):
    speed_m_s: float
    road_wheel_angle_rad: float
    acceleration_m_s2: float
    yaw_rate_rad_s: float


class Controls(NamedTuple):
    """What the person in the driver's seat does."""

    seat_occupied: bool = False
    emergency_button: bool = False
    release_button: bool = False
    driver_torque_nm: float = 0.0
    driver_brake: float = 0.0


class CommandState(Struct, frozen=True):
    """Newest valid command and body; a new object with every valid frame."""

    command: Command | None = None
    body: Body = DARK
    trails: Mapping[int, Trail] = field(default_factory=dict)  # by arbitration id


_LAYOUTS = layouts()
_COMMANDS = {layout.arbitration_id: layout for layout in (_LAYOUTS["ACTUATION_COMMAND"], _LAYOUTS["BODY_COMMAND"])}
_OWN = frozenset(
    _LAYOUTS[name].arbitration_id
    for name in ("MOTION_FEEDBACK", "DRIVE_STATE", "LOCAL_CONTROLS", "WHEEL_SPEEDS", "GATEWAY_SOURCES")  # the last: not for the ECU
)


def decode_command(state: CommandState, frame: Frame) -> tuple[CommandState, str]:
    """The state after one frame from the gateway, and why the frame was dropped ("" when it was not)."""
    layout = _COMMANDS.get(frame.arbitration_id)
    if layout is None:
        return state, "" if frame.arbitration_id in _OWN else "can id"
    trail, values, reason = layout.receive(frame, state.trails.get(frame.arbitration_id, START))
    state = replace(state, trails={**state.trails, frame.arbitration_id: trail})
    if values is None:
        return state, reason
    if layout.name == "BODY_COMMAND":
        indicators, hazard, horn, lights, wipers = values
        body = Body(INDICATORS[int(indicators)], bool(hazard), bool(horn), LIGHTS[int(lights)], WIPERS[int(wipers)])
        return replace(state, body=body), ""
    mode, angle, acceleration, gear, hold = values
    return replace(state, command=Command(MODES[int(mode)], angle, acceleration, GEARS[int(gear)], bool(hold))), ""


def encode_motion(motion: Motion, counter: int) -> Frame:
    return _LAYOUTS["MOTION_FEEDBACK"].pack(motion, counter)


def encode_drive_state(
    gear: Gear, ecu_state: int, brake_holding: bool, counter: int, lights: Lights = Lights.OFF, wipers: Wipers = Wipers.OFF
) -> Frame:
    """ecu_state  codec.FOLLOWING, TIMED_OUT or FAULT"""
    values = (GEAR_NUMBER[gear], ecu_state, brake_holding, LIGHTS_NUMBER[lights], WIPERS_NUMBER[wipers])
    return _LAYOUTS["DRIVE_STATE"].pack(values, counter)


def encode_controls(controls: Controls, counter: int) -> Frame:
    return _LAYOUTS["LOCAL_CONTROLS"].pack(controls, counter)


def encode_wheels(wheels_m_s: tuple[float, float, float, float], counter: int) -> Frame:
    """Front left, front right, rear left, rear right."""
    return _LAYOUTS["WHEEL_SPEEDS"].pack(wheels_m_s, counter)
