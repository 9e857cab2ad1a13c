"""The actuator bus: the ECU's demand to steering, drive and brakes, and what their sensors say. Pure, both directions.

Never decides anything about driving.
"""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from msgspec import Struct, field
from msgspec.structs import replace

from vehicle_gateway.can.codec import (
    GEAR_NUMBER,
    GEARS,
    INDICATORS,
    INDICATORS_NUMBER,
    LIGHTS,
    LIGHTS_NUMBER,
    WIPERS,
    WIPERS_NUMBER,
)
from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.ecu_codec import Controls, Motion
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import layouts
from wire.messages.base import Gear, Indicators, Lights, Wipers


class Demand(NamedTuple):
    """What the actuators are to do. Forces are over the mass of the car: m/s2."""

    road_wheel_angle_rad: float
    drive_m_s2: float  # >= 0, in the direction of the gear
    brake_m_s2: float  # >= 0, against the motion
    gear: Gear = Gear.DRIVE
    indicators: Indicators = Indicators.OFF
    hazard: bool = False
    horn: bool = False
    lights: Lights = Lights.OFF
    steering_free: bool = False  # a person steers, the actuator gives way
    wipers: Wipers = Wipers.OFF


class PlantReport(NamedTuple):
    gear: Gear
    brake_holding: bool
    controls: Controls


class DemandState(Struct, frozen=True):
    demand: Demand | None = None
    trail: Trail = START


class PlantState(Struct, frozen=True):
    motion: Motion | None = None
    report: PlantReport | None = None
    wheels_m_s: tuple[float, float, float, float] | None = None  # front left, front right, rear left, rear right
    trails: Mapping[int, Trail] = field(default_factory=dict)  # by arbitration id


_LAYOUTS = layouts()
_DEMAND = _LAYOUTS["ACTUATOR_DEMAND"]
_PLANT = {
    layout.arbitration_id: layout for layout in (_LAYOUTS[name] for name in ("PLANT_MOTION", "PLANT_CONTROLS", "PLANT_WHEELS"))
}


def encode_demand(demand: Demand, counter: int) -> Frame:
    return _DEMAND.pack(
        (
            demand.road_wheel_angle_rad,
            demand.drive_m_s2,
            demand.brake_m_s2,
            GEAR_NUMBER[demand.gear],
            INDICATORS_NUMBER[demand.indicators],
            demand.hazard,
            demand.horn,
            LIGHTS_NUMBER[demand.lights],
            demand.steering_free,
            WIPERS_NUMBER[demand.wipers],
        ),
        counter,
    )


def decode_demand(state: DemandState, frame: Frame) -> tuple[DemandState, str]:
    """The state after one frame from the ECU, and why the frame was dropped ("" when it was not)."""
    if frame.arbitration_id != _DEMAND.arbitration_id:
        return state, "" if frame.arbitration_id in _PLANT else "can id"
    trail, values, reason = _DEMAND.receive(frame, state.trail)
    state = replace(state, trail=trail)
    if values is None:
        return state, reason
    angle, drive, brake, gear, indicators, hazard, horn, lights, free, wipers = values
    demand = Demand(
        angle,
        drive,
        brake,
        GEARS[int(gear)],
        INDICATORS[int(indicators)],
        bool(hazard),
        bool(horn),
        LIGHTS[int(lights)],
        bool(free),
        WIPERS[int(wipers)],
    )
    return replace(state, demand=demand), ""


def encode_plant_motion(motion: Motion, counter: int) -> Frame:
    return _LAYOUTS["PLANT_MOTION"].pack(motion, counter)


def encode_plant_report(report: PlantReport, counter: int) -> Frame:
    return _LAYOUTS["PLANT_CONTROLS"].pack((GEAR_NUMBER[report.gear], report.brake_holding, *report.controls), counter)


def encode_plant_wheels(wheels_m_s: tuple[float, float, float, float], counter: int) -> Frame:
    return _LAYOUTS["PLANT_WHEELS"].pack(wheels_m_s, counter)


def decode_plant(state: PlantState, frame: Frame) -> tuple[PlantState, str]:
    """The state after one frame from the plant, and why the frame was dropped ("" when it was not)."""
    layout = _PLANT.get(frame.arbitration_id)
    if layout is None:
        return state, "" if frame.arbitration_id == _DEMAND.arbitration_id else "can id"
    trail, values, reason = layout.receive(frame, state.trails.get(frame.arbitration_id, START))
    state = replace(state, trails={**state.trails, frame.arbitration_id: trail})
    return (state, reason) if values is None else (_PUT[layout.name](state, values), "")


def _put_report(state: PlantState, values: tuple[float, ...]) -> PlantState:
    gear, holding, seat, emergency, release, torque, brake = values
    controls = Controls(bool(seat), bool(emergency), bool(release), torque, brake)
    return replace(state, report=PlantReport(GEARS[int(gear)], bool(holding), controls))


def _put_wheels(state: PlantState, values: tuple[float, ...]) -> PlantState:
    front_left, front_right, rear_left, rear_right = values
    return replace(state, wheels_m_s=(front_left, front_right, rear_left, rear_right))


_PUT: dict[str, Callable[[PlantState, tuple[float, ...]], PlantState]] = {
    "PLANT_MOTION": lambda state, values: replace(state, motion=Motion(*values)),
    "PLANT_CONTROLS": _put_report,
    "PLANT_WHEELS": _put_wheels,
}
