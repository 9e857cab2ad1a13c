"""Puts what the planner among people weighs into a foxglove.SceneUpdate: the layers of a crossing and of a real drive alike. Pure.

Places are (x_m, y_m) in the map frame.
"""

from collections.abc import Iterable, Sequence
from math import cos, sin
from typing import Any

from wire.planner_colours import INK, PERSON, STANDS, Rgb
from wire.scene_schema import DELETE_ALL, LINE_LIST, LINE_LOOP, LINE_STRIP, SceneUpdate

Places = Sequence[Sequence[float]]
FRAME = "map"
TALL_M = 1.7  # of a person
GRAPH_Z_M, WAY_Z_M, CHOSEN_Z_M = 0.01, 0.03, 0.06  # one above the other: no flicker
NANOSECONDS = 1_000_000_000


def new_scene(time_ns: int) -> Any:
    """Takes away what was there, so that each scene stands alone. time_ns: Unix time."""
    update = SceneUpdate()
    _stamp(update.deletions.add(type=DELETE_ALL).timestamp, time_ns)
    return update


def new_entity(update: Any, name: str, time_ns: int) -> Any:
    entity = update.entities.add(frame_id=FRAME, id=name)
    _stamp(entity.timestamp, time_ns)
    return entity


def draw_person(entity: Any, label: str, radius_m: float, means_m: Places, rings_m: Iterable[Places]) -> None:
    """Where it is now, where it will be, and the ellipses around that; who stands has one mean."""
    stands = len(means_m) == 1
    pillar(entity, means_m[0], radius_m, STANDS if stands else PERSON, 0.9)
    if stands:
        return
    line(entity, means_m, 0.04, PERSON)
    for ring in rings_m:
        line(entity, ring, 0.03, PERSON, 0.6, LINE_LOOP)
    text = entity.texts.add(text=label, billboard=True, font_size=0.6)
    place(text.pose, means_m[0], TALL_M + 0.4)
    paint(text.color, INK)


def draw_guidance(entity: Any, places_m: Places, colour: Rgb) -> None:
    """Dotted: every second piece of it."""
    line(entity, _in_pairs(places_m), 0.08, colour, 0.7, LINE_LIST, WAY_Z_M)


def draw_trajectory(entity: Any, places_m: Places, colour: Rgb, feasible: bool, chosen: bool) -> None:
    """The chosen one thick; the others whole when they may be driven, else every second piece."""
    if chosen:
        line(entity, places_m, 0.2, colour, 1.0, LINE_STRIP, CHOSEN_Z_M)
    elif feasible:
        line(entity, places_m, 0.08, colour, 0.9, LINE_STRIP, WAY_Z_M)
    else:
        line(entity, _in_pairs(places_m), 0.08, colour, 0.9, LINE_LIST, WAY_Z_M)


def pillar(entity: Any, at_m: Sequence[float], radius_m: float, colour: Rgb, share: float) -> None:
    made = entity.cylinders.add(bottom_scale=1.0, top_scale=1.0)
    place(made.pose, at_m, TALL_M / 2)
    made.size.x, made.size.y, made.size.z = 2 * radius_m, 2 * radius_m, TALL_M
    paint(made.color, colour, share)


def line(
    entity: Any, places_m: Places, thick_m: float, colour: Rgb, share: float = 1.0, kind: int = LINE_STRIP, z_m: float = 0.0
) -> None:
    made = entity.lines.add(type=kind, thickness=thick_m)
    place(made.pose, (0.0, 0.0), z_m)
    paint(made.color, colour, share)
    for x, y in places_m:
        made.points.add(x=x, y=y)


def place(pose: Any, at_m: Sequence[float], z_m: float, heading_rad: float = 0.0) -> None:
    pose.position.x, pose.position.y, pose.position.z = float(at_m[0]), float(at_m[1]), z_m
    pose.orientation.z, pose.orientation.w = sin(heading_rad / 2), cos(heading_rad / 2)


def paint(color: Any, colour: Rgb, share: float = 1.0) -> None:
    color.r, color.g, color.b = (part / 255 for part in colour)
    color.a = share


def _in_pairs(places_m: Places) -> Places:
    return places_m[: len(places_m) // 2 * 2]


def _stamp(stamp: Any, time_ns: int) -> None:
    stamp.seconds, stamp.nanos = divmod(time_ns, NANOSECONDS)
