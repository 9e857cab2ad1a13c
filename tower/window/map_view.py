"""The route around the car, its heading up: road, site, people, plan, goal. Draws a MapView, knows no truth but the scene."""

from functools import lru_cache
from math import cos, sin

import numpy as np
import numpy.typing as npt

from tower.window.fonts import MEDIUM
from tower.window.ink import XY, Ink
from tower.window.looks import AMBER, TURQUOISE
from tower.window.palette import DIM, TEXT, Rgba
from tower.window.views import MapView
from wire.messages.automation import RoadMap, Scene, TrackedObject
from wire.road import Road

Points = npt.NDArray[np.float64]
_UNITS_PER_M = 3.8  # 248 x 214 units show 65 x 56 m
_CAR_AT: XY = (124.0, 162.0)  # the road ahead has most of the room
_NEAR_M = 120.0  # along the road, where a bend brings it back into view
_STEP_M = 2.5  # between points of the road's edges: an arc of 45 m radius is off by less than 2 cm
_ASPHALT: Rgba = (92, 101, 112, 255)
_SIDEWALK: Rgba = (55, 63, 73, 255)
_LINE: Rgba = (170, 178, 188, 150)
_PLAN: Rgba = (*TURQUOISE, 235)
_CORRIDOR: Rgba = (255, 255, 255, 60)
_SITE: Rgba = (245, 140, 40, 255)
_PERSON: Rgba = (255, 226, 120, 255)
_OTHER: Rgba = (150, 170, 200, 255)
_TROUBLE: Rgba = (*AMBER, 255)


class _Geometry:
    """A road as point rows in the map frame, sampled once per map."""

    def __init__(self, road_map: RoadMap) -> None:
        road = Road(road_map)
        count = min(int(road.length_m / _STEP_M) + 2, 4000)
        stations = np.linspace(0.0, road.length_m, count)
        walk = road.half_width_m + road_map.sidewalk_width_m

        def row(offset_m: float) -> Points:
            return np.array([road.to_world(float(station), offset_m)[:2] for station in stations])

        self.stations = stations
        self.walks = (row(walk), row(-walk))
        self.kerbs = (row(road.half_width_m), row(-road.half_width_m))
        self.centre = row(0.0)
        self.goal = tuple(np.array(road.to_world(road_map.goal_station_m, side * road.half_width_m)[:2]) for side in (-1, 1))
        self.goal_station_m = road_map.goal_station_m


@lru_cache(maxsize=2)
def _geometry(road_map: RoadMap) -> _Geometry:
    return _Geometry(road_map)


class _Up:
    """Map frame -> design units with the car's heading up."""

    def __init__(self, scene: Scene) -> None:
        c, s = cos(scene.heading_rad), sin(scene.heading_rad)
        self._turn = np.array([[s, -c], [-c, -s]]) * _UNITS_PER_M  # right of the car, then down the screen
        self._at = np.array([scene.x_m, scene.y_m])

    def rows(self, points: Points) -> Points:
        return np.asarray((points - self._at) @ self._turn.T + _CAR_AT)

    def point(self, x_m: float, y_m: float) -> XY:
        x, y = self.rows(np.array([[x_m, y_m]]))[0]
        return float(x), float(y)


def draw_map(ink: Ink, view: MapView) -> None:
    ink.panel()
    scene = view.scene
    if scene is None:
        ink.text("No scene from the car", 124, 112, 18, DIM, MEDIUM, "centre")
        return
    up = _Up(scene)
    if view.road_map is not None:
        _draw_road(ink, _geometry(view.road_map), up, scene.station_m)
    _draw_path(ink, scene.stopping_corridor, up, 9.0, _CORRIDOR)
    _draw_path(ink, scene.plan, up, 3.0, _PLAN)
    for thing in scene.objects:
        _draw_object(ink, thing, up)
    if view.trouble is not None:
        _draw_trouble(ink, up.point(*view.trouble))
    _draw_car(ink, view)
    _draw_distance(ink, view, scene)
    ink.trim()


def _draw_road(ink: Ink, road: _Geometry, up: _Up, station_m: float) -> None:
    """Only what lies within NEAR_M along the road: the rest is outside the map, unless the road comes back."""
    first, last = np.searchsorted(road.stations, (station_m - _NEAR_M, station_m + _NEAR_M))
    near = slice(max(int(first) - 1, 0), int(last) + 2)
    for (left, right), colour in ((road.walks, _SIDEWALK), (road.kerbs, _ASPHALT)):
        ink.polygon(_within(np.vstack([up.rows(left[near]), up.rows(right[near])[::-1]])), colour)
    ink.line(_within(up.rows(road.centre[near])), 1.2, _LINE)
    begin, end = (tuple(up.rows(point[None])[0]) for point in road.goal)
    for i in range(8):
        a, b = i / 8, (i + 1) / 8
        ink.line(
            [(begin[0] + (end[0] - begin[0]) * t, begin[1] + (end[1] - begin[1]) * t) for t in (a, b)],
            4,
            TEXT if i % 2 else (20, 24, 30, 255),
        )


def _within(points: Points) -> Points:
    """Far points pulled in: a road of kilometres must not leave OpenCV's range of coordinates."""
    return np.clip(points, -5000.0, 5000.0)


def _draw_path(ink: Ink, path: tuple[tuple[float, float], ...], up: _Up, thick: float, colour: Rgba) -> None:
    if len(path) > 1:
        ink.line(_within(up.rows(np.array(path))), thick, colour)


def _draw_object(ink: Ink, thing: TrackedObject, up: _Up) -> None:
    x, y = up.point(thing.x_m, thing.y_m)
    radius = round(min(max(thing.radius_m * _UNITS_PER_M, 2.5), 40.0), 1)
    ink.sign(x, y, radius + _RIM, _SIGNS.get(thing.kind, _unknown), radius)


_RIM = 3.0  # of the signs, beyond an object's radius


def _person(ink: Ink, radius: float) -> None:
    ink.disc(0, 0, radius + 1.5, (20, 24, 30, 255))
    ink.disc(0, 0, radius, _PERSON)


def _cone(ink: Ink, _: float) -> None:
    ink.polygon([(0, -4), (3.6, 2.6), (-3.6, 2.6)], _SITE)


def _barrier(ink: Ink, radius: float) -> None:
    ink.box(-radius, -2, 2 * radius, 4, _SITE, 1)


def _vehicle(ink: Ink, radius: float) -> None:
    ink.box(-radius / 2, -radius, radius, 2 * radius, _OTHER, 2)


def _unknown(ink: Ink, radius: float) -> None:
    ink.ring(0, 0, radius, 1.6, _OTHER)


_SIGNS = {"person": _person, "cone": _cone, "barrier": _barrier, "vehicle": _vehicle}


def _trouble(ink: Ink) -> None:
    ink.ring(0, 0, 9, 2.4, _TROUBLE)
    ink.line([(0, -4), (0, 0.5)], 2.2, _TROUBLE)
    ink.disc(0, 4, 1.4, _TROUBLE)


def _draw_trouble(ink: Ink, at: XY) -> None:
    """At the edge of the map when it lies beyond it."""
    ink.sign(min(max(at[0], 14), 234), min(max(at[1], 14), 200), 11.0, _trouble)


def _draw_car(ink: Ink, view: MapView) -> None:
    x, y = _CAR_AT
    half, long = max(view.car_width_m * _UNITS_PER_M / 2, 3.2), max(view.car_length_m * _UNITS_PER_M, 11.0)
    half, long = min(half, 12.0), min(long, 50.0)
    ink.polygon(
        [
            (x, y - long * 0.86),
            (x + half + 1.6, y - long * 0.45),
            (x + half + 1.6, y + long * 0.3),
            (x - half - 1.6, y + long * 0.3),
            (x - half - 1.6, y - long * 0.45),
        ],
        (13, 17, 23, 255),
    )
    ink.polygon(
        [
            (x, y - long * 0.76),
            (x + half, y - long * 0.42),
            (x + half, y + long * 0.22),
            (x - half, y + long * 0.22),
            (x - half, y - long * 0.42),
        ],
        TEXT,
    )


def _draw_distance(ink: Ink, view: MapView, scene: Scene) -> None:
    if view.road_map is not None:
        left = view.road_map.goal_station_m - scene.station_m
        ink.box(8, 181, 128, 27, (13, 17, 23, 190), 7)
        ink.text(f"Goal {left:.0f} m" if left > 1 else "Goal", 16, 201, 18, TEXT, MEDIUM, room=114)
    if scene.deviation_m >= 0.5:
        ink.box(150, 181, 90, 27, (13, 17, 23, 190), 7)
        ink.text(f"± {min(scene.deviation_m, 999):.1f} m", 232, 201, 18, _TROUBLE, MEDIUM, "right", room=78)
