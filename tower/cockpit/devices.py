"""The seam between the cockpit and whatever the operator holds: a wheel, a keyboard, or the scripted operator.

A device says where its controls are; it never decides who drives and never sends. `step` is called once per tick and must
not block.
"""

from dataclasses import dataclass, field
from typing import Protocol

from haptics.alignment import Phase
from haptics.virtual_wheel import VirtualWheel
from wire.latest import Received
from wire.messages.automation import RoadMap, Scene
from wire.messages.base import Gear, Indicators, Lights, Wipers
from wire.messages.operating import OperatorInput, WindowStatus
from wire.messages.vehicle import GatewayStatus, VehicleDescription, VehicleState


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """What has arrived in the cockpit at this tick: the newest of each; None before the first."""

    vehicle_state: Received[VehicleState] | None = None
    gateway_status: Received[GatewayStatus] | None = None
    description: Received[VehicleDescription] | None = None
    scene: Received[Scene] | None = None
    road_map: Received[RoadMap] | None = None
    window_status: Received[WindowStatus] | None = None
    operator_input: Received[OperatorInput] | None = None
    wheel_phase: Phase = Phase.IDLE  # felt in the hands

    @property
    def speed_m_s(self) -> float:
        return self.vehicle_state.message.speed_m_s if self.vehicle_state is not None else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Presses:
    """How often each button was pressed since the device was opened: counters, not edges."""

    accept: int = 0
    hand_back: int = 0
    return_: int = 0
    stop: int = 0
    clear: int = 0
    engage: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Controls:
    """Where the controls are."""

    wheel: VirtualWheel  # angle and rate of the steering wheel, left positive
    throttle: float = 0.0  # of its travel, 0 released
    brake: float = 0.0
    throttle_reported: bool = False  # the device has said at least once where this pedal is
    brake_reported: bool = False
    wheel_reported: bool = True  # a real wheel has said at least once where it stands
    steer: float = 0.0  # what a key or stick asks for, left positive; 0 for a wheel, whose angle says it
    dead_man: bool = False
    gear: Gear = Gear.DRIVE
    indicators: Indicators = Indicators.OFF
    hazard: bool = False
    horn: bool = False
    lights: Lights = Lights.LOW
    wipers: Wipers = Wipers.OFF
    presses: Presses = field(default_factory=Presses)
    sample_ns: int = 0  # tower clock: newest sample, changed or not; 0: none yet
    event_ns: int = 0  # tower clock: newest sample that changed something


class Device(Protocol):
    @property
    def name(self) -> str: ...

    def step(self, view: View, torque: float, dt_s: float, now_ns: int) -> Controls:
        """Feel `torque` (normalised, left positive) for dt_s, and say where the controls are."""
        ...


_INPUT_NAMES = {
    "accept": "accept_presses",
    "hand_back": "hand_back_presses",
    "return_": "return_presses",
    "stop": "stop_presses",
    "clear": "clear_presses",
    "engage": "engage_presses",
}


def window_presses(message: OperatorInput) -> Presses:
    """The buttons of the window. They count with every device: STOP is never out of reach."""
    return Presses(**{ours: getattr(message, theirs) for ours, theirs in _INPUT_NAMES.items()})


def newly_pressed(previous: Presses | None, current: Presses) -> frozenset[str]:
    """The buttons whose counters rose. The first sample, and a counter that fell (a restarted window), set a new base."""
    if previous is None:
        return frozenset()
    return frozenset(name for name in _INPUT_NAMES if getattr(current, name) > getattr(previous, name))
