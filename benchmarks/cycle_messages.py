"""Messages as both sides send them while a car drives on a straight road: what the gateway's cycle is fed in benchmarks.

Plausible and full-sized; the stamps are those of a link without loss, pictures 60 ms old.
"""

from math import cos, sin
from typing import TypeVar

from vehicle_gateway.cycle import speed_of
from vehicle_gateway.state import State
from wire.messages.automation import AutonomyCommand, AutonomyStatus, Doubt, Evidence, Scene, TrackedObject
from wire.messages.base import Gear, Indicators, Message, decoder, encode
from wire.messages.operating import DriveCommand
from wire.messages.session import Action, HandOverRequest
from wire.messages.vehicle import Mode, VehicleDescription

TRACKED = 24  # about what the demo's street has: people, cones, barriers
# 31 points: 30 m in steps of 1 m, all that the automation ever sends (autonomy.planning.corridor)
BOOT, CORRIDOR_POINTS, CHANNELS = "benchmark", 31, ("planner", "map", "localization", "perception", "weather", "sensors")
ECHO_NS, PICTURE_NS = 20_000_000, 60_000_000
M = TypeVar("M", bound=Message)


def decoded(message: M) -> M:
    """As it comes from the link."""
    return decoder(type(message)).decode(encode(message))


def command(now_ns: int, sequence: int, epoch: int, mode: Mode, car: VehicleDescription) -> DriveCommand:
    """Of an operator who steers gently while he drives, and holds still otherwise."""
    driving = mode is Mode.REMOTE
    return DriveCommand(
        lease_epoch=epoch,
        sequence=sequence,
        sent_ns=now_ns,
        event_ns=now_ns,
        echoed_vehicle_ns=max(now_ns - ECHO_NS, 0),
        echoed_boot_id=BOOT,
        displayed_capture_ns={camera.name: max(now_ns - PICTURE_NS, 0) for camera in car.cameras},
        road_wheel_angle_rad=0.02 * sin(now_ns / 1e9) if driving else 0.0,
        acceleration_m_s2=0.2 if driving else 0.0,
        gear=Gear.DRIVE,
        indicators=Indicators.OFF,
        hazard=False,
        horn=False,
        dead_man=True,
        hmac="0" * 64,
    )


def autonomy_command(now_ns: int, number: int) -> AutonomyCommand:
    return AutonomyCommand(stamp_ns=now_ns, sequence=number, road_wheel_angle_rad=0.0, acceleration_m_s2=0.2)


def status(now_ns: int, number: int) -> AutonomyStatus:
    evidence = tuple(Evidence(channel=name, level=0.1, high=False, text="as it should be") for name in CHANNELS)
    return AutonomyStatus(
        stamp_ns=now_ns,
        sequence=number,
        healthy=True,
        health_note="",
        doubt=Doubt.NOMINAL,
        evidence=evidence,
        request=None,
        clear_s=20.0,
        drivable_s=20.0,
        state_matched=True,
        match_note="",
        goal_reached=False,
    )


def scene(now_ns: int, state: State) -> Scene:
    """A straight corridor of 1 m steps from where the gateway's own odometry has the car, a row of people on either side."""
    at = state.odometry
    points = tuple((at.x_m + ahead * cos(at.heading_rad), at.y_m + ahead * sin(at.heading_rad)) for ahead in range(CORRIDOR_POINTS))
    return Scene(
        stamp_ns=now_ns,
        x_m=at.x_m,
        y_m=at.y_m,
        heading_rad=at.heading_rad,
        speed_m_s=speed_of(state),
        yaw_rate_rad_s=0.0,
        deviation_m=0.1,
        station_m=0.0,
        offset_m=0.0,
        objects=tuple(_beside(state, number) for number in range(TRACKED)),
        plan=(),
        stopping_corridor=points,
    )


def _beside(state: State, number: int) -> TrackedObject:
    """Rows 3 m to the left and right of the car, every second pair walking along with it."""
    at, ahead, left = state.odometry, 2.0 * (number // 2) - 5.0, 3.0 if number % 2 else -3.0
    c, s, walk_m_s = cos(at.heading_rad), sin(at.heading_rad), 1.4 * (number // 2 % 2)
    return TrackedObject(
        number=number,
        kind="person",
        x_m=at.x_m + ahead * c - left * s,
        y_m=at.y_m + ahead * s + left * c,
        velocity_x_m_s=walk_m_s * c,
        velocity_y_m_s=walk_m_s * s,
        radius_m=0.3,
        deviation_m=0.1,
        static=walk_m_s == 0.0,
        age_s=5.0,
    )


def question(action: Action, number: int, now_ns: int, state: State) -> HandOverRequest:
    return HandOverRequest(
        lease_epoch=state.lease.epoch,
        number=number,
        action=action,
        sent_ns=now_ns,
        echoed_vehicle_ns=now_ns - ECHO_NS,
        echoed_boot_id=BOOT,
    )
