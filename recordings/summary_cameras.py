"""What the car said of its cameras: pictures that were not taken in time, and frame rate given up for the rest of the car. Pure."""

from collections.abc import Sequence

from recordings.counters import counted
from recordings.drive import CameraRow
from wire.messages.base import Message

_GAP_NS = 1_000_000_000  # camera_status comes at 5 Hz: over a longer silence nobody knows
_SECOND_NS = 1e9


class Giving(Message):
    skipped: int  # pictures that came and were not taken in time
    reduced_s: float  # time in which it might take fewer than its own rate, because the machine could not keep up
    halved_s: float  # of it, with half its width and height
    lowest_hz: float | None  # the least it might take; None: it has told no rate
    rests: bool  # it runs only while it is wanted


def giving(rows: Sequence[CameraRow]) -> dict[str, Giving]:
    """By camera, from every camera_status in order of arrival."""
    by_camera: dict[str, list[CameraRow]] = {}
    for row in rows:
        by_camera.setdefault(row.status.camera, []).append(row)
    return {name: _giving(found) for name, found in sorted(by_camera.items())}


def _giving(rows: Sequence[CameraRow]) -> Giving:
    told = [
        (before.status, (after.log_ns - before.log_ns) / _SECOND_NS)
        for before, after in zip(rows, rows[1:], strict=False)
        if after.log_ns - before.log_ns <= _GAP_NS
    ]
    rates = [row.status.rate_hz for row in rows if row.status.nominal_hz > 0]
    return Giving(
        skipped=counted([row.status.skipped for row in rows]),
        reduced_s=sum(passed_s for status, passed_s in told if status.rate_hz < status.nominal_hz),
        halved_s=sum(passed_s for status, passed_s in told if status.halved),
        lowest_hz=min(rates, default=None),
        rests=any(not row.status.wanted for row in rows),
    )
