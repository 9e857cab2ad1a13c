"""A View as a foxglove.SceneUpdate: takes away what was there and puts up the whole cycle, so that each stands alone. Pure."""

from math import atan2, cos, sin
from typing import Any

import numpy as np

from autonomy.car_shape import CarShape
from autonomy.planner_view.colours import Rgb
from autonomy.planner_view.layers import Person, View, Way
from autonomy.planner_view.pens import CAR, GRAPH, INK, PERSON, UNSEEN, WALL
from autonomy.planner_view.scene_schema import DELETE_ALL, LINE_LIST, LINE_LOOP, LINE_STRIP, SceneUpdate
from autonomy.planning.horizon import Floats

FRAME = "map"
TALL_M, CAR_TALL_M = 1.7, 1.5
GRAPH_Z_M, WAY_Z_M, CHOSEN_Z_M = 0.01, 0.03, 0.06  # one above the other: no flicker
NANOSECONDS = 1_000_000_000


def scene_update(view: View, shape: CarShape, time_ns: int) -> Any:
    """The message; time_ns is the Unix time it stands for."""
    update = SceneUpdate()
    _stamp(update.deletions.add(type=DELETE_ALL).timestamp, time_ns)
    for name, draw in (("street", _street), ("people", _people), ("guidance", _guidance), ("trajectories", _trajectories)):
        draw(_entity(update, name, time_ns), view)
    _car(_entity(update, "car", time_ns), view, shape)
    return update


def _entity(update: Any, name: str, time_ns: int) -> Any:
    entity = update.entities.add(frame_id=FRAME, id=name)
    _stamp(entity.timestamp, time_ns)
    return entity


def _stamp(stamp: Any, time_ns: int) -> None:
    stamp.seconds, stamp.nanos = divmod(time_ns, NANOSECONDS)


def _street(entity: Any, view: View) -> None:
    street = view.street
    for edge in (street.left_m, street.right_m):
        _line(entity, edge, 0.08, INK)
    _line(entity, street.goal_m, 0.15, INK)
    for wall in street.walls_m:
        _line(entity, wall, 0.2, WALL)


def _people(entity: Any, view: View) -> None:
    for person in view.people:
        _person(entity, person)
    for place in view.unseen_m:
        _pillar(entity, place, 0.3, UNSEEN, 0.35)


def _person(entity: Any, person: Person) -> None:
    _pillar(entity, person.means_m[0], person.radius_m, WALL if person.stands else PERSON, 0.9)
    if person.stands:
        return
    _line(entity, person.means_m, 0.04, PERSON)
    for ring in person.two_sigma_m:
        _line(entity, ring, 0.03, PERSON, 0.6, LINE_LOOP)
    text = entity.texts.add(text=person.label, billboard=True, font_size=0.6)
    _place(text.pose, person.means_m[0], TALL_M + 0.4)
    _paint(text.color, INK)


def _guidance(entity: Any, view: View) -> None:
    if len(view.graph_m):
        _line(entity, view.graph_m.reshape(-1, 2), 0.02, GRAPH, 0.7, LINE_LIST, GRAPH_Z_M)
    for way in view.ways:
        if way.guidance_m is not None:
            _line(entity, way.guidance_m[: len(way.guidance_m) // 2 * 2], 0.08, way.colour, 0.7, LINE_LIST, WAY_Z_M)


def _trajectories(entity: Any, view: View) -> None:
    for way in view.ways:
        if way.chosen:
            _line(entity, way.trajectory_m, 0.2, way.colour, 1.0, LINE_STRIP, CHOSEN_Z_M)
            for corners in view.swept_m:
                _line(entity, corners, 0.03, way.colour, 0.8, LINE_LOOP, WAY_Z_M)
        elif len(way.trajectory_m):
            _other(entity, way)


def _other(entity: Any, way: Way) -> None:
    """Whole when it may be driven, else every second piece of it."""
    kind = LINE_STRIP if way.feasible else LINE_LIST
    _line(entity, way.trajectory_m[: len(way.trajectory_m) // 2 * 2], 0.08, way.colour, 0.9, kind, WAY_Z_M)


def _car(entity: Any, view: View, shape: CarShape) -> None:
    ahead = view.car_m[0] - view.car_m[3]
    cube = entity.cubes.add()
    _place(cube.pose, view.car_m.mean(axis=0), CAR_TALL_M / 2, atan2(ahead[1], ahead[0]))
    cube.size.x, cube.size.y, cube.size.z = shape.front_m + shape.rear_m, 2 * shape.half_width_m, CAR_TALL_M
    _paint(cube.color, CAR, 0.6)


def _pillar(entity: Any, place_m: Floats, radius_m: float, colour: Rgb, share: float) -> None:
    pillar = entity.cylinders.add(bottom_scale=1.0, top_scale=1.0)
    _place(pillar.pose, place_m, TALL_M / 2)
    pillar.size.x, pillar.size.y, pillar.size.z = 2 * radius_m, 2 * radius_m, TALL_M
    _paint(pillar.color, colour, share)


def _line(
    entity: Any, points_m: Floats, thick_m: float, colour: Rgb, share: float = 1.0, kind: int = LINE_STRIP, z_m: float = 0.0
) -> None:
    line = entity.lines.add(type=kind, thickness=thick_m)
    _place(line.pose, np.zeros(2), z_m)
    _paint(line.color, colour, share)
    for x, y in points_m.tolist():
        line.points.add(x=x, y=y)


def _place(pose: Any, at_m: Floats, z_m: float, heading_rad: float = 0.0) -> None:
    pose.position.x, pose.position.y, pose.position.z = float(at_m[0]), float(at_m[1]), z_m
    pose.orientation.z, pose.orientation.w = sin(heading_rad / 2), cos(heading_rad / 2)


def _paint(color: Any, colour: Rgb, share: float = 1.0) -> None:
    color.r, color.g, color.b = (part / 255 for part in colour)
    color.a = share
