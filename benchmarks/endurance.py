"""A day of gateway cycles in simulated time: does the state grow, does memory, do its decisions drift?

Every hour is the same story for the same pure `step` as in the car: an operator takes over, drives, hands back, takes over
again; STOP is pressed and cleared. Hour after hour the modes must change at the very same cycles, and the state and the process
must be as large as after the first hour. Beside the cost of a cycle in the last hour stands that of the first one.
`python -m benchmarks endurance` makes 8.64 million cycles, some half an hour of one core. Never here: messages on a link, CAN.
"""

import gc
import os
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import NamedTuple

from benchmarks.cycle import CAR, LIMITS
from benchmarks.cycle_messages import BOOT, autonomy_command, command, question, scene, status
from benchmarks.figures import Figure, figure
from benchmarks.wheel_to_can import camera_status
from vehicle_gateway.can.codec import Feedback
from vehicle_gateway.cycle import step
from vehicle_gateway.state import Inputs, State, initial_state
from wire.messages.base import Gear, encode
from wire.messages.session import Action, LeaseRequest
from wire.messages.vehicle import Actuation, Mode

NAME = "endurance"
HOURS = 24
CYCLE_NS = 10_000_000
SECOND, HOUR = 100, 360_000  # cycles
STORY = (  # from this second of the hour on the operator asks for this, once a second, until the car is in this mode
    (2, Action.TAKE, Mode.REMOTE),
    (1500, Action.HAND_BACK, Mode.AUTONOMOUS),
    (1800, Action.TAKE, Mode.REMOTE),
    (2910, Action.CLEAR, Mode.STOPPED),
    (2915, Action.TAKE, Mode.REMOTE),
    (3300, Action.HAND_BACK, Mode.AUTONOMOUS),
)
STOP_S = 2900
GROWTH_MAX_MB = 1.0  # of the process, from the end of the first hour to that of the last: an allocator's breathing
BIT_OF_TIME = 1.2  # the last hour's cycles may cost so much of the first's: the machine is shared


class Hour(NamedTuple):
    """What one hour was like."""

    changes: tuple[tuple[int, Mode], ...]  # cycle of the hour, mode
    state_bytes: int  # as JSON, at its end
    resident_mb: float
    cycle_us: float  # CPU of this process, inputs and all


def figures() -> Iterator[Figure]:
    """Growth, drift and cost over a day."""
    hours = list(day(HOURS))
    first, last, case = hours[0], hours[-1], f"{HOURS} h, {HOURS * HOUR / 1e6:.2f} million cycles"
    strayed = sum(each.changes != hours[1].changes for each in hours[1:])  # the first hour begins in STANDBY
    yield figure(NAME, case, "hours whose modes changed at other cycles", "hours", strayed, at_most=0.0)
    state = ("after the first hour", float(first.state_bytes))
    yield figure(NAME, case, "state", "bytes", last.state_bytes, peer=state, ratio_at_most=1.01)
    grown_mb = max(last.resident_mb - first.resident_mb, 0.0)
    yield figure(NAME, case, "growth of the process", "MB", grown_mb, at_most=GROWTH_MAX_MB)
    cost = ("in the first hour", first.cycle_us)
    yield figure(NAME, case, "cycle in the last hour", "us", last.cycle_us, peer=cost, ratio_at_most=BIT_OF_TIME)


def day(hours: int, hour_cycles: int = HOUR) -> Iterator[Hour]:
    """Hour after hour of the same story, each told when it is over."""
    now_ns = 1_000_000_000_000
    state, moved = (
        initial_state(BOOT, now_ns, 1, emergency_latched=False),
        Actuation(road_wheel_angle_rad=0.0, acceleration_m_s2=0.0),
    )
    speed = 0.0
    for hour in range(hours):
        changes, began_s = [], process_time()
        for cycle in range(hour_cycles):
            now_ns += CYCLE_NS
            number, mode = hour * hour_cycles + cycle, state.authority.mode
            inputs = inputs_of(number, cycle, now_ns, state, speed, moved)
            state, outputs = step(state, inputs, now_ns, CAR, LIMITS)
            moved = outputs.applied
            speed = max(speed + moved.acceleration_m_s2 * CYCLE_NS / 1e9, 0.0)
            if state.authority.mode is not mode:
                changes.append((cycle, state.authority.mode))
        cycle_us = (process_time() - began_s) / hour_cycles * 1e6
        gc.collect()
        yield Hour(tuple(changes), len(encode(state)), resident_mb(), cycle_us)


def inputs_of(number: int, of_hour: int, now_ns: int, state: State, speed_m_s: float, moved: Actuation) -> Inputs:
    """Both sides at their rates; the car does what it was told a cycle ago."""
    second, of_second = divmod(of_hour, SECOND)
    driven = Mode.REMOTE if state.authority.mode is Mode.REMOTE else Mode.STANDBY
    fields: dict[str, object] = {
        "feedback": feedback(speed_m_s, moved),
        "command": command(now_ns, number + 1, state.lease.epoch, driven, CAR),
        "command_ns": now_ns - 500_000,
        "autonomy": autonomy_command(now_ns, number),
    }
    if number == 0:
        fields["lease_requests"] = (LeaseRequest(operator="ann", session="s", sent_ns=1),)
    if number % 5 == 0:
        fields["autonomy_status"] = status(now_ns, number)
    if number % 10 == 0:
        fields["scene"] = scene(now_ns, state)
    if number % 20 == 0:
        fields["cameras"] = tuple(camera_status(camera.name, number, now_ns) for camera in CAR.cameras)
    if of_second == 0:
        fields |= asked(second, number, now_ns, state)
    return Inputs(**fields)  # type: ignore[arg-type]


def asked(second: int, number: int, now_ns: int, state: State) -> dict[str, object]:
    """What the operator presses in this second of the hour."""
    if second == STOP_S:
        return {"stop_number": number}
    due = [(action, mode) for at, action, mode in STORY if at <= second < STOP_S or at > STOP_S and second >= at]
    if not due:
        return {}
    action, wanted = due[-1]
    done = state.authority.mode is wanted and not (action is Action.CLEAR and state.stop_pressed)
    return {} if done else {"hand_over_requests": (question(action, number + 1, now_ns, state),)}


def feedback(speed_m_s: float, moved: Actuation) -> Feedback:
    angle = moved.road_wheel_angle_rad
    return Feedback(
        speed_m_s=speed_m_s,
        acceleration_m_s2=moved.acceleration_m_s2 if speed_m_s else 0.0,
        yaw_rate_rad_s=speed_m_s * angle / CAR.wheelbase_m,
        road_wheel_angle_rad=angle,
        gear=Gear.DRIVE,
        ecu_following=True,
        brake_holding=speed_m_s == 0.0,
        seat_occupied=False,
        driver_torque_nm=0.0,
        driver_brake=0.0,
        emergency_button=False,
        release_button=False,
    )


def resident_mb() -> float:
    """Of this process now (Linux: proc(5), statm, second figure)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6
