"""What the gate would have changed of real driving, and why: a person on a motorway, and every recorded drive.

The motorway log is comma2k19's example segment (60 s, Toyota RAV4, MIT), found in ../shared/data beside the checkout: the raw
frames of the car's own bus, read by the Toyota's codec as the gateway would read them. With every motion frame (83 Hz) steering
and acceleration as the codec tells them are asked of the gate, as an operator would ask, with no cap. A drive is run again from
its recorded inputs with the gateway of today; beside the share of cycles that a rule changed stands the recorded share. Never
here: a judgement which is right.
"""

import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from benchmarks.cycle import CAR, LIMITS
from benchmarks.figures import Figure, figure
from recordings.errors import RecordingError
from recordings.read import open_recording
from vehicle_gateway.can.frame import Frame
from vehicle_gateway.can.layout import LEAST_PERIOD_MS
from vehicle_gateway.can.toyota_codec import toyota_codec
from vehicle_gateway.can.toyota_layout import toyota_layouts
from vehicle_gateway.cycle import NO_CAP_M_S, step
from vehicle_gateway.gate import gate
from vehicle_gateway.replay import begin
from vehicle_gateway.state import Inputs
from wire.messages.base import UNDECODABLE, decoder
from wire.messages.vehicle import Actuation

NAME = "gate"
SHARED = Path(__file__).resolve().parents[2] / "shared/data/comma2k19/segment40/processed_log/CAN/raw_can"
SESSIONS = Path("sessions")
CAR_BUS = 0  # the log's `src`: heard on the car's bus
CYCLE_MIN_S = LEAST_PERIOD_MS / 1e3  # frames that were logged closer together meet one cycle of the gateway: the newest counts
# Toyota RAV4 2016-18, as opendbc's values.py has it (wheelbase, ratio); lock and the rest are not reached on a motorway.
RAV4 = replace(CAR, wheelbase_m=2.65, steering_ratio=16.88, acceleration_max_m_s2=3.0)
_INPUTS = decoder(Inputs)


class Asked(NamedTuple):
    """One moment of the log."""

    dt_s: float
    speed_m_s: float
    road_wheel_angle_rad: float
    acceleration_m_s2: float


def figures() -> Iterator[Figure]:
    if SHARED.is_dir():
        yield from _shares("a person on a motorway, 60 s", motorway(read_log(SHARED)), None)
    else:
        print(f"{NAME}: no motorway log: lay it to {SHARED.parents[3].name}/ beside this checkout", file=sys.stderr)
    drives = sorted(SESSIONS.glob("*/drive.mcap"), key=lambda path: path.stat().st_mtime)
    replayed = list(_replayed(drives))
    if replayed:
        now, recorded = (sum(counted, Counter[str]()) for counted in zip(*replayed, strict=True))
        yield from _shares(f"{len(replayed)} recorded drives", now, recorded)
    else:
        print(f"{NAME}: no recorded drive in {SESSIONS}/: make one: make demo", file=sys.stderr)


def _replayed(drives: list[Path]) -> Iterator[tuple[Counter[str], Counter[str]]]:
    """Those that this version can read; the others are named."""
    for drive in drives:
        try:
            yield again(drive)
        except (RecordingError, *UNDECODABLE) as error:
            print(f"{NAME}: {drive} is left out: {error}", file=sys.stderr)


def _shares(case: str, counted: Counter[str], recorded: Counter[str] | None) -> Iterator[Figure]:
    """Of all moments, the share that a rule changed; "" counts the moments themselves."""
    total = counted.pop("")
    before = recorded.pop("") if recorded else 0
    yield figure(NAME, case, "moments asked", "", total)
    for rule in sorted({*counted, *(recorded or ())}):
        peer = (f"recorded, of {before}", 100.0 * recorded[rule] / before) if recorded else None
        yield figure(NAME, case, f"changed by {rule}", "%", 100.0 * counted[rule] / total, peer=peer)


def read_log(folder: Path) -> list[Asked]:
    """The raw log as requests: one for every motion frame from the first on with which all parts of the feedback were there."""
    times, sources, identifiers, payloads = (np.load(folder / name) for name in ("t", "src", "address", "data"))
    ours = sources == CAR_BUS
    return asked_of(zip(times[ours].tolist(), identifiers[ours].tolist(), payloads[ours].tolist(), strict=True))


def asked_of(logged: Iterable[tuple[float, int, bytes]]) -> list[Asked]:
    """logged  time [s], identifier and payload of every frame of the bus; numpy has lost the zeros at a payload's end"""
    codec = toyota_codec("", RAV4)
    sizes = {layout.arbitration_id: layout.size for layout in toyota_layouts().values()}
    state, asked = codec.start(), list[Asked]()
    asked_s: float | None = None
    for at_s, identifier, payload in logged:
        frame = Frame(identifier, payload.ljust(sizes.get(identifier, 0), b"\0"))
        before = state.feedback
        state, _ = codec.decode(state, frame)
        told = state.feedback
        if told is None or told is before or (asked_s is not None and at_s - asked_s < CYCLE_MIN_S):
            continue
        if asked_s is not None:
            asked.append(Asked(at_s - asked_s, told.speed_m_s, told.road_wheel_angle_rad, told.acceleration_m_s2))
        asked_s = at_s
    return asked


def motorway(log: list[Asked]) -> Counter[str]:
    """How many moments each rule changed; under "" how many there were."""
    counted: Counter[str] = Counter()
    sent = Actuation(road_wheel_angle_rad=log[0].road_wheel_angle_rad, acceleration_m_s2=log[0].acceleration_m_s2)
    for asked in log:
        request = replace(sent, road_wheel_angle_rad=asked.road_wheel_angle_rad, acceleration_m_s2=asked.acceleration_m_s2)
        result = gate(request, sent, asked.speed_m_s, NO_CAP_M_S, False, asked.dt_s, RAV4, LIMITS.gate)
        sent = result.actuation
        counted.update(("", *result.rules))
    return counted


def again(drive: Path) -> tuple[Counter[str], Counter[str]]:
    """A drive's cycles by today's gateway, and as they were recorded: cycles that each rule changed."""
    now, recorded, start = Counter[str](), Counter[str](), None
    with open_recording(drive) as recording:
        for _, message in recording.messages("gateway_cycle"):
            start = begin(message) if start is None else start
            if start is None:
                continue
            state, outputs = step(start.state, _INPUTS.decode(message.inputs), message.now_ns, start.vehicle, start.limits)
            start = replace(start, state=state)
            now.update(("", *outputs.rules))
            recorded.update(("", *message.rules))
    return now, recorded
