"""The figures of a drive, computed from its recording and from nothing else. Pure but for reading it.

A figure that cannot be had from the recording is null. Written as summary.json beside the recording when it ends, and
by `recordings info --json`: both are this same computation.
"""

from typing import Protocol

from recordings import summary_cameras, summary_counts, summary_latency, summary_loops, summary_modes
from recordings.drive import RowSource, collect
from recordings.summary_latency import Camera, Motion, Percentiles, WheelToCan
from recordings.summary_loops import Load, Loop
from recordings.summary_modes import Takeover
from wire.messages.base import Message, Seconds


class About(Message):
    path: str
    messages: int
    topics: dict[str, int]  # messages per channel; "video/front" is a camera


class Summary(Message):
    recording: About
    versions: dict[str, str]
    drive_s: Seconds | None  # from the first to the last message
    distance_m: float | None
    modes_s: dict[str, float] | None
    takeovers: tuple[Takeover, ...] | None
    collisions: int | None  # by the referee; a real car has none
    goal_reached: bool | None  # by the referee
    gate_interventions: dict[str, int] | None  # episodes per rule
    loop_age_ms: Percentiles | None
    motion_to_motion_ms: Motion | None = None  # told since the car measures its actuators
    cameras: dict[str, Camera]
    command_rate_hz: float | None
    wheel_to_can_ms: WheelToCan | None
    messages_dropped: dict[str, int]
    loops: dict[str, Loop]  # "process/loop"
    load: Load | None  # CPU of the processes


class Summarizable(RowSource, Protocol):
    """What is needed of `recordings.read.Recording`."""

    @property
    def path(self) -> object: ...
    @property
    def topics(self) -> dict[str, int]: ...
    @property
    def versions(self) -> dict[str, str]: ...
    @property
    def span_ns(self) -> tuple[int, int] | None: ...


def summarize(recording: Summarizable) -> Summary:
    """All figures of one recording. Raises RecordingError where it cannot be read."""
    topics, span = recording.topics, recording.span_ns
    drive = collect(recording)
    return Summary(
        recording=About(path=str(recording.path), messages=sum(topics.values()), topics=topics),
        versions=recording.versions,
        drive_s=(span[1] - span[0]) / 1e9 if span else None,
        distance_m=summary_counts.distance_m(drive.speeds),
        modes_s=summary_modes.seconds_by_mode(drive.statuses),
        takeovers=summary_modes.takeovers(drive.statuses, span[0] if span else 0),
        collisions=max((truth.collisions for truth in drive.referee), default=None),
        goal_reached=any(truth.goal_reached for truth in drive.referee) if drive.referee else None,
        gate_interventions=summary_counts.gate_interventions(drive.cycles),
        loop_age_ms=summary_latency.loop_age(drive.cycles),
        motion_to_motion_ms=summary_latency.motion_to_motion(drive.motions, drive.statuses),
        cameras=summary_latency.cameras(drive.shown, drive.offsets, summary_cameras.giving(drive.cameras)),
        command_rate_hz=summary_latency.command_rate_hz(drive.commands),
        wheel_to_can_ms=summary_latency.wheel_to_can(drive.cycles, drive.commands, drive.offsets),
        messages_dropped=summary_counts.messages_dropped(drive.statuses, drive.health),
        loops=summary_loops.loops(drive.health),
        load=summary_loops.load(drive.health),
    )
