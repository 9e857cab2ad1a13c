"""Messages and small recordings for the tests of this room, made by the real writer."""

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from recordings.provenance import Attached, Provenance
from recordings.writer import DriveWriter
from tests.messages import drive_command, gateway_status, operator_status
from wire.messages.automation import Reason, TakeoverRequest
from wire.messages.base import Gear, Message, encode
from wire.messages.health import LoopHealth
from wire.messages.operating import DriveCommand, OperatorStatus, ShownFrame, WindowStatus
from wire.messages.sensing import Imu, Referee
from wire.messages.vehicle import Actuation, GatewayCycle, GatewayStatus, Mode, MotionToMotion, VehicleState

Row = tuple[str, Message | bytes, int]  # topic, message, received_ns


class Build:
    """Messages with everything that a test does not name filled in."""

    utc_ns = 1_700_000_000_000_000_000  # utc_minus_vehicle_ns of the recordings made here

    def imu(self, stamp_ns: int) -> Imu:
        return Imu(
            stamp_ns=stamp_ns,
            acceleration_x_m_s2=0.1,
            acceleration_y_m_s2=0.0,
            acceleration_z_m_s2=9.81,
            roll_rate_rad_s=0.0,
            pitch_rate_rad_s=0.0,
            yaw_rate_rad_s=0.01,
        )

    def request(self, number: int, raised_ns: int, text: str = "lane closed") -> TakeoverRequest:
        return TakeoverRequest(
            number=number, raised_ns=raised_ns, budget_s=8.0, place=(150.0, 2.0), reasons=(Reason(channel="planner", text=text),)
        )

    def status(
        self,
        stamp_ns: int,
        mode: Mode,
        since_ns: int,
        request: TakeoverRequest | None = None,
        dropped: dict[str, int] | None = None,
        boot_id: str = "boot",
    ) -> GatewayStatus:
        return gateway_status(
            stamp_ns=stamp_ns, boot_id=boot_id, mode=mode, mode_since_ns=since_ns, request=request, dropped=dropped or {}
        )

    def cycle(
        self,
        now_ns: int,
        sequence: int,
        *,
        new: bool = True,
        age_ms: float = 0.0,
        mode: Mode = Mode.REMOTE,
        rules: tuple[str, ...] = (),
        sent_ns: int = 0,
    ) -> GatewayCycle:
        return GatewayCycle(
            number=1,
            now_ns=now_ns,
            inputs=msgspec.Raw(b"{}"),
            outputs=msgspec.Raw(b"{}"),
            can_sent_ns=sent_ns or now_ns,
            command_sequence=sequence,
            new_command=new,
            loop_age_ms=age_ms,
            mode=mode,
            rules=rules,
        )

    def command(self, sequence: int, event_ns: int, sent_ns: int = 0) -> DriveCommand:
        return drive_command(sequence=sequence, sent_ns=sent_ns or event_ns, event_ns=event_ns)

    def operator(self, stamp_ns: int, offset_ns: int, bound_ns: int) -> OperatorStatus:
        return operator_status(
            stamp_ns=stamp_ns,
            operator="anna",
            lease_epoch=1,
            dead_man=True,
            wheel_phase="active",
            clock_offset_ns=offset_ns,
            clock_bound_ns=bound_ns,
            round_trip_ms=1.0,
        )

    def window(self, stamp_ns: int, *shown: tuple[str, int, int]) -> WindowStatus:
        """`shown`: (camera, capture_ns, shown_ns)"""
        return WindowStatus(
            stamp_ns=stamp_ns,
            sequence=1,
            displayed_capture_ns={},
            frozen=False,
            frames_dropped=0,
            shown=tuple(ShownFrame(camera=name, capture_ns=capture, decoded_ns=at, shown_ns=at) for name, capture, at in shown),
        )

    def state(self, stamp_ns: int, speed_m_s: float, motion: MotionToMotion | None = None) -> VehicleState:
        still = Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0)
        return VehicleState(
            stamp_ns=stamp_ns,
            boot_id="boot",
            sequence=1,
            speed_m_s=speed_m_s,
            acceleration_m_s2=0.0,
            yaw_rate_rad_s=0.0,
            road_wheel_angle_rad=0.0,
            gear=Gear.DRIVE,
            requested=still,
            applied=still,
            rules=(),
            speed_cap_m_s=8.3,
            loop_age_ms=0.0,
            command_age_ms=0.0,
            motion_to_motion=motion,
        )

    def referee(self, stamp_ns: int, collisions: int = 0, goal_reached: bool = False) -> Referee:
        return Referee(
            stamp_ns=stamp_ns,
            elapsed_s=0.0,
            station_m=0.0,
            offset_m=0.0,
            x_m=0.0,
            y_m=0.0,
            speed_m_s=0.0,
            distance_m=0.0,
            collisions=collisions,
            collided_with="",
            goal_reached=goal_reached,
            closest_m=1.0,
        )

    def health(
        self, process: str, loop: str, cycles: int, late: int = 0, worst_ms: float = 0.0, dropped: dict[str, int] | None = None
    ) -> LoopHealth:
        return LoopHealth(
            stamp_ns=0,
            process=process,
            loop=loop,
            period_ms=10.0,
            cycles=cycles,
            late_cycles=late,
            lateness_p50_ms=0.0,
            lateness_max_ms=worst_ms,
            scheduling="other",
            dropped=dropped or {},
        )

    def provenance(self, vehicle_id: str = "car-1") -> Provenance:
        configuration = Attached(name="configuration.toml", media_type="application/toml", data=b"[wire]\n")
        return Provenance(
            vehicle_id=vehicle_id,
            utc_minus_vehicle_ns=self.utc_ns,
            versions={"python": "3.11"},
            notes={},
            attached=(configuration,),
        )

    def recording(self, path: Path, rows: Iterable[Row], vehicle_id: str = "car-1", flush_every: int = 0) -> Path:
        """A whole file; flush_every: a chunk ends after that many messages."""
        drive = DriveWriter(path.open("xb"), self.provenance(vehicle_id))
        for number, (topic, message, received_ns) in enumerate(rows, start=1):
            drive.add(topic, message if isinstance(message, bytes) else encode(message), received_ns)
            if flush_every and number % flush_every == 0:
                drive.flush()
        drive.close()
        return path

    def imu_rows(self, count: int, start_ns: int = 0) -> list[Row]:
        return [("imu", self.imu(start_ns + number * 10_000_000), start_ns + number * 10_000_000) for number in range(count)]


@pytest.fixture(scope="session")
def build() -> Build:
    return Build()


@pytest.fixture
def recorded(build: Build, tmp_path: Path) -> Callable[..., Path]:
    """recorded(rows, **options) -> path of a new whole recording."""
    made = 0

    def make(rows: Iterable[Row], **options: Any) -> Path:
        nonlocal made
        made += 1
        return build.recording(tmp_path / f"made-{made}.mcap", rows, **options)

    return make
