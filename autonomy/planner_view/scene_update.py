"""A View as a foxglove.SceneUpdate: takes away what was there and puts up the whole cycle, so that each stands alone. Pure."""

from math import atan2
from typing import Any

from autonomy.car_shape import CarShape
from autonomy.planner_view.layers import Person, View
from autonomy.planner_view.pens import CAR, GRAPH, UNSEEN, WALL
from wire.planner_colours import INK
from wire.scene_draw import (
    GRAPH_Z_M,
    WAY_Z_M,
    draw_guidance,
    draw_person,
    draw_trajectory,
    line,
    new_entity,
    new_scene,
    paint,
    pillar,
    place,
)
from wire.scene_schema import LINE_LIST, LINE_LOOP

CAR_TALL_M = 1.5


def scene_update(view: View, shape: CarShape, time_ns: int) -> Any:
    """The message; time_ns is the Unix time it stands for."""
    update = new_scene(time_ns)
    for name, draw in (("street", _street), ("people", _people), ("guidance", _guidance), ("trajectories", _trajectories)):
        draw(new_entity(update, name, time_ns), view)
    _car(new_entity(update, "car", time_ns), view, shape)
    return update


def _street(entity: Any, view: View) -> None:
    street = view.street
    for edge in (street.left_m, street.right_m):
        line(entity, edge.tolist(), 0.08, INK)
    line(entity, street.goal_m.tolist(), 0.15, INK)
    for wall in street.walls_m:
        line(entity, wall.tolist(), 0.2, WALL)


def _people(entity: Any, view: View) -> None:
    for person in view.people:
        _person(entity, person)
    for at in view.unseen_m.tolist():
        pillar(entity, at, 0.3, UNSEEN, 0.35)


def _person(entity: Any, person: Person) -> None:
    means = person.means_m[:1] if person.stands else person.means_m
    draw_person(entity, person.label, person.radius_m, means.tolist(), person.two_sigma_m.tolist())


def _guidance(entity: Any, view: View) -> None:
    if len(view.graph_m):
        line(entity, view.graph_m.reshape(-1, 2).tolist(), 0.02, GRAPH, 0.7, LINE_LIST, GRAPH_Z_M)
    for way in view.ways:
        if way.guidance_m is not None:
            draw_guidance(entity, way.guidance_m.tolist(), way.colour)


def _trajectories(entity: Any, view: View) -> None:
    for way in view.ways:
        if way.chosen or len(way.trajectory_m):
            draw_trajectory(entity, way.trajectory_m.tolist(), way.colour, way.feasible, way.chosen)
        if way.chosen:
            for corners in view.swept_m:
                line(entity, corners.tolist(), 0.03, way.colour, 0.8, LINE_LOOP, WAY_Z_M)


def _car(entity: Any, view: View, shape: CarShape) -> None:
    ahead = view.car_m[0] - view.car_m[3]
    cube = entity.cubes.add()
    place(cube.pose, view.car_m.mean(axis=0), CAR_TALL_M / 2, atan2(ahead[1], ahead[0]))
    cube.size.x, cube.size.y, cube.size.z = shape.front_m + shape.rear_m, 2 * shape.half_width_m, CAR_TALL_M
    paint(cube.color, CAR, 0.6)
