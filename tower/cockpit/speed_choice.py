"""How fast the scripted operator wants to go: the slowest of many reasons, and room to stop for what is or comes in the way. Pure.

Everything is judged along the path across the road that the operator has in mind; distances count from the front bumper.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import atan, cos, inf, sin, sqrt
from typing import Annotated

from msgspec import Meta

from tower.cockpit.surroundings import Moving, Standing
from tower.cockpit.way_around import WayAround
from wire.messages.base import Message
from wire.messages.vehicle import VehicleDescription

Speed = Annotated[float, Meta(gt=0.0, le=20.0)]
Side = Callable[[float], float]  # side_m of the path at a station


class SpeedSettings(Message):
    speed_max_m_s: Speed = 5.0
    change_m_s: Speed = 3.5  # while changing lanes and beside what blocks
    below_cap_m_s: Annotated[float, Meta(ge=0.0, le=5.0)] = 0.3  # kept under the car's cap, so that the gate need not bite
    lateral_max_m_s2: Speed = 1.5
    braking_m_s2: Speed = 1.2  # planned with
    gain_1_s: Annotated[float, Meta(gt=0.1, le=10.0)] = 1.2
    traction_max_m_s2: Speed = 1.2
    hard_braking_m_s2: Annotated[float, Meta(gt=1.0, le=10.0)] = 5.0
    person_gap_m: Annotated[float, Meta(ge=0.5, le=20.0)] = 3.0  # bumper to person when stopped for
    thing_gap_m: Annotated[float, Meta(ge=0.5, le=20.0)] = 1.5
    clearance_m: Annotated[float, Meta(ge=0.0, le=2.0)] = 0.25  # less than this beside a standing thing: blocked
    person_clearance_m: Annotated[float, Meta(ge=0.0, le=3.0)] = 0.7
    look_m: Annotated[float, Meta(gt=5.0, le=100.0)] = 35.0
    oncoming_m: Annotated[float, Meta(gt=5.0, le=200.0)] = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ahead:
    """The way in front, as the operator has it in mind."""

    station_m: float  # of the rear axle, where the car is by now
    speed_m_s: float
    side: Side
    way: WayAround | None
    curvature_1_m: float  # of the road here and a little ahead, the larger
    cap_m_s: float
    end_m: float  # where the drive ends: the goal's station
    standing: Sequence[Standing]
    moving: Sequence[Moving]


def wanted_acceleration(ahead: Ahead, car: VehicleDescription, settings: SpeedSettings) -> float:
    """m/s2, negative brakes. With nowhere to go: enough to hold the car."""
    nearest = min(_stops(ahead, car, settings), default=inf)
    target = min(_cruise(ahead, settings), _towards(nearest, settings.braking_m_s2))
    if target < 0.1 and ahead.speed_m_s < 0.3:
        return -1.5  # holds on any street
    gap = settings.gain_1_s * (target - ahead.speed_m_s)
    needed = ahead.speed_m_s**2 / (2 * max(nearest, 0.3)) if nearest < inf else 0.0
    if needed > settings.braking_m_s2:  # planning was overtaken by events
        gap = min(gap, -1.2 * needed)
    return min(max(gap, -settings.hard_braking_m_s2), settings.traction_max_m_s2)


def _cruise(ahead: Ahead, settings: SpeedSettings) -> float:
    bend = sqrt(settings.lateral_max_m_s2 / max(abs(ahead.curvature_1_m), 1e-4))
    free = min(settings.speed_max_m_s, ahead.cap_m_s - settings.below_cap_m_s, bend)
    if ahead.way is None or ahead.station_m > ahead.way.home_m:
        return max(free, 0.5)
    # the sharper the change, the slower
    sharpness = min((ahead.way.full_m - ahead.way.begin_m) / 14.0, 1.0)
    slow = settings.change_m_s * sharpness if ahead.station_m < ahead.way.full_m else settings.change_m_s
    before = ahead.way.begin_m - ahead.station_m
    return max(min(free, slow if before <= 0 else sqrt(slow**2 + 2 * settings.braking_m_s2 * before)), 0.5)


def _towards(distance_m: float, braking_m_s2: float) -> float:
    """The speed from which the car stops in this distance; a little is left for the last metre."""
    return sqrt(2 * braking_m_s2 * distance_m) if distance_m > 0.15 else 0.0


def _stops(ahead: Ahead, car: VehicleDescription, settings: SpeedSettings) -> Iterator[float]:
    """How far the bumper may still go, for each reason to stop."""
    yield ahead.end_m - ahead.station_m
    front_m = car.wheelbase_m + (car.length_m - car.wheelbase_m - car.rear_overhang_m)  # ahead of the rear axle
    bumper = ahead.station_m + front_m
    for thing in ahead.standing:
        if bumper + 0.3 < thing.station_m < ahead.station_m + settings.look_m and is_blocked(
            ahead.side, thing, car, front_m, settings.clearance_m
        ):
            yield thing.station_m - bumper - settings.thing_gap_m
    for mover in ahead.moving:
        if mover.is_vehicle:
            yield from _oncoming(ahead, mover, bumper, settings)
        elif _comes_in_the_way(ahead, mover, car, bumper, settings):
            yield max(mover.station_m - mover.radius_m - bumper - settings.person_gap_m, 0.0)


def is_blocked(side: Side, thing: Standing, car: VehicleDescription, front_m: float, clearance_m: float) -> bool:
    """Whether the car, with its rear axle on the path, would come closer than clearance_m while it passes."""
    needed = car.width_m / 2 + thing.radius_m + clearance_m
    ahead = front_m
    while ahead > -car.rear_overhang_m:
        rear = thing.station_m - ahead
        slope = atan((side(rear + 0.25) - side(rear - 0.25)) / 0.5)
        if abs((thing.side_m - side(rear)) * cos(slope) - ahead * sin(slope)) < needed:
            return True
        ahead -= 0.75
    return False


def _comes_in_the_way(ahead: Ahead, mover: Moving, car: VehicleDescription, bumper_m: float, settings: SpeedSettings) -> bool:
    """Whether a person is, or will be before the car has passed, where the car wants to go."""
    distance = mover.station_m - bumper_m
    if not -0.5 < distance < settings.look_m:
        return False
    band = car.width_m / 2 + mover.radius_m + settings.person_clearance_m
    arrives_s = min(max(distance, 0.0) / max(ahead.speed_m_s, 1.0), 4.0)
    gap = mover.side_m - ahead.side(mover.station_m)
    across = mover.across_m_s if abs(mover.across_m_s) > 0.35 else 0.0  # the noise of a track is not a step
    if abs(gap) < band:
        return True
    reached_s = (abs(gap) - band) / abs(across) if across * gap < 0 else inf
    return reached_s <= arrives_s + 1.5


def _oncoming(ahead: Ahead, mover: Moving, bumper_m: float, settings: SpeedSettings) -> Iterator[float]:
    distance = mover.station_m - bumper_m
    if not -2.0 < distance < settings.oncoming_m:
        return
    if ahead.way is not None and mover.along_m_s < -0.5 and ahead.station_m < ahead.way.back_m:
        # wait in the own lane; once out of it, stop and let the other one decide
        yield max(ahead.way.begin_m - ahead.station_m, 0.0)
    elif abs(mover.side_m - ahead.side(mover.station_m)) < 1.5 + mover.radius_m:
        yield max(distance - settings.person_gap_m - mover.radius_m, 0.0)
