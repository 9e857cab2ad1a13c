"""One frame of the operator's window: from messages to the finished surface, as CPU time of the drawing thread.

A drive made by hand: every number of it moves as in a real one (states with every picture, scenes at 10 Hz, the graph at 5,
pictures at 27), so that a part is drawn again as often as there. Front, left and right pictures are there already: decoding and
the screen's flip are not measured. The floor, in the same run: those pictures alone.
"""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, sin
from time import thread_time_ns

os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

import cv2
import numpy as np
import pygame

from benchmarks.figures import Figure, figure
from tower.window.age_history import Sample
from tower.window.course import Motion
from tower.window.drive_log import DriveLog
from tower.window.forecast import Forecast
from tower.window.hud import Hud
from tower.window.picture_age import PictureSeen
from tower.window.picture_layout import FRONT, LEFT, RIGHT, Box
from tower.window.pictures import Pictures, Pixels
from tower.window.replay_ring import ReplayRing
from tower.window.sights import Sights
from tower.window.view_model import view_model
from wire.configuration import read_sections, shipped
from wire.latest import Received
from wire.messages.automation import Reason, RoadMap, Scene, TakeoverRequest, TrackedObject
from wire.messages.base import Gear, Indicators
from wire.messages.operating import OperatorStatus
from wire.messages.vehicle import Actuation, GatewayStatus, HandOver, Mode, VehicleDescription, VehicleState
from wire.road import Road
from wire.scenario import read_map

NAME = "window"
FRAMES, RATE_HZ, SIZE = 270, 27.0, (1280, 720)
REACH_MS = 5.0  # ours: at 27 Hz an eighth of a core
S = 1_000_000_000
CAR: VehicleDescription = read_sections(shipped("simulated.toml"), {"vehicle": VehicleDescription})["vehicle"]
MAP: RoadMap = read_map(shipped("maps", "bend.toml"))
ROAD = Road(MAP)
REQUEST = TakeoverRequest(
    number=1,
    raised_ns=1,
    budget_s=15.0,
    place=ROAD.to_world(150.0, -1.75)[:2],
    reasons=(
        Reason(channel="planner", text="the lane is closed 38 m ahead: 2 static objects; the oncoming lane is not allowed"),
        Reason(channel="map", text="the map shows a free lane where 2 static objects stand, from 38 m ahead"),
    ),
)


@dataclass(frozen=True, slots=True, eq=False)
class _Still:
    """A picture that was decoded and scaled before."""

    image: Pixels
    capture_ns: int = 1
    decoded_ns: int = 1

    @property
    def shape(self) -> tuple[int, int]:
        return self.image.shape[1], self.image.shape[0]

    def pixels(self, part: Box | None, size: tuple[int, int]) -> Pixels:
        return np.ascontiguousarray(cv2.resize(self.image, size).astype(np.uint8, copy=False))


def figures() -> Iterator[Figure]:
    """Mean CPU milliseconds of a frame, by who drives, beside the pictures alone."""
    cv2.setNumThreads(1)  # as the window does
    rng = np.random.default_rng(0)
    frames = {name: _Still(rng.integers(0, 255, (360, 640, 4), np.uint8)) for name in (FRONT, LEFT, RIGHT)}
    for mode in (Mode.AUTONOMOUS, Mode.TAKEOVER_REQUESTED, Mode.REMOTE):
        ours, alone = _timed(mode, frames)
        yield figure(NAME, f"{mode}, three cameras", "mean", "ms CPU", ours, peer=("the pictures alone", alone), at_most=REACH_MS)
    yield figure(NAME, "ten times a second", "a small picture kept", "ms CPU", _kept())


def _timed(mode: Mode, frames: dict[str, _Still]) -> tuple[float, float]:
    surface, hud, pictures = pygame.Surface(SIZE), Hud(), Pictures()
    ours, alone = [], []
    for number in range(FRAMES):
        seen = _sights(mode, number)
        begin_ns = thread_time_ns()
        model = view_model(seen)
        hud.draw(surface, frames, model)
        ours.append(thread_time_ns() - begin_ns)
        begin_ns = thread_time_ns()
        pictures.draw(surface, frames, hud.at.pictures, model.cameras, dark=False)
        alone.append(thread_time_ns() - begin_ns)
    return _mean_ms(ours), _mean_ms(alone)


def _mean_ms(times_ns: list[int]) -> float:
    """Without the first second, in which everything is drawn for the first time."""
    steady = times_ns[round(RATE_HZ) :]
    return sum(steady) / len(steady) / 1e6


def _kept() -> float:
    ring, image, times = ReplayRing(), np.zeros((720, 1280, 4), np.uint8), []
    for number in range(300):
        begin_ns = thread_time_ns()
        ring.keep(image, number * S // 10)
        times.append(thread_time_ns() - begin_ns)
    return _mean_ms(times[100:])  # once the ring has been filled


def _sights(mode: Mode, number: int) -> Sights:
    now = 1000 * S + round(number * S / RATE_HZ)
    t = number / RATE_HZ
    speed, angle = 5 + 2 * sin(t), 0.1 * sin(1.3 * t) + 0.002 * cos(40 * t)
    tenths, fifths = int(t * 10), int(t * 5)
    return Sights(
        now_ns=now,
        status=Received(_status(mode, now, t), now),
        state=Received(_state(now, speed, angle, t), now),
        operator=Received(_operator(mode, now, angle, t), now),
        scene=Received(_scene(1000 * S + tenths * S // 10, 100 + tenths * 0.5, 5.0), now),
        road_map=MAP,
        description=CAR,
        pictures={name: PictureSeen(now - 80_000_000, now) for name in (FRONT, LEFT, RIGHT)},
        history=tuple(
            Sample(1000 * S + (fifths - k) * S // 5, 80 + (fifths + k) % 9, 130 + k % 11, 4) for k in reversed(range(100))
        ),
        motions=tuple(Motion(now - (10 - k) * S // 50, speed, angle) for k in range(10)),
        forecast=Forecast(expected_ms=110, worst_ms=160, seconds=60, first_m_s=4.17, cap_m_s=8.33),
        log=DriveLog(),
    )


def _status(mode: Mode, now_ns: int, t: float) -> GatewayStatus:
    asks = mode is Mode.TAKEOVER_REQUESTED
    return GatewayStatus(
        stamp_ns=now_ns,
        boot_id="b",
        mode=mode,
        mode_since_ns=1,
        cause="",
        lease_holder="demo",
        lease_epoch=3,
        hand_over=HandOver(number=0, action="", state="", rule=""),
        request=REQUEST if asks else None,
        budget_remaining_s=max(15.0 - t, 0.0) if asks else 0.0,
        guard_remaining_s=0.0,
        hand_back_ready=False,
        hand_back_note="the reason of the take-over is still there",
        take_refused="",
        failsafe="",
        stop_number=0,
        stops_in_ten_minutes=0,
        dropped={},
    )


def _state(now_ns: int, speed_m_s: float, angle_rad: float, t: float) -> VehicleState:
    asked = Actuation(road_wheel_angle_rad=1.05 * angle_rad, acceleration_m_s2=0.8 * sin(t))
    return VehicleState(
        stamp_ns=now_ns,
        boot_id="b",
        sequence=1,
        speed_m_s=speed_m_s,
        acceleration_m_s2=0.0,
        yaw_rate_rad_s=0.0,
        road_wheel_angle_rad=angle_rad,
        gear=Gear.DRIVE,
        requested=asked,
        applied=Actuation(road_wheel_angle_rad=angle_rad, acceleration_m_s2=0.7 * sin(t)),
        rules=("jerk",) if int(t) % 3 == 0 else (),
        speed_cap_m_s=8.33,
        loop_age_ms=130.0,
        command_age_ms=4.0,
    )


def _operator(mode: Mode, now_ns: int, angle_rad: float, t: float) -> OperatorStatus:
    return OperatorStatus(
        stamp_ns=now_ns,
        operator="demo",
        device="keyboard",
        lease_epoch=3,
        lease_note="",
        dead_man=mode is not Mode.AUTONOMOUS,
        armed=True,
        wheel_phase="align",
        steering_wheel_angle_rad=14 * angle_rad,
        steering_wheel_torque=0.0,
        alignment_error_rad=sin(t),
        throttle=0.0,
        brake=0.0,
        road_wheel_angle_rad=1.05 * angle_rad,
        acceleration_m_s2=0.0,
        gear=Gear.DRIVE,
        indicators=Indicators.OFF,
        hazard=False,
        horn=False,
        hand_over_note="",
        stop_number=0,
        stop_state="",
        clock_offset_ns=0,
        clock_bound_ns=1_000_000,
        round_trip_ms=40.0,
    )


def _scene(stamp_ns: int, station_m: float, speed_m_s: float) -> Scene:
    x, y, heading = ROAD.to_world(station_m, -1.75)
    return Scene(
        stamp_ns=stamp_ns,
        x_m=x,
        y_m=y,
        heading_rad=heading,
        speed_m_s=speed_m_s,
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=station_m,
        offset_m=-1.75,
        objects=tuple(_object(number, station_m) for number in range(13)),
        plan=tuple(ROAD.to_world(station_m + 1.5 * k, -1.75)[:2] for k in range(30)),
        stopping_corridor=tuple(ROAD.to_world(station_m + 1.5 * k, -1.75)[:2] for k in range(7)),
    )


def _object(number: int, station_m: float) -> TrackedObject:
    kind = ("cone", "cone", "barrier", "person")[number % 4]
    x, y, _ = ROAD.to_world(station_m + 5 + 2.5 * number, (-3.0, 0.0, 4.8)[number % 3])
    return TrackedObject(
        number=number,
        kind=kind,
        x_m=x,
        y_m=y,
        velocity_x_m_s=0.0,
        velocity_y_m_s=0.0,
        radius_m=0.3,
        deviation_m=0.1,
        static=kind != "person",
        age_s=3.0,
    )
