"""How old pictures and commands were, and how often they came. Pure.

Across the two clocks only with the tower's own measured offset (the newest one told before), and with its bound.
Percentiles interpolate linearly between the sorted values, as numpy does.
"""

from bisect import bisect_right
from collections.abc import Mapping, Sequence

import numpy as np

from recordings.drive import CommandRow, CycleRow, MotionRow, OffsetRow, ShownRow, StatusRow
from recordings.summary_cameras import Giving
from wire.messages.base import Message
from wire.messages.vehicle import Mode

_MS = 1e6  # nanoseconds
_SECOND_NS = 1e9
_OPERATOR_DRIVES = frozenset({Mode.REMOTE, Mode.HANDING_BACK})


class Percentiles(Message):
    p50: float
    p95: float
    p99: float


class Camera(Message):
    fps: float | None  # of the frames that came on screen, from the first to the last of them
    latency_ms: Percentiles | None  # from capture to screen, across the two clocks
    skipped: int | None = None  # pictures that the car did not take in time
    reduced_s: float | None = None  # time in which it had to give up frame rate: the machine could not keep up
    halved_s: float | None = None  # of it, with half its width and height
    lowest_hz: float | None = None  # the least it might take meanwhile


class WheelToCan(Message):
    p50: float
    p99: float
    clock_bound_ms: float  # the largest bound of the offsets used: every value is within +- this


class Motion(Message):
    """Motion to motion, and what of it the car itself took at the end of the drive."""

    p50: float
    p95: float
    p99: float
    bound_ms: float  # the largest that was told: every value is within +- this
    steering_ms: float
    steering_measured: bool  # false: the configured default
    acceleration_ms: float
    acceleration_measured: bool


def loop_age(cycles: Sequence[CycleRow]) -> Percentiles | None:
    """The perceive-act loop on the vehicle clock alone, as the car judged it: from the picture's capture to the command's arrival.

    With camera and screen as they are configured, and the car's own answer where its owner wants it. One value per new command
    while the operator drove. A command that names no picture has no such age.
    """
    return _percentiles(
        [cycle.loop_age_ms for cycle in cycles if cycle.new_command and cycle.mode in _OPERATOR_DRIVES and cycle.loop_age_ms > 0]
    )


def motion_to_motion(motions: Sequence[MotionRow], statuses: Sequence[StatusRow]) -> Motion | None:
    """While the operator drove, as the car told it with its state."""
    driven = [row.said for row in motions if _mode_at(statuses, row.log_ns) in _OPERATOR_DRIVES]
    spread = _percentiles([said.total_ms for said in driven])
    if spread is None:
        return None
    last = driven[-1]
    return Motion(
        p50=spread.p50,
        p95=spread.p95,
        p99=spread.p99,
        bound_ms=max(said.bound_ms for said in driven),
        steering_ms=last.steering_ms,
        steering_measured=last.steering_measured,
        acceleration_ms=last.acceleration_ms,
        acceleration_measured=last.acceleration_measured,
    )


def _mode_at(statuses: Sequence[StatusRow], log_ns: int) -> Mode | None:
    at = bisect_right(statuses, log_ns, key=lambda row: row.log_ns)
    return statuses[at - 1].status.mode if at else None


def cameras(shown: Sequence[ShownRow], offsets: Sequence[OffsetRow], given: Mapping[str, Giving]) -> dict[str, Camera]:
    """What came on screen, by camera; `given`: what the car said of it."""
    return {
        name: _camera([frame for frame in shown if frame.camera == name], offsets, given.get(name))
        for name in sorted({frame.camera for frame in shown})
    }


def _camera(frames: Sequence[ShownRow], offsets: Sequence[OffsetRow], given: Giving | None) -> Camera:
    latencies = [
        (frame.shown_ns + offset.offset_ns - frame.capture_ns) / _MS
        for frame in frames
        if (offset := _newest(offsets, frame.log_ns)) is not None
    ]
    times = [frame.shown_ns for frame in frames]
    return Camera(
        fps=_rate_while_shown_hz(times) if given is not None and given.rests else _rate_hz(times),
        latency_ms=_percentiles(latencies),
        skipped=given.skipped if given is not None else None,
        reduced_s=given.reduced_s if given is not None else None,
        halved_s=given.halved_s if given is not None else None,
        lowest_hz=given.lowest_hz if given is not None else None,
    )


def _rate_while_shown_hz(times_ns: Sequence[int]) -> float | None:
    """Of a camera that rests in between: intervals above a second are rests."""
    steps = [after - before for before, after in zip(times_ns, times_ns[1:], strict=False) if 0 < after - before <= _SECOND_NS]
    return len(steps) * _SECOND_NS / sum(steps) if steps else None


def command_rate_hz(commands: Sequence[CommandRow]) -> float | None:
    """Mean rate of the commands' arrival in the car, from the first to the last."""
    return _rate_hz([command.log_ns for command in commands])


def wheel_to_can(cycles: Sequence[CycleRow], commands: Sequence[CommandRow], offsets: Sequence[OffsetRow]) -> WheelToCan | None:
    """From the device event to the CAN frame that first carried it; None without commands, cycles or an offset."""
    events = _first_with_event(commands)
    delays_ms, bounds_ns = [], []
    for cycle in cycles:
        command = _closest(events.get(cycle.command_sequence, ()), cycle.log_ns) if cycle.new_command else None
        offset = _newest(offsets, command.log_ns) if command is not None else None
        if command is not None and offset is not None:
            delays_ms.append((cycle.can_sent_ns - command.event_ns - offset.offset_ns) / _MS)
            bounds_ns.append(offset.bound_ns)
    if not delays_ms:
        return None
    p50, p99 = np.percentile(delays_ms, (50, 99))
    return WheelToCan(p50=float(p50), p99=float(p99), clock_bound_ms=max(bounds_ns) / _MS)


def _first_with_event(commands: Sequence[CommandRow]) -> dict[int, list[CommandRow]]:
    """Commands that bring a device event the one before did not have, by sequence (a restarted cockpit counts anew)."""
    found: dict[int, list[CommandRow]] = {}
    previous_event_ns = -1
    for command in commands:
        if command.event_ns != previous_event_ns and command.event_ns > 0:  # 0: the device has not moved yet
            found.setdefault(command.sequence, []).append(command)
        previous_event_ns = command.event_ns
    return found


def _closest(commands: Sequence[CommandRow], log_ns: int) -> CommandRow | None:
    return min(commands, key=lambda command: abs(command.log_ns - log_ns), default=None)


def _newest(offsets: Sequence[OffsetRow], log_ns: int) -> OffsetRow | None:
    """The newest offset that was known at `log_ns`."""
    at = bisect_right(offsets, log_ns, key=lambda row: row.log_ns)
    return offsets[at - 1] if at else None


def _percentiles(values: Sequence[float]) -> Percentiles | None:
    if not values:
        return None
    p50, p95, p99 = np.percentile(values, (50, 95, 99))
    return Percentiles(p50=float(p50), p95=float(p95), p99=float(p99))


def _rate_hz(times_ns: Sequence[int]) -> float | None:
    """Intervals per second between the first and the last; None for fewer than two times."""
    span_ns = max(times_ns) - min(times_ns) if times_ns else 0
    return (len(times_ns) - 1) * _SECOND_NS / span_ns if span_ns > 0 else None
