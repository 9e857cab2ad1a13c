"""Everything of a recording that an incident dossier shows, between two moments. Reads; judges and draws nothing.

Times are seconds from the moment T, on the vehicle clock: stamps of the car as they are, what came from the tower by its arrival
in the car. What a gateway cycle says is read here as far as it is shown; the room that wrote it is not imported.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import msgspec

from recordings.audit.source import Read, line_of
from recordings.errors import RecordingError
from recordings.incident.moment import moment_ns
from recordings.read import Recording
from wire.messages.automation import RoadMap, Scene
from wire.messages.operating import DriveCommand, OperatorStatus, WindowStatus
from wire.messages.session import HandOverReply, HandOverRequest, LeaseReply, LeaseRequest
from wire.messages.vehicle import Actuation, GatewayCycle, GatewayStatus, VehicleDescription, VehicleState

LEAD_S = 3.0  # read so much before the window, so that what holds at its beginning is known


class CycleOutputs(msgspec.Struct, frozen=True):
    """What of vehicle_gateway.state.Outputs is shown; what else is in it does not matter."""

    requested: Actuation
    applied: Actuation
    rules: tuple[str, ...] = ()
    causes: tuple[str, ...] = ()
    lease_replies: tuple[LeaseReply, ...] = ()
    hand_over_replies: tuple[HandOverReply, ...] = ()


class CycleInputs(msgspec.Struct, frozen=True):
    stop_number: int = 0
    lease_requests: tuple[LeaseRequest, ...] = ()
    hand_over_requests: tuple[HandOverRequest, ...] = ()


@dataclass(frozen=True, slots=True)
class Cycle:
    t_s: float
    inputs: CycleInputs
    outputs: CycleOutputs


@dataclass(slots=True)
class Evidence:
    """Lists of (seconds from T, message), in time order."""

    at_utc_ns: int
    utc_minus_vehicle_ns: int
    before_s: float
    after_s: float
    start_utc_ns: int
    vehicle_id: str = ""
    versions: dict[str, str] = field(default_factory=dict)
    cycles: list[Cycle] = field(default_factory=list)
    states: list[tuple[float, VehicleState]] = field(default_factory=list)
    statuses: list[tuple[float, GatewayStatus]] = field(default_factory=list)
    commands: list[tuple[float, DriveCommand]] = field(default_factory=list)
    operators: list[tuple[float, OperatorStatus]] = field(default_factory=list)
    windows: list[tuple[float, WindowStatus]] = field(default_factory=list)
    scenes: list[tuple[float, Scene]] = field(default_factory=list)
    audit: list[tuple[float, Read]] = field(default_factory=list)
    road: RoadMap | None = None
    vehicle: VehicleDescription | None = None

    @property
    def at_vehicle_ns(self) -> int:
        return self.at_utc_ns - self.utc_minus_vehicle_ns

    def since_s(self, vehicle_ns: int) -> float:
        """Seconds from T of a stamp on the vehicle clock."""
        return (vehicle_ns - self.at_vehicle_ns) / 1e9

    def utc_ns(self, t_s: float) -> int:
        return self.at_utc_ns + round(t_s * 1e9)


def gather(recording: Recording, at: str, before_s: float, after_s: float) -> Evidence:
    """Raises RecordingError when `at` is not understood or not in the recording."""
    span = recording.span_ns
    if span is None:
        raise RecordingError(f"{recording.path}: holds no messages; name the recording of a drive")
    offset_ns = int(recording.metadata.get("clock", {}).get("utc_minus_vehicle_ns", 0))
    numbers = _audit_times(recording, offset_ns) if at.startswith("#") else {}
    at_ns = moment_ns(at, *span, numbers)
    found = Evidence(
        at_utc_ns=at_ns,
        utc_minus_vehicle_ns=offset_ns,
        before_s=min(before_s, (at_ns - span[0]) / 1e9),
        after_s=min(after_s, (span[1] - at_ns) / 1e9),
        start_utc_ns=span[0],
        vehicle_id=recording.metadata.get("drive", {}).get("vehicle_id", ""),
        versions=recording.versions,
    )
    from_ns = at_ns - round((before_s + LEAD_S) * 1e9)
    until_ns = at_ns + round(after_s * 1e9)
    for topic, log_ns, message in recording.rows(*_TAKE, from_ns=max(from_ns, 0), until_ns=until_ns):
        _TAKE[topic](found, found.since_s(log_ns - offset_ns), message)
    return found


def _audit_times(recording: Recording, offset_ns: int) -> dict[int, int]:
    lines = (line_of("", data) for _, data in recording.raw("audit"))
    return {line.entry.number: line.entry.stamp_ns + offset_ns for line in lines if line.entry}


_INPUTS, _OUTPUTS = msgspec.json.Decoder(CycleInputs), msgspec.json.Decoder(CycleOutputs)


def _take_cycle(found: Evidence, _: float, message: GatewayCycle) -> None:
    try:
        outputs = _OUTPUTS.decode(message.outputs)
        inputs = _INPUTS.decode(message.inputs)
    except msgspec.DecodeError:  # made by a version that said it otherwise: the other tracks still stand
        return
    found.cycles.append(Cycle(found.since_s(message.now_ns), inputs, outputs))


def _take_state(found: Evidence, _: float, message: VehicleState) -> None:
    found.states.append((found.since_s(message.stamp_ns), message))


def _take_status(found: Evidence, _: float, message: GatewayStatus) -> None:
    found.statuses.append((found.since_s(message.stamp_ns), message))


def _take_scene(found: Evidence, _: float, message: Scene) -> None:
    found.scenes.append((found.since_s(message.stamp_ns), message))


def _take_audit(found: Evidence, _: float, message: Any) -> None:
    line = line_of("", msgspec.json.encode(message))
    if line.record and line.entry:
        found.audit.append((found.since_s(line.entry.stamp_ns), Read("", line.record, line.entry)))


def _take_road(found: Evidence, _: float, message: RoadMap) -> None:
    found.road = message


def _take_vehicle(found: Evidence, _: float, message: VehicleDescription) -> None:
    found.vehicle = message


_TAKE: dict[str, Callable[[Evidence, float, Any], None]] = {
    "gateway_cycle": _take_cycle,
    "vehicle_state": _take_state,
    "gateway_status": _take_status,
    "drive_command": lambda found, t_s, message: found.commands.append((t_s, message)),
    "operator_status": lambda found, t_s, message: found.operators.append((t_s, message)),
    "window_status": lambda found, t_s, message: found.windows.append((t_s, message)),
    "scene": _take_scene,
    "audit": _take_audit,
    "road_map": _take_road,
    "vehicle_description": _take_vehicle,
}
