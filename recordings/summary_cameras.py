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
    lowest_hz: float | None  # the least it might take; None: it has told no rate
    rests: bool  # it runs only while it is wanted


def giving(rows: Sequence[CameraRow]) -> dict[str, Giving]:
    """By camera, from every camera_status in order of arrival."""
    by_camera: dict[str, list[CameraRow]] = {}
    for row in rows:
        by_camera.setdefault(row.status.camera, []).append(row)
    return {name: _giving(found) for name, found in sorted(by_camera.items())}


def _giving(rows: Sequence[CameraRow]) -> Giving:
    reduced_ns = sum(
        after.log_ns - before.log_ns
        for before, after in zip(rows, rows[1:], strict=False)
        if before.status.rate_hz < before.status.nominal_hz and after.log_ns - before.log_ns <= _GAP_NS
    )
    rates = [row.status.rate_hz for row in rows if row.status.nominal_hz > 0]
    return Giving(
        skipped=counted([row.status.skipped for row in rows]),
        reduced_s=reduced_ns / _SECOND_NS,
        lowest_hz=min(rates, default=None),
        rests=any(not row.status.wanted for row in rows),
    )
