"""One drive of a tracker along a track: sensors that are late, commands that are late, and what became of it. 100 Hz, car 1 kHz."""

import gc
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, hypot, sin, sqrt
from time import thread_time_ns

from autonomy.control.mpcc.reference import Reference, along, foot, square_at
from autonomy.control.mpcc.state import Measured
from autonomy.planning.mpc.line import piece_of, spot
from benchmarks.tracker_cars import Plant, Truth
from benchmarks.tracker_tracks import Track, path_of, speeds_of

CYCLE_MS = 10
MEASURED_MS = 10  # age of a measured state when the tracker reads it: half a period of 50 Hz wheel speeds, and the link
SENT_MS = 20  # from the tracker's command to the actuators: link, a cycle of the gateway, CAN, the ECU, the plant's batches
SECONDS_MAX = 400.0

Controller = Callable[[Measured, int], tuple[float, float]]  # measured, now_ns -> road wheel angle, acceleration


@dataclass(frozen=True, slots=True, kw_only=True)
class Noise:
    """Standard deviations of what is measured, white."""

    position_m: float = 0.0
    heading_rad: float = 0.0
    speed_m_s: float = 0.0
    yaw_rate_rad_s: float = 0.0
    acceleration_m_s2: float = 0.0


@dataclass
class Drive:
    """Per cycle, from the first motion to the last."""

    contour_m: list[float] = field(default_factory=list)
    course_rad: list[float] = field(default_factory=list)  # direction of the rear axle's motion against the path's
    speed_m_s: list[float] = field(default_factory=list)  # against what is wanted at the place
    lateral_m_s2: list[float] = field(default_factory=list)
    stations_m: list[float] = field(default_factory=list)
    cycles_ms: list[float] = field(default_factory=list)
    arrived: bool = False


def reference_of(track: Track) -> Reference:
    reference = along(path_of(track), *speeds_of(track))
    assert reference is not None
    return reference


def drive(
    reference: Reference,
    plant: Plant,
    controller: Controller,
    noise: Noise | None = None,
    seconds_max: float = SECONDS_MAX,
) -> Drive:
    """Until the car stands at the end of the reference, or time is over."""
    told, rng = Drive(), random.Random(1)
    state = plant.start
    seen = [plant.look(state)] * (MEASURED_MS + 1)
    queue: list[tuple[int, float, float]] = [(0, seen[0].road_wheel_angle_rad, 0.0)]
    gc.collect()
    for ms in range(round(seconds_max * 1000)):
        if ms % CYCLE_MS == 0:
            measured = measured_of(seen[0], ms - MEASURED_MS, noise, rng)
            begin = thread_time_ns()
            angle, acceleration = controller(measured, (ms + 1000) * 1_000_000)
            told.cycles_ms.append((thread_time_ns() - begin) / 1e6)
            queue.append((ms + SENT_MS, angle, acceleration))
            if note(told, seen[-1], reference):
                told.arrived = True
                break
        while len(queue) > 1 and queue[1][0] <= ms:
            queue.pop(0)
        state = plant.advance(state, queue[0][1], queue[0][2])
        seen = [*seen[1:], plant.look(state)]
    return told


def measured_of(truth: Truth, ms: int, noise: Noise | None, rng: random.Random) -> Measured:
    """No lateral speed: nobody measures it."""
    n = noise or Noise()
    return Measured(
        stamp_ns=(ms + 1000) * 1_000_000,
        x_m=truth.x_m + rng.gauss(0.0, n.position_m),
        y_m=truth.y_m + rng.gauss(0.0, n.position_m),
        heading_rad=truth.heading_rad + rng.gauss(0.0, n.heading_rad),
        speed_m_s=truth.speed_m_s + rng.gauss(0.0, n.speed_m_s),
        yaw_rate_rad_s=truth.yaw_rate_rad_s + rng.gauss(0.0, n.yaw_rate_rad_s),
        road_wheel_angle_rad=truth.road_wheel_angle_rad,
        acceleration_m_s2=truth.acceleration_m_s2 + rng.gauss(0.0, n.acceleration_m_s2),
    )


def note(told: Drive, truth: Truth, reference: Reference) -> bool:
    """The errors of the truth; whether it has arrived."""
    near = told.stations_m[-1] if told.stations_m else 0.0
    station = foot(reference.line, truth.x_m, truth.y_m, truth.heading_rad, near, 10.0)
    there = spot(reference.line, station, piece_of(reference.line, station, 0))
    told.stations_m.append(station)
    told.contour_m.append(there.tangent_x * (truth.y_m - there.y) - there.tangent_y * (truth.x_m - there.x))
    c, s = cos(truth.heading_rad), sin(truth.heading_rad)
    vx, vy = truth.speed_m_s * c - truth.lateral_m_s * s, truth.speed_m_s * s + truth.lateral_m_s * c
    across = there.tangent_x * vy - there.tangent_y * vx
    told.course_rad.append(across / max(hypot(vx, vy), 1.0))
    wanted = sqrt(square_at(reference.stations_m, reference.squares_m2_s2, station)[0])
    told.speed_m_s.append(truth.speed_m_s - wanted)
    told.lateral_m_s2.append(truth.speed_m_s * truth.yaw_rate_rad_s)
    return station > reference.last_m - 1.0 and truth.speed_m_s == 0.0
