"""One pass through a recording: the few values per message that the summary needs, in the order of their arrival.

Holds no payloads: a gateway cycle shrinks from kilobytes to one row. Never computes a figure.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from wire.messages.health import LoopHealth
from wire.messages.operating import DriveCommand, OperatorStatus, WindowStatus
from wire.messages.sensing import CameraStatus, Referee
from wire.messages.vehicle import GatewayCycle, GatewayStatus, Mode, MotionToMotion, VehicleState


class RowSource(Protocol):
    """What is needed of `recordings.read.Recording`."""

    def rows(self, *topics: str) -> Iterable[tuple[str, int, Any]]: ...


class StatusRow(NamedTuple):
    log_ns: int
    status: GatewayStatus


class CycleRow(NamedTuple):
    log_ns: int
    can_sent_ns: int  # vehicle clock
    command_sequence: int
    new_command: bool
    loop_age_ms: float
    mode: Mode
    rules: tuple[str, ...]


class CommandRow(NamedTuple):
    log_ns: int
    sequence: int
    event_ns: int  # tower clock


class OffsetRow(NamedTuple):
    """vehicle clock = tower clock + offset_ns, within +- bound_ns. Only rows after the tower's first exchange."""

    log_ns: int
    offset_ns: int
    bound_ns: int


class ShownRow(NamedTuple):
    log_ns: int
    camera: str
    capture_ns: int  # vehicle clock
    shown_ns: int  # tower clock


class SpeedRow(NamedTuple):
    stamp_ns: int  # vehicle clock
    speed_m_s: float


class MotionRow(NamedTuple):
    log_ns: int
    said: MotionToMotion


class CameraRow(NamedTuple):
    log_ns: int
    status: CameraStatus


@dataclass(slots=True)
class Drive:
    statuses: list[StatusRow] = field(default_factory=list)
    cycles: list[CycleRow] = field(default_factory=list)
    commands: list[CommandRow] = field(default_factory=list)
    offsets: list[OffsetRow] = field(default_factory=list)
    shown: list[ShownRow] = field(default_factory=list)
    speeds: list[SpeedRow] = field(default_factory=list)
    referee: list[Referee] = field(default_factory=list)
    health: list[LoopHealth] = field(default_factory=list)
    cameras: list[CameraRow] = field(default_factory=list)
    motions: list[MotionRow] = field(default_factory=list)


def collect(source: RowSource) -> Drive:
    """Everything the summary is made of. Raises what `source` raises."""
    drive = Drive()
    for topic, log_ns, message in source.rows(*_TAKE):
        _TAKE[topic](drive, log_ns, message)
    return drive


def _take_status(drive: Drive, log_ns: int, message: GatewayStatus) -> None:
    drive.statuses.append(StatusRow(log_ns, message))


def _take_cycle(drive: Drive, log_ns: int, message: GatewayCycle) -> None:
    drive.cycles.append(
        CycleRow(
            log_ns,
            message.can_sent_ns,
            message.command_sequence,
            message.new_command,
            message.loop_age_ms,
            message.mode,
            message.rules,
        )
    )


def _take_command(drive: Drive, log_ns: int, message: DriveCommand) -> None:
    drive.commands.append(CommandRow(log_ns, message.sequence, message.event_ns))


def _take_operator(drive: Drive, log_ns: int, message: OperatorStatus) -> None:
    if message.clock_bound_ns > 0:  # 0: no exchange yet, the offset means nothing
        drive.offsets.append(OffsetRow(log_ns, message.clock_offset_ns, message.clock_bound_ns))


def _take_window(drive: Drive, log_ns: int, message: WindowStatus) -> None:
    drive.shown.extend(ShownRow(log_ns, frame.camera, frame.capture_ns, frame.shown_ns) for frame in message.shown)


def _take_state(drive: Drive, log_ns: int, message: VehicleState) -> None:
    drive.speeds.append(SpeedRow(message.stamp_ns, message.speed_m_s))
    if message.motion_to_motion is not None:
        drive.motions.append(MotionRow(log_ns, message.motion_to_motion))


def _take_referee(drive: Drive, _: int, message: Referee) -> None:
    drive.referee.append(message)


def _take_health(drive: Drive, _: int, message: LoopHealth) -> None:
    drive.health.append(message)


def _take_camera(drive: Drive, log_ns: int, message: CameraStatus) -> None:
    drive.cameras.append(CameraRow(log_ns, message))


_TAKE: dict[str, Callable[[Drive, int, Any], None]] = {
    "gateway_status": _take_status,
    "gateway_cycle": _take_cycle,
    "drive_command": _take_command,
    "operator_status": _take_operator,
    "window_status": _take_window,
    "vehicle_state": _take_state,
    "referee": _take_referee,
    "car_health": _take_health,
    "tower_health": _take_health,
    "camera_status": _take_camera,
}
