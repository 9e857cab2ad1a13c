"""A short recorded drive made in simulated time by the rooms' own pure functions, and the tool that falsifies one."""

from collections.abc import Callable, Iterable
from math import sin
from pathlib import Path
from typing import Any

import msgspec
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer

from autonomy.replay import Judged, MonitorInputs, record
from autonomy.uncertainty.channels import Level
from autonomy.uncertainty.monitor import MonitorSettings, MonitorState, Trouble, judge
from haptics import alignment
from haptics.alignment import WheelInputs, WheelState
from haptics.settings import HapticsSettings
from recordings.provenance import Provenance
from recordings.writer import DriveWriter
from tests import messages
from tests.messages import autonomy_status, gateway_status
from tower.cockpit.torque_log import TorqueLog
from vehicle_gateway.cycle import step
from vehicle_gateway.journal import Entry, Journal
from vehicle_gateway.state import AuthorityLimits, GatewayLimits, Inputs, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.automation import AutonomyCommand, AutonomyStatus
from wire.messages.base import Message, encode
from wire.messages.vehicle import GatewayStatus, Mode, VehicleDescription

CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
LIMITS = GatewayLimits(authority=AuthorityLimits(engage_autonomously=True, engage_needs_operator=False))
START_NS = 5_000_000_000
Row = tuple[int, str, bytes]  # received_ns, topic, payload


class Line:
    """The link the journal publishes on: into a list. Heard from cycle `heard_from` on, but not while `deaf`."""

    def __init__(self, heard_from: int = 1, deaf: range = range(0)) -> None:
        self.rows: list[Row] = []
        self._heard_from, self._deaf, self._number = heard_from, deaf, 0

    def is_heard(self, name: str) -> bool:
        self._number += 1
        return self._number >= self._heard_from and self._number not in self._deaf

    def publish(self, name: str, message: Message) -> None:
        if self._number >= self._heard_from and self._number not in self._deaf:
            self.rows.append((message.now_ns, name, encode(message)))  # type: ignore[attr-defined]


def gateway_rows(cycles: int, line: Line, start_ns: int = START_NS) -> list[Row]:
    """A car that sets off by itself; feedback, status and commands of the automation every cycle."""
    state, speed = initial_state(f"boot {start_ns}", start_ns, 100, False), 0.0
    with Journal(line, CAR, LIMITS) as journal:
        for number in range(1, cycles + 1):
            now_ns = start_ns + number * 10_000_000
            inputs = _gateway_inputs(now_ns, number, speed)
            before = state
            state, outputs = step(before, inputs, now_ns, CAR, LIMITS)
            speed = max(speed + outputs.applied.acceleration_m_s2 * 0.01, 0.0)
            journal.keep(Entry(number, now_ns, before, inputs, state, outputs, now_ns + 200_000))
    return line.rows


def _gateway_inputs(now_ns: int, number: int, speed_m_s: float) -> Inputs:
    feedback = messages.feedback(speed_m_s=speed_m_s, yaw_rate_rad_s=0.01 * sin(number / 30))
    command = AutonomyCommand(
        stamp_ns=now_ns, sequence=number, road_wheel_angle_rad=0.05 * sin(number / 50), acceleration_m_s2=0.4 * sin(number / 70)
    )
    return Inputs(feedback=feedback, autonomy=command, autonomy_status=_healthy(now_ns, number))


def _healthy(now_ns: int, number: int) -> AutonomyStatus:
    return autonomy_status(stamp_ns=now_ns, sequence=number)


def monitor_rows(steps: int) -> list[Row]:
    """Doubt that rises, stays, and goes."""
    state, rows, settings = MonitorState(), [], MonitorSettings()
    for number in range(1, steps + 1):
        now_ns = START_NS + number * 100_000_000
        levels = (
            Level("planner", min(number / 30, 1.0) if number < 60 else 0.1, f"closed {number} m ahead"),
            Level("map", 0.2, ""),
        )
        inputs = MonitorInputs(levels=levels, trouble=Trouble(budget_s=8.0 - number / 100, place=(150.0, 2.0 + number / 7)))
        after = judge(state, levels, inputs.trouble, now_ns, settings)
        judged = Judged(number=number, now_ns=now_ns, before=state, inputs=inputs, after=after)
        rows.append((now_ns, "monitor_step", encode(record(judged, settings))))
        state = after
    return rows


def torque_rows(steps: int) -> list[Row]:
    """A wheel that is aligned, driven and let go, 250 steps a second."""
    limits = HapticsSettings().wheel_limits()
    state, log, rows = WheelState(), TorqueLog(limits), []
    for number in range(1, steps + 1):
        now_ns = START_NS + number * 4_000_000
        seen = WheelInputs(
            angle_rad=0.3 * sin(number / 100),
            rate_rad_s=0.75 * sin(number / 90),
            car_angle_rad=0.2 * sin((number - number % 5) / 100),
            telemetry_age_ns=number % 5 * 4_000_000,
            speed_m_s=3.0,
            lateral_m_s2=0.4,
            lock_rad=8.4,
            wanted=number > 100,
            driving=number > 500,
            armed=True,
        )
        before, state = state, alignment.step(state, seen, now_ns, 0.004, limits)
        log.add(before, seen, now_ns, 0.004, state)
        rows += [(now_ns, "torque_steps", encode(batch)) for batch in (log.due(now_ns),) if batch is not None]
    rest = log.rest()
    return rows + ([(now_ns, "torque_steps", encode(rest))] if rest is not None else [])


def write_drive(path: Path, rows: Iterable[Row]) -> Path:
    """A whole recording by the real writer."""
    provenance = Provenance(vehicle_id="car-1", utc_minus_vehicle_ns=10**18, versions={"commit": "abc"}, notes={}, attached=())
    drive = DriveWriter(path.open("xb"), provenance)
    for received_ns, topic, payload in sorted(rows):
        drive.add(topic, payload, received_ns)
    drive.close()
    return path


def rewrite(source: Path, target: Path, change: Callable[[str, dict[str, Any]], None]) -> Path:
    """A copy of a recording with `change(topic, message)` applied to every message, and every checksum made anew."""
    with source.open("rb") as stream, target.open("xb") as out:
        reader, writer = make_reader(stream, validate_crcs=True), Writer(out)
        writer.start(profile="", library="rewritten")
        for found in reader.iter_metadata():
            writer.add_metadata(found.name, found.metadata)
        numbers: dict[str, int] = {}
        for schema, channel, record_ in reader.iter_messages():
            if channel.topic not in numbers:
                number = writer.register_schema(schema.name, schema.encoding, schema.data)
                numbers[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, number, channel.metadata)
            data = record_.data
            if channel.message_encoding == "json":
                message = msgspec.json.decode(data)
                change(channel.topic, message)
                data = msgspec.json.encode(message)
            writer.add_message(numbers[channel.topic], record_.log_time, data, record_.publish_time, record_.sequence)
        writer.finish()
    return target


@pytest.fixture(scope="session")
def whole_drive(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """600 cycles, 90 looks of the monitor, 700 torque steps."""
    rows = gateway_rows(600, Line()) + monitor_rows(90) + torque_rows(700)
    return write_drive(tmp_path_factory.mktemp("drive") / "drive.mcap", rows)


@pytest.fixture(scope="session")
def make() -> Any:
    """The builders above, for tests that need another drive."""

    class Make:
        line, gateway, monitor, torque = Line, staticmethod(gateway_rows), staticmethod(monitor_rows), staticmethod(torque_rows)
        write, rewrite, start_ns = staticmethod(write_drive), staticmethod(rewrite), START_NS

    return Make


@pytest.fixture(scope="session")
def status() -> Callable[[int, Mode, int], GatewayStatus]:
    """status(now_ns, mode, since_ns): what the gateway tells."""

    def told(now_ns: int, mode: Mode, since_ns: int) -> GatewayStatus:
        return gateway_status(
            stamp_ns=now_ns, boot_id="boot", mode=mode, mode_since_ns=since_ns, lease_holder="anna", lease_epoch=1
        )

    return told
