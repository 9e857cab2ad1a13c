"""What the watchdog hears on the vehicle bus: valid frames only, each by its own counter. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from msgspec.structs import replace

from vehicle_gateway.can.codec import MODES
from vehicle_gateway.can.e2e import START, Trail
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import Layout
from vehicle_gateway.watchdog import Heard

NAMES = ("ACTUATION_COMMAND", "GATEWAY_SOURCES", "MOTION_FEEDBACK")


@dataclass(frozen=True, slots=True)
class Ear:
    heard: Heard = Heard()
    trails: Mapping[int, Trail] = field(default_factory=dict)  # by arbitration id


def ears_of(frames: Mapping[str, Layout]) -> dict[int, Layout]:
    """The frames that are listened to, by identifier."""
    return {frames[name].arbitration_id: frames[name] for name in NAMES}


def hear(ear: Ear, frame: Frame, received_ns: int, listened: Mapping[int, Layout]) -> tuple[Ear, str]:
    """The state after one frame, and why the frame was dropped ("" when it was not, or is none of ours)."""
    layout = listened.get(frame.arbitration_id)
    if layout is None:
        return ear, ""
    trail, values, reason = layout.receive(frame, ear.trails.get(frame.arbitration_id, START))
    heard = ear.heard if values is None else replace(ear.heard, **_taken(layout.name, values, received_ns))
    return Ear(heard, {**ear.trails, frame.arbitration_id: trail}), reason


def _taken(name: str, values: tuple[float, ...], received_ns: int) -> dict[str, object]:
    match name:
        case "ACTUATION_COMMAND":
            return {"command_ns": received_ns, "mode": MODES[int(values[0])], "acceleration_m_s2": values[2]}
        case "MOTION_FEEDBACK":
            return {"motion_ns": received_ns, "speed_m_s": values[0]}
    return {"sources": int(values[0])}
