"""What is planned from: the car on its line, the people who count; or the reason why nothing is. Pure; never raises."""

from dataclasses import dataclass
from math import cos, sin

import numpy as np

from autonomy.planning.guidance.line import HIGH, LOW, Line, at, line_of
from autonomy.planning.guidance.people import People, people
from autonomy.planning.guidance.sampling import on_line
from autonomy.planning.guidance.settings import Drive, GuidanceSettings, drive_of
from autonomy.planning.guidance.state import Lack
from autonomy.planning.horizon import HORIZON_S, CarState, Floats, Predictions
from autonomy.planning.reference_path import ReferencePath

LOST_M = 5.0  # farther off the room beside the path nothing is planned
LEFT_M = 0.5  # less path ahead than this is none


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene:
    start: Floats  # node: the car's middle
    heading_rad: float  # of the car
    reach_m: float  # along the line, to where the car would like to be at the horizon's end
    line: Line
    drive: Drive
    who: People


def admitted(
    car: CarState, path: ReferencePath, predictions: Predictions, settings: GuidanceSettings
) -> tuple[Scene | None, Lack | None]:
    """One of the two. Those whose prediction is no number are left out and do not keep the others from being planned for."""
    lack = _unusable(car, path, settings)
    if lack is not None:
        return None, lack
    station = car.station_m + settings.ahead_m
    reach = min(settings.speed_m_s * HORIZON_S, path.last_m - station)
    line = line_of(path, station, reach, settings.half_width_m)
    start = _start(car, line, settings)
    who = people(predictions, line, start, settings)
    drive = drive_of(car.speed_m_s, settings)
    scene = Scene(start=start, heading_rad=car.heading_rad, reach_m=reach, line=line, drive=drive, who=who)
    lack = _hopeless(scene, settings)
    return (scene, None) if lack is None else (None, lack)


def _unusable(car: CarState, path: ReferencePath, settings: GuidanceSettings) -> Lack | None:
    if not np.isfinite((car.x_m, car.y_m, car.heading_rad, car.speed_m_s, car.station_m)).all():
        return Lack.CAR
    return None if _whole(path) and path.last_m - car.station_m - settings.ahead_m > LEFT_M else Lack.PATH


def _whole(path: ReferencePath) -> bool:
    """Whether it has a piece and more, everything for each, and numbers only."""
    pieces = len(path.knots_m) - 1
    coefficients, rooms = (path.x_coefficients, path.y_coefficients), (path.room_left_m, path.room_right_m)
    shaped = pieces > 0 and all(a.shape == (pieces, 4) for a in coefficients) and all(a.shape == (pieces + 1,) for a in rooms)
    return shaped and all(bool(np.isfinite(a).all()) for a in (path.knots_m, *coefficients, *rooms))


def _start(car: CarState, line: Line, settings: GuidanceSettings) -> Floats:
    x = car.x_m + settings.ahead_m * cos(car.heading_rad)
    y = car.y_m + settings.ahead_m * sin(car.heading_rad)
    start = np.array([x, y, 0.0, 0.0, 0.0])
    on_line(line, start[None])
    return start


def _hopeless(scene: Scene, settings: GuidanceSettings) -> Lack | None:
    station, offset = float(scene.start[3]), float(scene.start[4])
    if not at(scene.line, station, LOW) - LOST_M <= offset <= at(scene.line, station, HIGH) + LOST_M:
        return Lack.OFF_ROAD
    return Lack.TOUCHING if scene.who.nearest_m < settings.half_width_m else None
