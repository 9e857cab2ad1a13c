"""What the gate would have changed of real driving, and why: a person on a motorway, and the newest recorded drive.

The motorway log is comma2k19's example segment (60 s, Toyota RAV4, MIT), found in ../shared/data beside the checkout: steering
wheel angle and speed at 83 Hz as the car measured them, the acceleration as the slope of the speed over a quarter of a second.
They are asked of the gate as an operator would ask, with no cap. The drive is run again from its recorded inputs with the
gateway of today; beside the share of cycles that a rule changed stands the recorded share. Never here: a judgement which is right.
"""

import math
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from benchmarks.cycle import CAR, LIMITS
from benchmarks.figures import Figure, figure
from recordings.read import open_recording
from vehicle_gateway.cycle import NO_CAP_M_S, step
from vehicle_gateway.gate import gate
from vehicle_gateway.replay import begin
from vehicle_gateway.state import Inputs
from wire.messages.base import decoder
from wire.messages.vehicle import Actuation

NAME = "gate"
SHARED = Path(__file__).resolve().parents[2] / "shared/data/comma2k19/segment40/processed_log/CAN"
SESSIONS = Path("sessions")
SLOPE_S = 0.25  # over which an acceleration is read off the speed: its quantum of 0.01 km/h would be all noise otherwise
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
        print(f"{NAME}: no motorway log: lay it to {SHARED.parents[2].name}/ beside this checkout", file=sys.stderr)
    drives = sorted(SESSIONS.glob("*/drive.mcap"), key=lambda path: path.stat().st_mtime)
    if drives:
        now, recorded = again(drives[-1])
        yield from _shares("the newest recorded drive", now, recorded)
    else:
        print(f"{NAME}: no recorded drive in {SESSIONS}/: make one: make demo", file=sys.stderr)


def _shares(case: str, counted: Counter[str], recorded: Counter[str] | None) -> Iterator[Figure]:
    """Of all moments, the share that a rule changed; "" counts the moments themselves."""
    total = counted.pop("")
    before = recorded.pop("") if recorded else 0
    yield figure(NAME, case, "moments asked", "", total)
    for rule in sorted({*counted, *(recorded or ())}):
        peer = (f"recorded, of {before}", 100.0 * recorded[rule] / before) if recorded else None
        yield figure(NAME, case, f"changed by {rule}", "%", 100.0 * counted[rule] / total, peer=peer)


def read_log(folder: Path) -> list[Asked]:
    """The log as requests; speed and steering come in steps of about 12 ms."""
    times, speeds = np.load(folder / "speed/t"), np.load(folder / "speed/value")[:, 0]
    angles_deg = np.interp(times, np.load(folder / "steering_angle/t"), np.load(folder / "steering_angle/value"))
    slopes = (np.interp(times + SLOPE_S / 2, times, speeds) - np.interp(times - SLOPE_S / 2, times, speeds)) / SLOPE_S
    return [
        Asked(float(dt), float(speed), math.radians(angle) / RAV4.steering_ratio, float(slope))
        for dt, speed, angle, slope in zip(np.diff(times), speeds[1:], angles_deg[1:], slopes[1:], strict=True)
    ]


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
