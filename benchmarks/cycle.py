"""One gateway cycle, pure: what arrived on CAN decoded, authority, failsafe and gate, and the CAN frames packed.

A stream of inputs is made once by a closed loop of `step` with a car of its own (rates of the topic table, every message
through the codec as it comes from the link) and then fed through again, each cycle timed. So the cycle and its inputs are
real, the arrival is not. The floor, timed beside each cycle: decoding one DriveCommand with msgspec and protecting one frame.
Not measured here: signature check, link, journal, operating system.
"""

import gc
from collections.abc import Iterator
from math import tan
from time import perf_counter_ns
from typing import NamedTuple

from msgspec.structs import replace

from benchmarks.cycle_messages import BOOT, autonomy_command, command, decoded, question, scene, status
from benchmarks.figures import Figure, figure, percentile
from benchmarks.machine import priority
from benchmarks.wheel_to_can import camera_status
from vehicle_gateway.can.codec import FOLLOWING, FeedbackState, decode, encode_command
from vehicle_gateway.can.e2e import protect
from vehicle_gateway.can.ecu_codec import Controls, Motion, encode_controls, encode_drive_state, encode_motion
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.cycle import step
from vehicle_gateway.settings import VehicleGatewaySettings, limits_with_map
from vehicle_gateway.state import GatewayLimits, Inputs, State, initial_state
from wire.configuration import read_sections, shipped
from wire.messages.base import Gear, decoder, encode
from wire.messages.operating import DriveCommand
from wire.messages.session import Action, LeaseRequest
from wire.messages.vehicle import Mode, VehicleDescription
from wire.settings import PaceSettings

NAME = "cycle"
CYCLE_NS = 6_000_000  # about 170 Hz, as in a drive: commands and deadlines together
DRIVE_S = 12.0  # of each mode
REACH_US = 300.0
FIFO_PRIORITY = PaceSettings().fifo_priority
_SECTIONS = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription, "vehicle_gateway": VehicleGatewaySettings})
CAR: VehicleDescription = _SECTIONS["vehicle"]
LIMITS: GatewayLimits = limits_with_map(_SECTIONS["vehicle_gateway"], shipped("simulated.toml"))
_COMMAND = decoder(DriveCommand)


class Moment(NamedTuple):
    """What one cycle works on."""

    now_ns: int
    frames: tuple[Frame, ...]
    inputs: Inputs


def figures() -> Iterator[Figure]:
    """p50 and p99 of a cycle while the automation and while the operator drives, plain and as the gateway asks to be scheduled."""
    for mode in (Mode.AUTONOMOUS, Mode.REMOTE):
        start, moments = stream(mode)
        for fifo_priority in (0, FIFO_PRIORITY):
            with priority(fifo_priority) as scheduling:
                cycles, floors = timed(start, moments, mode)
            for what, share in (("p50", 0.50), ("p99", 0.99)):
                floor = ("decode one command, protect one frame", percentile(floors, share))
                reach = REACH_US if what == "p99" else None
                yield figure(NAME, f"{mode}, {scheduling}", what, "us", percentile(cycles, share), peer=floor, at_most=reach)


def timed(start: State, moments: list[Moment], mode: Mode) -> tuple[list[float], list[float]]:
    """Microseconds of every cycle that ends in `mode`, and of the floor beside each."""
    cycles, floors = [], []
    state, feedback = start, FeedbackState()
    payload = encode(command(0, 1, 1, Mode.REMOTE, CAR))
    gc.collect()
    gc.freeze()  # as the gateway does
    for number, moment in enumerate(moments):
        begin_ns = perf_counter_ns()
        for frame in moment.frames:
            feedback, _ = decode(feedback, frame)
        state, outputs = step(state, moment.inputs, moment.now_ns, CAR, LIMITS)
        encode_command(outputs.applied, outputs.mode, outputs.brake_hold, number)
        done_ns = perf_counter_ns()
        _COMMAND.decode(payload)
        protect(0x1001, b"\x01\x02\x03\x04\x05\x06")
        floor_ns = perf_counter_ns()
        if state.authority.mode is mode:
            cycles.append((done_ns - begin_ns) / 1e3)
            floors.append((floor_ns - done_ns) / 1e3)
    gc.unfreeze()
    return cycles, floors


def stream(mode: Mode) -> tuple[State, list[Moment]]:
    """The state to start with, and a drive that reaches `mode` and stays there."""
    now_ns = 1_000_000_000_000
    start = state = initial_state(BOOT, now_ns, 1, emergency_latched=False)
    feedback, angle, speed, moments = FeedbackState(), 0.0, 0.0, []
    for number in range(round(DRIVE_S * 1e9 / CYCLE_NS)):
        now_ns += CYCLE_NS
        frames = _frames(number, speed, angle)
        for frame in frames:
            feedback, _ = decode(feedback, frame)
        inputs = _inputs(number, now_ns, state, mode)
        inputs = replace(inputs, feedback=feedback.feedback if frames else None)
        state, outputs = step(state, inputs, now_ns, CAR, LIMITS)
        if outputs.send:
            angle = outputs.applied.road_wheel_angle_rad
            speed = max(speed + outputs.applied.acceleration_m_s2 * CYCLE_NS / 1e9, 0.0)
        moments.append(Moment(now_ns, frames, inputs))
    return start, moments


def _every(number: int, rate_hz: float) -> bool:
    """Whether a topic of this rate is due in this cycle."""
    period_ns = 1e9 / rate_hz
    return (number * CYCLE_NS) // period_ns != ((number - 1) * CYCLE_NS) // period_ns


def _frames(number: int, speed_m_s: float, angle_rad: float) -> tuple[Frame, ...]:
    """The ECU's feedback: motion at 100 Hz, the rest at 50 Hz; each frame counts its own kind."""
    half, full = int(number * CYCLE_NS * 50 // 10**9), int(number * CYCLE_NS * 100 // 10**9)
    yaw_rate = speed_m_s * tan(angle_rad) / CAR.wheelbase_m
    slow = (encode_drive_state(Gear.DRIVE, FOLLOWING, speed_m_s == 0.0, half), encode_controls(Controls(), half))
    fast = (encode_motion(Motion(speed_m_s, angle_rad, 0.0, yaw_rate), full),)
    return slow * _every(number, 50) + fast * _every(number, 100)


def _inputs(number: int, now_ns: int, state: State, mode: Mode) -> Inputs:
    """Both sides talk at their rates, whoever drives; the lease and the take-over are asked for as soon as they can be."""
    fields: dict[str, object] = {}
    if number == 0:
        fields["lease_requests"] = (LeaseRequest(operator="ann", session="s", sent_ns=1),)
    if _every(number, 100):
        driven = Mode.REMOTE if state.authority.mode is Mode.REMOTE else Mode.STANDBY  # the take-over wants the pedal released
        fields |= {"command": decoded(command(now_ns, number + 1, state.lease.epoch, driven, CAR)), "command_ns": now_ns - 500_000}
        fields["autonomy"] = decoded(autonomy_command(now_ns, number))
    if _every(number, 20):
        fields["autonomy_status"] = decoded(status(now_ns, number))
    if _every(number, 10):
        fields["scene"] = decoded(scene(now_ns, state))
    if _every(number, 5):
        fields["cameras"] = tuple(decoded(camera_status(camera.name, number, now_ns)) for camera in CAR.cameras)
    if mode is Mode.REMOTE and state.authority.mode in (Mode.STANDBY, Mode.AUTONOMOUS) and number % 20 == 10:
        fields["hand_over_requests"] = (question(Action.TAKE, number, now_ns, state),)
    return Inputs(**fields)  # type: ignore[arg-type]
